// Straight lines of constant width on the screen: one instance a segment, a
// quad each, with soft edges.

struct Varyings {
    @builtin(position) position: vec4<f32>,
    // in pixels from the line's axis
    @location(0) across: f32,
    @location(1) @interpolate(flat) half_width: f32,
    @location(2) @interpolate(flat) color: vec4<f32>,
}

@vertex
fn vs_main(
    @builtin(vertex_index) corner: u32,
    @location(0) from_point: vec3<f32>,
    @location(1) to_point: vec3<f32>,
    // outward normal of the surface that the line lies on, or 0
    @location(2) normal: vec3<f32>,
    @location(3) color: vec4<f32>,
    @location(4) width: f32,
) -> Varyings {
    var out: Varyings;
    var a = (frame.view_from_world * vec4<f32>(from_point, 1.0)).xyz;
    var b = (frame.view_from_world * vec4<f32>(to_point, 1.0)).xyz;
    if (frame.eye.w < 0.5) {
        // Cut off what is behind the camera, where projection turns over.
        let near = -1e-3;
        if (a.z > near && b.z > near) {
            out.position = vec4<f32>(2.0, 2.0, 2.0, 1.0);
            return out;
        }
        if (a.z > near) {
            a = mix(b, a, (near - b.z) / (a.z - b.z));
        } else if (b.z > near) {
            b = mix(a, b, (near - a.z) / (b.z - a.z));
        }
    }
    let half_width = max(0.5 * width * frame.params.x, 0.5);
    let reach = half_width + 0.75;
    // How much the surface that it lies on rises across the line's width: as
    // much nearer it is drawn, so that it is not buried, and no more, so that it
    // doesn't shine through. Free lines may lie on anything.
    var facing = 1.0;
    var slope = 1.0;
    if (dot(normal, normal) > 0.25) {
        let n = (frame.view_from_world * vec4<f32>(normal, 0.0)).xyz;
        facing = dot(normalize(n), view_direction(0.5 * (a + b)));
        slope = min(sqrt(max(1.0 - facing * facing, 0.0)) / max(abs(facing), 1e-3), 3.0);
    }
    let lift = 0.5 + reach * slope;
    let clip_a = frame.clip_from_view * vec4<f32>(nearer(a, lift * units_per_pixel(-a.z)), 1.0);
    let clip_b = frame.clip_from_view * vec4<f32>(nearer(b, lift * units_per_pixel(-b.z)), 1.0);
    let pixel_a = clip_a.xy / clip_a.w * 0.5 * frame.size.xy;
    let pixel_b = clip_b.xy / clip_b.w * 0.5 * frame.size.xy;
    var along = pixel_b - pixel_a;
    let length_px = length(along);
    along = select(vec2<f32>(1.0, 0.0), along / max(length_px, 1e-6), length_px > 1e-4);
    let sideways = vec2<f32>(-along.y, along.x);
    let side = f32(corner & 1u) * 2.0 - 1.0;
    let at_end = (corner >> 1u) == 1u;
    var clip = select(clip_a, clip_b, at_end);
    let offset = sideways * side * reach;
    clip = vec4<f32>(clip.xy + offset * 2.0 * frame.size.zw * clip.w, clip.zw);
    out.position = clip;
    out.across = side * reach;
    out.half_width = half_width;
    out.color = color;
    out.color.a *= mix(frame.flags.w, 1.0, smoothstep(-0.12, 0.12, facing));
    return out;
}

@fragment
fn fs_main(in: Varyings) -> @location(0) vec4<f32> {
    let alpha = in.color.a * clamp(in.half_width + 0.5 - abs(in.across), 0.0, 1.0);
    return vec4<f32>(in.color.rgb * alpha, alpha);
}
