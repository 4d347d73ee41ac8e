// Access to scene textures of twice the picture's width and height: the four
// samples of a pixel are texels of their own.

const SAMPLES: i32 = 4;
@group(1) @binding(0) var scene_color: texture_2d<f32>;
@group(1) @binding(1) var scene_depth: texture_2d<f32>;

fn texel(pixel: vec2<i32>, sample: i32) -> vec2<i32> {
    return 2 * pixel + vec2<i32>(sample & 1, sample >> 1u);
}

fn load_color(pixel: vec2<i32>, sample: i32) -> vec4<f32> {
    return textureLoad(scene_color, texel(pixel, sample), 0);
}

fn load_depth(pixel: vec2<i32>, sample: i32) -> f32 {
    return textureLoad(scene_depth, texel(pixel, sample), 0).x;
}
