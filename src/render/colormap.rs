//! Numbers as colours.

use crate::geometry::palette::UNASSIGNED_COLOR;

/// Coefficients of the powers of t, from t⁰ to t⁶, for red, green and blue: a
/// least-squares fit to matplotlib's viridis, sRGB-encoded.
const VIRIDIS: [[f32; 3]; 7] = [
    [0.277_727_33, 0.005_407_344_5, 0.334_099_8],
    [0.105_093_04, 1.404_613_5, 1.384_590_2],
    [-0.330_861_83, 0.214_847_56, 0.095_095_16],
    [-4.634_230_5, -5.799_101, -19.332_441],
    [6.228_27, 14.179_933, 56.690_55],
    [4.776_385, -13.745_145, -65.353_03],
    [-5.435_456, 4.645_852_6, 26.312_435],
];

/// The colour of a number in [0, 1] (what lies outside counts as the end; NaN
/// is grey): from dark violet by green to bright yellow, as even to the eye as
/// the number is, also in grey and for colour-blind eyes (viridis, by van der
/// Walt and Smith).
pub fn viridis(t: f32) -> [u8; 3] {
    if t.is_nan() {
        return UNASSIGNED_COLOR;
    }
    let t = t.clamp(0.0, 1.0);
    let value = |channel: usize| VIRIDIS.iter().rev().fold(0.0, |sum, row| sum * t + row[channel]);
    [0, 1, 2].map(|channel| (255.0 * value(channel)).round().clamp(0.0, 255.0) as u8)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Oklab's lightness of an sRGB colour.
    fn lightness(rgb: [u8; 3]) -> f64 {
        let [r, g, b] = rgb.map(|c| {
            let c = f64::from(c) / 255.0;
            if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
        });
        let l = (0.4122214708 * r + 0.5363325363 * g + 0.0514459929 * b).cbrt();
        let m = (0.2119034982 * r + 0.6806995451 * g + 0.1073969566 * b).cbrt();
        let s = (0.0883024619 * r + 0.2817188376 * g + 0.6299787005 * b).cbrt();
        0.2104542553 * l + 0.7936177850 * m - 0.0040720468 * s
    }

    #[test]
    fn more_is_brighter_by_even_steps() {
        let steps: Vec<f64> = (0..=20).map(|i| lightness(viridis(i as f32 / 20.0))).collect();
        let mean = (steps[20] - steps[0]) / 20.0;
        for pair in steps.windows(2) {
            let step = pair[1] - pair[0];
            assert!(step > 0.5 * mean && step < 1.8 * mean, "{step} against {mean}");
        }
    }

    #[test]
    fn the_ends_are_those_of_the_map_and_nothing_is_grey() {
        for (t, expected) in [(0.0, [68, 1, 84]), (0.5, [33, 145, 140]), (1.0, [253, 231, 37])] {
            let color = viridis(t);
            for (c, e) in color.into_iter().zip(expected) {
                assert!(c.abs_diff(e) <= 6, "{t}: {color:?} for {expected:?}");
            }
        }
        assert_eq!(viridis(-3.0), viridis(0.0));
        assert_eq!(viridis(f32::INFINITY), viridis(1.0));
        assert_eq!(viridis(f32::NAN), UNASSIGNED_COLOR);
    }
}
