// Access to scene textures with four samples a pixel.

const SAMPLES: i32 = 4;
@group(1) @binding(0) var scene_color: texture_multisampled_2d<f32>;
@group(1) @binding(1) var scene_depth: texture_multisampled_2d<f32>;

fn load_color(pixel: vec2<i32>, sample: i32) -> vec4<f32> {
    return textureLoad(scene_color, pixel, sample);
}

fn load_depth(pixel: vec2<i32>, sample: i32) -> f32 {
    return textureLoad(scene_depth, pixel, sample).x;
}
