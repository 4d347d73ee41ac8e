// From the scene's samples to the picture: depth cues, resolve, background,
// outlines. One of samples_*.wgsl stands before this file.

@group(1) @binding(2) var mask: texture_2d<f32>;
@group(1) @binding(3) var mask_sampler: sampler;

@vertex
fn vs_main(@builtin(vertex_index) corner: u32) -> @builtin(position) vec4<f32> {
    let unit = vec2<f32>(f32((corner << 1u) & 2u), f32(corner & 2u));
    return vec4<f32>(unit * 2.0 - 1.0, 0.0, 1.0);
}

// View space depth of a (reversed) clip depth above 0.
fn linear_depth(d: f32) -> f32 {
    let p = frame.clip_from_view;
    return -(d * p[3][3] - p[3][2]) / (p[2][2] - d * p[2][3]);
}

// Scene units along the view for a step of clip depth at `d`. Clip depth is
// linear over a plane on the screen, with and without perspective.
fn depth_slope(d: f32, z: f32) -> f32 {
    return select(z / max(d, 1e-9), 1.0 / abs(frame.clip_from_view[2][2]), frame.eye.w > 0.5);
}

fn depth_at(pixel: vec2<i32>) -> f32 {
    let last = vec2<i32>(frame.size.xy) - 1;
    return load_depth(clamp(pixel, vec2<i32>(0), last), 0);
}

// How dark a sample of depth `d` gets. `pairs` holds the mean clip depth of
// opposite neighbours: over a plane it is the sample's own, in a crease or
// behind an edge it is nearer.
fn shadow(d: f32, pairs: array<vec4<f32>, 3>, radius: vec3<f32>) -> f32 {
    let z = linear_depth(d);
    let slope = depth_slope(d, z);
    let pixel = units_per_pixel(z);
    let sharp = clamp((pairs[0] - d) * slope / (pixel * radius.x * 5.0), vec4<f32>(0.0), vec4<f32>(1.0));
    let soft = clamp((pairs[1] - d) * slope / (pixel * radius.y * 4.0), vec4<f32>(0.0), vec4<f32>(1.0));
    // The broad one is for contacts: what is far in front throws no shadow.
    let step = (pairs[2] - d) * slope / (pixel * radius.z);
    let broad = clamp(step / 1.5, vec4<f32>(0.0), vec4<f32>(1.0))
        * (1.0 - smoothstep(vec4<f32>(3.0), vec4<f32>(10.0), step));
    return dot(sharp, vec4<f32>(0.085)) + dot(soft, vec4<f32>(0.055)) + dot(broad, vec4<f32>(0.05));
}

fn pair(pixel: vec2<i32>, offset: vec2<i32>) -> f32 {
    return 0.5 * (depth_at(pixel + offset) + depth_at(pixel - offset));
}

// The radii, in scene units, within which parts keep the ambient light from
// each other.
const AMBIENT = vec3<f32>(0.022, 0.05, 0.105);

// The same in pixels, for a sample of depth `d`.
fn ambient_radii(d: f32) -> vec3<f32> {
    let pixels = AMBIENT / max(units_per_pixel(linear_depth(d)), 1e-9);
    return clamp(pixels, vec3<f32>(2.0), vec3<f32>(24.0, 52.0, 90.0) * frame.params.x);
}

// Between 0 and 1, from pixel to pixel as different as can be (interleaved
// gradient noise).
fn scatter(pixel: vec2<f32>) -> f32 {
    return fract(52.9829189 * fract(dot(pixel, vec2<f32>(0.06711056, 0.00583715))));
}

// Mean clip depth of opposite neighbours in four directions.
fn ring(pixel: vec2<i32>, radius: f32, turn: f32) -> vec4<f32> {
    var found = vec4<f32>(0.0);
    for (var k = 0; k < 4; k++) {
        let angle = turn + f32(k) * 0.78539816;
        found[k] = pair(pixel, vec2<i32>(round(vec2<f32>(cos(angle), sin(angle)) * radius)));
    }
    return found;
}

// The share of the ambient light that does not reach a sample: more, the more
// its neighbours stand out above its plane, until they stand clear of it.
fn occlusion(d: f32, rings: array<vec4<f32>, 3>, radii: vec3<f32>) -> f32 {
    let z = linear_depth(d);
    let to_steps = depth_slope(d, z) / units_per_pixel(z);
    var sum = 0.0;
    for (var k = 0; k < 3; k++) {
        let step = (rings[k] - d) * to_steps / radii[k];
        let raised = clamp(step / 0.5, vec4<f32>(0.0), vec4<f32>(1.0))
            * (1.0 - smoothstep(vec4<f32>(0.55), vec4<f32>(1.1), step));
        sum += dot(raised, vec4<f32>(0.25));
    }
    return sum / 3.0;
}

