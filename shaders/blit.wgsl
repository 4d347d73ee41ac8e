// Copies the finished picture (sRGB-encoded, premultiplied) into the caller's
// pass. Stands alone.

@group(0) @binding(0) var picture: texture_2d<f32>;
@group(0) @binding(1) var picture_sampler: sampler;

struct Varyings {
    @builtin(position) position: vec4<f32>,
    @location(0) uv: vec2<f32>,
}

@vertex
fn vs_main(@builtin(vertex_index) corner: u32) -> Varyings {
    var out: Varyings;
    let unit = vec2<f32>(f32((corner << 1u) & 2u), f32(corner & 2u));
    out.position = vec4<f32>(unit * 2.0 - 1.0, 0.0, 1.0);
    out.uv = vec2<f32>(unit.x, 1.0 - unit.y);
    return out;
}

@fragment
fn fs_main(in: Varyings) -> @location(0) vec4<f32> {
    return textureSample(picture, picture_sampler, in.uv);
}

// For targets that encode on their own.
@fragment
fn fs_srgb_target(in: Varyings) -> @location(0) vec4<f32> {
    let c = textureSample(picture, picture_sampler, in.uv);
    let low = c.rgb / 12.92;
    let high = pow((c.rgb + 0.055) / 1.055, vec3<f32>(2.4));
    return vec4<f32>(select(high, low, c.rgb <= vec3<f32>(0.04045)), c.a);
}
