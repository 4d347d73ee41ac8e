// Silhouettes of highlighted primitives: red where hovered, green where
// selected, blue where lit. The composition draws outlines around them.

struct Varyings {
    @builtin(position) position: vec4<f32>,
    @location(0) look: vec4<f32>,
}

@vertex
fn vs_main(@location(0) position: vec3<f32>, @location(3) look: vec4<f32>) -> Varyings {
    var out: Varyings;
    out.position = frame.clip_from_view * frame.view_from_world * vec4<f32>(position, 1.0);
    out.look = look;
    return out;
}

@fragment
fn fs_main(in: Varyings) -> @location(0) vec4<f32> {
    return vec4<f32>(in.look.yzw, 1.0);
}
