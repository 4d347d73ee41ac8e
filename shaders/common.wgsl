// Shared by all pipelines of the scene: the frame's uniforms, colour encoding,
// light. All colours that cross between CPU, textures and passes are
// sRGB-encoded; light is computed on linear values.

struct Frame {
    view_from_world: mat4x4<f32>,
    clip_from_view: mat4x4<f32>,
    // width, height, 1/width, 1/height in physical pixels
    size: vec4<f32>,
    // camera position; w is 1 for an orthographic camera
    eye: vec4<f32>,
    // physical pixels a logical one, point diameter in physical pixels at the
    // reference depth, alpha of translucent surfaces, strength of depth cues
    params: vec4<f32>,
    // reference depth of the point size, 1 for a transparent background,
    // 1 if the mask holds outlines, alpha at back sides of lines
    flags: vec4<f32>,
    background_top: vec4<f32>,
    background_bottom: vec4<f32>,
    // w is the spacing
    grid_origin: vec4<f32>,
    // w is the radius
    grid_u: vec4<f32>,
    // w is the number of texels along the side of a pixel
    grid_v: vec4<f32>,
    grid_color: vec4<f32>,
    ghost_color: vec4<f32>,
    selected_color: vec4<f32>,
    hovered_color: vec4<f32>,
    lit_color: vec4<f32>,
}

@group(0) @binding(0) var<uniform> frame: Frame;

fn linear_from_srgb(c: vec3<f32>) -> vec3<f32> {
    let low = c / 12.92;
    let high = pow((c + 0.055) / 1.055, vec3<f32>(2.4));
    return select(high, low, c <= vec3<f32>(0.04045));
}

fn srgb_from_linear(c: vec3<f32>) -> vec3<f32> {
    let x = clamp(c, vec3<f32>(0.0), vec3<f32>(1.0));
    let low = x * 12.92;
    let high = 1.055 * pow(x, vec3<f32>(1.0 / 2.4)) - 0.055;
    return select(high, low, x <= vec3<f32>(0.0031308));
}

// Towards the camera, in view space.
fn view_direction(position: vec3<f32>) -> vec3<f32> {
    if (frame.eye.w > 0.5) {
        return vec3<f32>(0.0, 0.0, 1.0);
    }
    return normalize(-position);
}

// View space length of a physical pixel at a view space depth.
fn units_per_pixel(depth: f32) -> f32 {
    let scale = 2.0 * frame.size.w / frame.clip_from_view[1][1];
    return select(scale * depth, scale, frame.eye.w > 0.5);
}

// Surfaces of different layers that lie in one another are drawn as if they were
// as far apart as this, in scene units, so that one covers the other as a whole:
// fits are never exact, and without it they would show in patches.
const FILM: f32 = 0.006;

// As far nearer as a surface with that normal has to be drawn, to lie so far over
// where it is.
fn lift_over(height: f32, normal: vec3<f32>, view: vec3<f32>) -> f32 {
    let facing = abs(dot(normal, view_direction(view))) / max(length(normal), 1e-6);
    return height / max(facing, 0.1);
}

// The place, in view space, that looks the same from the camera but is nearer
// by so many scene units.
fn nearer(view: vec3<f32>, by: f32) -> vec3<f32> {
    let most = select(0.25 * length(view), by, frame.eye.w > 0.5);
    return view + view_direction(view) * min(by, most);
}

// A studio that turns with the camera: key light from the upper left, weak
// fill from the right, bounce from below, a rim from behind. `albedo` is
// linear, and so is the result.
fn studio(albedo: vec3<f32>, n: vec3<f32>, v: vec3<f32>, gloss: f32) -> vec3<f32> {
    let key_direction = normalize(vec3<f32>(-0.42, 0.72, 0.62));
    let fill_direction = normalize(vec3<f32>(0.85, 0.1, 0.5));
    let key = max(dot(n, key_direction), 0.0);
    let fill = max(dot(n, fill_direction), 0.0);
    let up = 0.5 + 0.5 * n.y;
    let ambient = mix(vec3<f32>(0.20, 0.19, 0.185), vec3<f32>(0.40, 0.42, 0.45), up);
    let light = ambient
        + key * 0.72 * vec3<f32>(1.0, 0.985, 0.96)
        + fill * 0.20 * vec3<f32>(0.90, 0.95, 1.0);
    let h = normalize(key_direction + v);
    let specular = pow(max(dot(n, h), 0.0), 42.0) * 0.16 * step(0.001, key);
    let facing = clamp(dot(n, v), 0.0, 1.0);
    let rim = pow(1.0 - facing, 4.0) * (0.35 + 0.65 * up) * 0.22;
    return albedo * (light + rim * 0.6) + gloss * (vec3<f32>(specular) + vec3<f32>(rim) * 0.35);
}
