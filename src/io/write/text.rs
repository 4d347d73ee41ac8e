//! Numbers and texts as files have them.

use std::io::{self, Write};

use nalgebra::Point3;
use serde::Serialize;

use super::atomic::unfit;
use crate::geometry::mesh::bounds;

pub(in crate::io) fn json(w: &mut (impl Write + ?Sized), value: &impl Serialize) -> io::Result<()> {
    serde_json::to_writer_pretty(&mut *w, value)?;
    writeln!(w)
}

/// An id as files have it.
pub(in crate::io) fn file_label(id: u32) -> io::Result<i32> {
    i32::try_from(id).map_err(|_| unfit(format!("the id {id} is too large for a label")))
}

/// What becomes of places in single precision: an error where one is out of its
/// range, a sentence where they lose more than a millionth of their extent.
pub(super) fn rounding<'a>(
    places: impl Iterator<Item = &'a Point3<f64>> + Clone,
) -> io::Result<Option<String>> {
    let finite = |p: &&Point3<f64>| p.iter().all(|c| c.is_finite());
    let coordinates = places.clone().filter(finite).flat_map(|p| p.iter().copied());
    if coordinates.clone().any(|c| !(c as f32).is_finite()) {
        return Err(unfit(
            "a coordinate is out of range for single precision; use a format with double precision",
        ));
    }
    let off = coordinates.map(|c| (f64::from(c as f32) - c).abs()).fold(0.0, f64::max);
    let extent = bounds(places.filter(finite).copied()).map_or(0.0, |(lo, hi)| (hi - lo).amax());
    Ok((off > 1e-6 * extent)
        .then(|| format!("coordinates were rounded to single precision, by up to {off:.2e}")))
}

/// Characters that the places of a point take in a text, on average over some
/// of them.
pub(super) fn mean_place(points: &[Point3<f64>]) -> u64 {
    const SAMPLES: usize = 64;
    let count = points.len().clamp(1, SAMPLES);
    let some = (0..count.min(points.len())).map(|k| points[k * points.len() / count]);
    let characters: usize = some.flat_map(|p| [p.x, p.y, p.z]).map(|c| Text(c).to_string().len() + 1).sum();
    (characters / count) as u64
}

/// A number as accepted by all readers: the shortest text that reads back as the
/// same number, or `nan`.
pub(in crate::io) struct Text<T>(pub(in crate::io) T);

macro_rules! text {
    ($float:ty) => {
        impl std::fmt::Display for Text<$float> {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                let value = self.0;
                if value.is_nan() {
                    f.write_str("nan")
                } else if value == value.trunc() && value.abs() < 1e15 {
                    // Without the ".0".
                    write!(f, "{value}")
                } else {
                    write!(f, "{value:?}")
                }
            }
        }
    };
}
text!(f32);
text!(f64);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coarse_numbers_are_told_and_too_large_ones_refused() {
        let p = |x: f64| Point3::new(x, 0.0, 0.0);
        assert_eq!(rounding([p(0.1), p(0.7)].iter()).unwrap(), None);
        assert!(rounding([p(5_400_000.1), p(5_400_001.3)].iter()).unwrap().is_some());
        assert!(rounding([p(1e300)].iter()).is_err());
        assert_eq!(rounding([p(f64::NAN)].iter()).unwrap(), None);
    }

    #[test]
    fn numbers_are_short_and_come_back() {
        for (value, text) in [
            (0.1, "0.1"),
            (-3.0, "-3"),
            (1e300, "1e300"),
            (-2.5e-9, "-2.5e-9"),
            (450_000.123_456_789, "450000.123456789"),
            (f64::NAN, "nan"),
            (f64::NEG_INFINITY, "-inf"),
            (-0.0, "-0"),
        ] {
            let shown = Text(value).to_string();
            assert_eq!(shown, text);
            let back: f64 = shown.parse().unwrap();
            assert!(back.to_bits() == value.to_bits() || back.is_nan() && value.is_nan());
        }
        assert_eq!(Text(0.1f32).to_string(), "0.1");
    }
}
