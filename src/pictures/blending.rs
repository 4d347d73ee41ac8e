//! Colours over others.

use image::RgbaImage;

/// Lays a colour over a pixel, in straight alpha; outside the picture nothing
/// happens.
pub(super) fn blend(picture: &mut RgbaImage, [x, y]: [i64; 2], color: [u8; 3], cover: f32) {
    let (Ok(x), Ok(y)) = (u32::try_from(x), u32::try_from(y)) else { return };
    let Some(pixel) = picture.get_pixel_mut_checked(x, y).filter(|_| cover > 0.0) else { return };
    let below = f32::from(pixel[3]) / 255.0 * (1.0 - cover);
    let alpha = cover + below;
    for (under, over) in pixel.0.iter_mut().zip(color) {
        *under = ((f32::from(over) * cover + f32::from(*under) * below) / alpha).round() as u8;
    }
    pixel[3] = (255.0 * alpha).round() as u8;
}

#[cfg(test)]
mod tests {
    use image::Rgba;

    use super::*;

    #[test]
    fn blending_mixes_colours_and_keeps_the_empty_empty() {
        let mut picture = RgbaImage::from_pixel(2, 1, Rgba([0, 100, 200, 255]));
        blend(&mut picture, [0, 0], [200, 100, 0], 0.5);
        assert_eq!(picture.get_pixel(0, 0).0, [100, 100, 100, 255]);
        let mut empty = RgbaImage::new(2, 1);
        blend(&mut empty, [0, 0], [200, 100, 0], 0.5);
        blend(&mut empty, [1, 0], [200, 100, 0], 0.0);
        blend(&mut empty, [-1, 7], [200, 100, 0], 1.0);
        assert_eq!([empty.get_pixel(0, 0).0, empty.get_pixel(1, 0).0], [[200, 100, 0, 128], [0; 4]]);
    }
}
