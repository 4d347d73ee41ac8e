// Access to scene textures with one sample a pixel.

const SAMPLES: i32 = 1;
@group(1) @binding(0) var scene_color: texture_2d<f32>;
@group(1) @binding(1) var scene_depth: texture_2d<f32>;

fn load_color(pixel: vec2<i32>, sample: i32) -> vec4<f32> {
    return textureLoad(scene_color, pixel, 0);
}

fn load_depth(pixel: vec2<i32>, sample: i32) -> f32 {
    return textureLoad(scene_depth, pixel, 0).x;
}
