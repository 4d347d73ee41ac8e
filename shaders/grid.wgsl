// The ground grid: one quad, its lines computed a pixel.

struct Varyings {
    @builtin(position) position: vec4<f32>,
    // in the plane, scene units from the grid's origin
    @location(0) place: vec2<f32>,
    @location(1) view: vec3<f32>,
}

@vertex
fn vs_main(@builtin(vertex_index) corner: u32) -> Varyings {
    var out: Varyings;
    let unit = vec2<f32>(f32(corner & 1u), f32(corner >> 1u)) * 2.0 - 1.0;
    out.place = unit * frame.grid_u.w;
    let world = frame.grid_origin.xyz + frame.grid_u.xyz * out.place.x + frame.grid_v.xyz * out.place.y;
    let view = frame.view_from_world * vec4<f32>(world, 1.0);
    out.view = view.xyz;
    out.position = frame.clip_from_view * view;
    return out;
}

// Coverage of lines every `spacing`, one pixel wide; fades out where they
// would be closer than a few pixels.
fn lines(place: vec2<f32>, pixel: vec2<f32>, spacing: f32, width: f32) -> f32 {
    let step_px = max(pixel / spacing, vec2<f32>(1e-6));
    let cell = place / spacing;
    let distance_px = abs(fract(cell - 0.5) - 0.5) / step_px;
    let cover = clamp(vec2<f32>(0.5 * width + 0.5) - distance_px, vec2<f32>(0.0), vec2<f32>(1.0));
    let dense = 1.0 - smoothstep(vec2<f32>(0.08), vec2<f32>(0.35), step_px);
    let both = cover * dense;
    return max(both.x, both.y);
}

@fragment
fn fs_main(in: Varyings) -> @location(0) vec4<f32> {
    let pixel = vec2<f32>(
        length(vec2<f32>(dpdx(in.place.x), dpdy(in.place.x))),
        length(vec2<f32>(dpdx(in.place.y), dpdy(in.place.y))),
    );
    let width = frame.params.x * frame.grid_v.w;
    let minor = lines(in.place, pixel, frame.grid_origin.w, width) * 0.45;
    let major = lines(in.place, pixel, frame.grid_origin.w * 10.0, width * 1.2);
    let normal = normalize((frame.view_from_world * vec4<f32>(cross(frame.grid_u.xyz, frame.grid_v.xyz), 0.0)).xyz);
    let grazing = smoothstep(0.0, 0.18, abs(dot(normal, view_direction(in.view))));
    let far = 1.0 - smoothstep(0.15, 1.0, length(in.place) / frame.grid_u.w);
    let alpha = frame.grid_color.a * max(minor, major) * far * far * grazing;
    return vec4<f32>(frame.grid_color.rgb * alpha, alpha);
}
