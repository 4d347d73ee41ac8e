// The input mesh: a faint film or a lit solid. Faces may be wound either way.

struct Varyings {
    @builtin(position) position: vec4<f32>,
    @location(0) view: vec3<f32>,
    @location(1) normal: vec3<f32>,
}

fn lifted(position: vec3<f32>, normal: vec3<f32>, height: f32) -> Varyings {
    var out: Varyings;
    let view = (frame.view_from_world * vec4<f32>(position, 1.0)).xyz;
    out.view = view;
    out.normal = (frame.view_from_world * vec4<f32>(normal, 0.0)).xyz;
    let lift = lift_over(height, out.normal, view);
    out.position = frame.clip_from_view * vec4<f32>(nearer(view, lift), 1.0);
    return out;
}

// The film lies on what was fitted to the input.
@vertex
fn vs_ghost(@location(0) position: vec3<f32>, @location(1) normal: vec3<f32>) -> Varyings {
    return lifted(position, normal, FILM);
}

// The solid lies under it.
@vertex
fn vs_solid(@location(0) position: vec3<f32>, @location(1) normal: vec3<f32>) -> Varyings {
    return lifted(position, normal, -FILM);
}

fn towards_camera(in: Varyings, v: vec3<f32>) -> vec3<f32> {
    let n = normalize(in.normal);
    return select(n, -n, dot(n, v) < 0.0);
}

@fragment
fn fs_ghost(in: Varyings) -> @location(0) vec4<f32> {
    let v = view_direction(in.view);
    let n = towards_camera(in, v);
    let edge = pow(1.0 - clamp(dot(n, v), 0.0, 1.0), 2.0);
    let alpha = clamp(frame.ghost_color.a * (0.6 + 3.4 * edge), 0.0, 1.0);
    let shade = 0.75 + 0.25 * n.y;
    return vec4<f32>(frame.ghost_color.rgb * shade * alpha, alpha);
}

@fragment
fn fs_solid(in: Varyings) -> @location(0) vec4<f32> {
    let v = view_direction(in.view);
    let albedo = mix(vec3<f32>(0.52), linear_from_srgb(frame.ghost_color.rgb), 0.12);
    return vec4<f32>(srgb_from_linear(studio(albedo, towards_camera(in, v), v, 0.6)), 1.0);
}