// A fixed pattern of ±½ levels of 8 bits, so that gradients show no bands.
fn dither(pixel: vec2<f32>) -> f32 {
    return (scatter(pixel) - 0.5) / 255.0;
}

@fragment
fn fs_main(@builtin(position) position: vec4<f32>) -> @location(0) vec4<f32> {
    let pixel = vec2<i32>(position.xy);
    var depths = vec4<f32>(0.0);
    for (var s = 0; s < SAMPLES; s++) {
        depths[s] = load_depth(pixel, s);
    }
    var sum = vec4<f32>(0.0);
    if (max(max(depths.x, depths.y), max(depths.z, depths.w)) > 0.0) {
        let r = max(i32(round(frame.params.x)), 1);
        let radius = vec3<i32>(r, 3 * r, 10 * r);
        var pairs = array<vec4<f32>, 3>();
        var rings = array<vec4<f32>, 3>();
        // Of the nearest sample: few pixels have several depths.
        let radii = ambient_radii(max(max(depths.x, depths.y), max(depths.z, depths.w)));
        let strength = frame.params.w;
        if (strength > 0.0) {
            for (var k = 0; k < 3; k++) {
                // Straight and diagonal, at about the same distance.
                let w = radius[k];
                let v = max(w * 7 / 10, 1);
                pairs[k] = vec4<f32>(
                    pair(pixel, vec2<i32>(w, 0)), pair(pixel, vec2<i32>(0, w)),
                    pair(pixel, vec2<i32>(v, v)), pair(pixel, vec2<i32>(v, -v)),
                );
                // Turned against each other and from pixel to pixel, so that no
                // direction throws an image of what is near.
                rings[k] = ring(pixel, radii[k], 0.2618 * f32(k) + 0.7854 * scatter(position.xy));
            }
        }
        for (var s = 0; s < SAMPLES; s++) {
            var color = load_color(pixel, s);
            if (depths[s] > 0.0) {
                // Opaque, whatever alpha its coverage was made from.
                let edges = strength * shadow(depths[s], pairs, vec3<f32>(radius));
                let ambient = strength * 0.55 * occlusion(depths[s], rings, radii);
                let light = (1.0 - clamp(edges, 0.0, 0.8)) * (1.0 - clamp(ambient, 0.0, 0.7));
                // What is left comes from around, and is a little cooler.
                color = vec4<f32>(color.rgb * mix(vec3<f32>(1.0), vec3<f32>(0.97, 0.985, 1.0), ambient) * light, 1.0);
            }
            sum += color;
        }
    } else {
        for (var s = 0; s < SAMPLES; s++) {
            sum += load_color(pixel, s);
        }
    }
    sum /= f32(SAMPLES);

    let down = position.y * frame.size.w;
    let background = mix(frame.background_top, frame.background_bottom, down);
    var color = sum.rgb;
    var alpha = sum.a;
    if (frame.flags.y < 0.5) {
        color += (background.rgb + dither(position.xy)) * (1.0 - alpha);
        alpha = 1.0;
    }

    if (frame.flags.z > 0.5) {
        let uv = position.xy * frame.size.zw;
        let own = textureSampleLevel(mask, mask_sampler, uv, 0.0).xyz;
        var around = own;
        for (var k = 0; k < 16; k++) {
            let angle = f32(k) * 0.39269908;
            let reach = vec2<f32>(cos(angle), sin(angle)) * 2.3 * frame.params.x;
            let there = uv + reach * frame.size.zw;
            around = max(around, textureSampleLevel(mask, mask_sampler, there, 0.0).xyz);
        }
        let edge = clamp(around - own, vec3<f32>(0.0), vec3<f32>(1.0));
        let lit = edge.z * frame.lit_color.a;
        color = mix(color, frame.lit_color.rgb, lit);
        alpha = mix(alpha, 1.0, lit);
        let selected = edge.y * frame.selected_color.a;
        color = mix(color, frame.selected_color.rgb, selected);
        alpha = mix(alpha, 1.0, selected);
        let hovered = edge.x * frame.hovered_color.a;
        color = mix(color, frame.hovered_color.rgb, hovered);
        alpha = mix(alpha, 1.0, hovered);
    }
    return vec4<f32>(color, alpha);
}
