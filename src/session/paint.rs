//! The displayed points of a shape and their colours.

use std::collections::BTreeSet;

use nalgebra::Point3;
use rayon::prelude::*;

use super::scalar::Scalar;
use crate::geometry::NO_SAMPLE;
use crate::geometry::palette::{Colors, UNASSIGNED_COLOR};
use crate::inference::UNASSIGNED;
use crate::io::ShapeGeometry;
use crate::worker::LoadedShape;

/// Colours of marked and unmarked points, which differ in lightness and, even
/// for colour-blind people, in hue.
const MARKED_COLOR: [u8; 3] = [255, 150, 0];
const UNMARKED_COLOR: [u8; 3] = [104, 112, 124];

/// Points without a value.
const PLAIN_COLOR: [u8; 3] = [198, 204, 212];

/// The displayed points of a shape, in input units: all points of an input
/// cloud, or the samples of a mesh.
pub fn shown_points(loaded: &LoadedShape) -> &[Point3<f64>] {
    match (&loaded.shape.geometry, &loaded.cloud.sample_of_input) {
        (ShapeGeometry::Cloud(input), Some(_)) => &input.points,
        _ => &loaded.cloud.points,
    }
}

/// The sample of a displayed point; `None` for points without one, such as outliers.
pub fn sample_of_shown(loaded: &LoadedShape, shown: usize) -> Option<usize> {
    match &loaded.cloud.sample_of_input {
        Some(map) => map.get(shown).filter(|&&sample| sample != NO_SAMPLE).map(|&sample| sample as usize),
        None => Some(shown),
    }
}

/// The alpha that marks a selected point in the colours of points; 0 hides
/// one, 255 is the usual.
pub const SELECTED_ALPHA: u8 = 128;

/// What point colours show.
#[derive(Debug, Clone, Copy)]
pub enum Paint<'a> {
    /// The primitive of each, in these colours.
    Clusters(&'a Colors),
    /// The same, with all faded but some, by id.
    Lit(&'a Colors, &'a [u32]),
    /// Colours from the file; grey if there are none.
    Input,
    /// Nothing.
    Plain,
    /// A value for each sample, mapped to colours from [0, 1].
    Scalar(&'a Scalar, fn(f32) -> [u8; 3]),
    /// Whether each sample is marked.
    Marked(&'a [bool]),
}

/// The colours of the shown points, RGBA in sRGB encoding, as `paint` has it:
/// transparent where the sample's label is among `hidden`, grey where there is
/// nothing to tell, with [`SELECTED_ALPHA`] where the sample is `selected`, dark
/// where it is `pinned` (ascending indices, both).
pub fn shown_colors(
    loaded: &LoadedShape,
    labels: &[u32],
    hidden: &BTreeSet<u32>,
    selected: &[u32],
    pinned: &[u32],
    paint: Paint<'_>,
) -> Vec<[u8; 4]> {
    let [r, g, b] = UNASSIGNED_COLOR;
    let unassigned = [r, g, b, 255];
    let opaque = |[r, g, b]: [u8; 3]| [r, g, b, 255];
    let color = |sample: usize| {
        let label = labels.get(sample).copied().unwrap_or(UNASSIGNED);
        if label != UNASSIGNED && !hidden.is_empty() && hidden.contains(&label) {
            return [0; 4];
        }
        match paint {
            Paint::Clusters(colors) if label != UNASSIGNED => opaque(colors.of(label)),
            Paint::Lit(colors, lit) if lit.contains(&label) => opaque(colors.of(label)),
            Paint::Lit(colors, _) if label != UNASSIGNED => opaque(faded(colors.of(label))),
            Paint::Scalar(scalar, map) => scalar.share(sample).map_or(unassigned, |share| opaque(map(share))),
            Paint::Plain => opaque(PLAIN_COLOR),
            Paint::Marked(marks) if marks.get(sample) == Some(&true) => opaque(MARKED_COLOR),
            Paint::Marked(_) => opaque(UNMARKED_COLOR),
            Paint::Clusters(_) | Paint::Lit(..) | Paint::Input => unassigned,
        }
    };
    let mut of_samples: Vec<[u8; 4]> =
        (0..loaded.cloud.points.len()).into_par_iter().with_min_len(1 << 14).map(color).collect();
    for &sample in pinned {
        if let Some([r, g, b, _]) = of_samples.get_mut(sample as usize) {
            [*r, *g, *b] = darkened([*r, *g, *b]);
        }
    }
    for &sample in selected {
        if let Some(c) = of_samples.get_mut(sample as usize).filter(|c| c[3] != 0) {
            c[3] = SELECTED_ALPHA;
        }
    }
    let in_file = match (&loaded.shape.geometry, paint) {
        (ShapeGeometry::Cloud(_), Paint::Input) => loaded.shape.attributes.colors.as_deref(),
        _ => None,
    };
    let Some(map) = &loaded.cloud.sample_of_input else { return of_samples };
    // A point without a sample is in range of nothing.
    let alone = if matches!(paint, Paint::Plain) { opaque(PLAIN_COLOR) } else { unassigned };
    (map, 0..map.len())
        .into_par_iter()
        .with_min_len(1 << 14)
        .map(|(&sample, i)| {
            let color = of_samples.get(sample as usize).copied().unwrap_or(alone);
            match in_file.and_then(|colors| colors.get(i)) {
                Some(&[r, g, b]) => [r, g, b, color[3]],
                None => color,
            }
        })
        .collect()
}

/// A faded colour, next to highlighted ones.
pub fn faded(color: [u8; 3]) -> [u8; 3] {
    mixed(color, UNASSIGNED_COLOR, 0.8)
}

/// The colour of pinned points.
fn darkened(color: [u8; 3]) -> [u8; 3] {
    mixed(color, [0; 3], 0.5)
}

fn mixed(from: [u8; 3], to: [u8; 3], share: f32) -> [u8; 3] {
    std::array::from_fn(|i| (f32::from(from[i]) * (1.0 - share) + f32::from(to[i]) * share).round() as u8)
}
