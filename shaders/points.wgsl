// Points as round splats: one instance a point, a quad each.

struct Varyings {
    @builtin(position) position: vec4<f32>,
    // in pixels from the centre
    @location(0) offset: vec2<f32>,
    @location(1) @interpolate(flat) radius: f32,
    // the alpha of a selected point is a half
    @location(2) @interpolate(flat) color: vec4<f32>,
    // width of the ring around a selected point, in pixels
    @location(3) @interpolate(flat) ring: f32,
}

@vertex
fn vs_main(
    @builtin(vertex_index) corner: u32,
    @location(0) point: vec3<f32>,
    @location(1) color: vec4<f32>,
) -> Varyings {
    var out: Varyings;
    let view = (frame.view_from_world * vec4<f32>(point, 1.0)).xyz;
    let depth = -view.z;
    // Hidden, not finite (marked by a huge coordinate) or behind the camera.
    if (color.a == 0.0 || abs(point.x) > 1e6 || (depth <= 0.0 && frame.eye.w < 0.5)) {
        out.position = vec4<f32>(2.0, 2.0, 2.0, 1.0);
        return out;
    }
    var diameter = frame.params.y;
    if (frame.eye.w < 0.5) {
        // Nearer points are larger, but less so than true spheres would be.
        diameter *= clamp(sqrt(frame.flags.x / depth), 0.4, 3.0);
    }
    var radius = max(0.5 * diameter, 0.5);
    out.ring = 0.0;
    if (color.a < 0.75) {
        radius = max(1.15 * radius, 1.6 * frame.params.x);
        out.ring = 1.3 * frame.params.x;
    }
    // Like a ball, the splat stands out of the surface that it lies on.
    let lifted = nearer(view, (radius + out.ring) * units_per_pixel(depth));
    let clip = frame.clip_from_view * vec4<f32>(lifted, 1.0);
    let unit = vec2<f32>(f32(corner & 1u), f32(corner >> 1u)) * 2.0 - 1.0;
    let offset = unit * (radius + out.ring + 0.75);
    out.position = vec4<f32>(clip.xy + offset * 2.0 * frame.size.zw * clip.w, clip.zw);
    out.offset = offset;
    out.radius = radius;
    out.color = color;
    return out;
}

fn shaded(in: Varyings) -> vec3<f32> {
    let is_selected = in.ring > 0.0;
    let albedo = linear_from_srgb(select(in.color.rgb, frame.selected_color.rgb, is_selected));
    let beyond = length(in.offset) - in.radius;
    if (is_selected && beyond > -0.5) {
        let inner = srgb_from_linear(albedo);
        return mix(inner, vec3<f32>(0.05, 0.045, 0.04), clamp(beyond + 0.5, 0.0, 1.0));
    }
    let xy = in.offset / max(in.radius, 0.5);
    let n = normalize(vec3<f32>(xy * 0.9, sqrt(max(1.0 - 0.81 * dot(xy, xy), 0.05))));
    let ball = studio(albedo, n, vec3<f32>(0.0, 0.0, 1.0), 0.5);
    // A point of few pixels is too small for a shape: it keeps its colour.
    return srgb_from_linear(mix(albedo, ball, smoothstep(1.0, 4.0, in.radius) * 0.85));
}

// The edge's alpha becomes coverage of the pixel's samples.
@fragment
fn fs_coverage(in: Varyings) -> @location(0) vec4<f32> {
    let alpha = clamp(in.radius + in.ring + 0.5 - length(in.offset), 0.0, 1.0);
    if (alpha <= 0.0) {
        discard;
    }
    return vec4<f32>(shaded(in), alpha);
}

// With one sample a pixel the edge is hard.
@fragment
fn fs_hard(in: Varyings) -> @location(0) vec4<f32> {
    if (length(in.offset) > in.radius + in.ring) {
        discard;
    }
    return vec4<f32>(shaded(in), 1.0);
}
