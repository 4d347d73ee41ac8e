// Primitives: lit, opaque or translucent.

struct Varyings {
    @builtin(position) position: vec4<f32>,
    @location(0) view: vec3<f32>,
    @location(1) normal: vec3<f32>,
    @location(2) color: vec4<f32>,
    // x: brightened
    @location(3) look: vec4<f32>,
    // over the primitive's colour, by its alpha
    @location(4) paint: vec4<f32>,
}

@vertex
fn vs_main(
    @location(0) position: vec3<f32>,
    @location(1) normal: vec3<f32>,
    @location(2) color: vec4<f32>,
    @location(3) look: vec4<f32>,
    @location(4) paint: vec4<f32>,
    // of two primitives that share a face, the one of higher level covers it;
    // below 0 for what lies on all of them
    @location(5) level: f32,
) -> Varyings {
    var out: Varyings;
    let view = (frame.view_from_world * vec4<f32>(position, 1.0)).xyz;
    out.normal = (frame.view_from_world * vec4<f32>(normal, 0.0)).xyz;
    // Faces that were fitted to the same surface differ a little, and what
    // rounding does to their depth is more on small scales.
    let step = max(0.0012, units_per_pixel(-view.z) / 64.0);
    let lift = lift_over(select(level * step, FILM, level < 0.0), out.normal, view);
    out.position = frame.clip_from_view * vec4<f32>(nearer(view, lift), 1.0);
    out.view = view;
    out.color = color;
    out.look = look;
    out.paint = vec4<f32>(paint.rgb * paint.a, paint.a);
    return out;
}

fn lit(in: Varyings, n: vec3<f32>, v: vec3<f32>, gloss: f32) -> vec3<f32> {
    let albedo = linear_from_srgb(in.color.rgb * (1.0 - in.paint.a) + in.paint.rgb);
    let brighter = mix(albedo, vec3<f32>(1.0), 0.18 * in.look.x);
    return srgb_from_linear(studio(brighter, n, v, gloss));
}

@fragment
fn fs_solid(in: Varyings) -> @location(0) vec4<f32> {
    return vec4<f32>(lit(in, normalize(in.normal), view_direction(in.view), 1.0), 1.0);
}

// Denser where the surface turns away, like coloured glass.
fn density(n: vec3<f32>, v: vec3<f32>, alpha: f32) -> f32 {
    let edge = pow(1.0 - clamp(dot(n, v), 0.0, 1.0), 3.0);
    return alpha + (1.0 - alpha) * 0.55 * edge;
}

@fragment
fn fs_translucent_front(in: Varyings) -> @location(0) vec4<f32> {
    let n = normalize(in.normal);
    let v = view_direction(in.view);
    let alpha = density(n, v, frame.params.z * in.color.a);
    return vec4<f32>(lit(in, n, v, 1.0) * alpha, alpha);
}

@fragment
fn fs_translucent_back(in: Varyings) -> @location(0) vec4<f32> {
    let n = -normalize(in.normal);
    let v = view_direction(in.view);
    let alpha = 0.6 * density(n, v, frame.params.z * in.color.a);
    return vec4<f32>(lit(in, n, v, 0.0) * 0.8 * alpha, alpha);
}

// Something that is not there yet: stripes on the screen, and a dense rim.
@fragment
fn fs_ghost(in: Varyings) -> @location(0) vec4<f32> {
    let n = normalize(in.normal);
    let v = view_direction(in.view);
    let edge = pow(1.0 - clamp(abs(dot(n, v)), 0.0, 1.0), 2.5);
    let period = 9.0 * frame.params.x * frame.grid_v.w;
    let across = fract((in.position.x + in.position.y) / period) * period;
    let half_width = 0.16 * period;
    let stripe = clamp(half_width + 0.5 - abs(across - 0.5 * period), 0.0, 1.0);
    let alpha = frame.selected_color.a * clamp(0.08 + 0.34 * stripe + 0.75 * edge, 0.0, 1.0);
    let shade = 0.8 + 0.2 * n.y;
    return vec4<f32>(frame.selected_color.rgb * shade * alpha, alpha);
}
