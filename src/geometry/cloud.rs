//! The cloud that the sampler works on, and its tie to the input.

use std::fmt;

use nalgebra::Point3;

use super::brief::Brief;

/// Marks an input point that no sample stands for: it had a coordinate that
/// was not finite, or it is an outlier.
pub const NO_SAMPLE: u32 = u32::MAX;

/// Points on the shape's surface, evenly spread, in the input's units.
///
/// Labels are inferred for these `points`; [`SampleCloud::labels_of_input`]
/// carries them back to every point of the input, in the input's order.
#[derive(Clone, PartialEq)]
pub struct SampleCloud {
    /// The samples, in input units; all coordinates finite.
    pub points: Vec<Point3<f64>>,
    /// For each point of an input *cloud*, in input order, the index into
    /// `points` of the sample that stands for it, or [`NO_SAMPLE`].
    /// `None` where the input is a mesh: its samples are the cloud.
    pub sample_of_input: Option<Vec<u32>>,
    /// What of the input the samples stand for.
    pub part: SampledPart,
    /// The places that the shape was seen from, in input units, where they are
    /// known.
    pub viewpoints: Vec<Point3<f64>>,
}

impl fmt::Debug for SampleCloud {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("SampleCloud")
            .field("points", &Brief::of_points(&self.points))
            .field("sample_of_input", &self.sample_of_input.as_ref().map(Brief::of))
            .field("part", &self.part)
            .field("viewpoints", &self.viewpoints)
            .finish()
    }
}

/// What of a shape is sampled.
#[derive(Debug, Clone, Copy, PartialEq, Default, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum SampledPart {
    /// All of it, as was asked for, or because there is nothing to leave out.
    #[default]
    Whole,
    /// The points of a cloud that are connected with others.
    Connected {
        /// Number of finite points in the cloud.
        points: usize,
        /// How many of them are isolated and were left out.
        isolated: usize,
        /// How many of these no sample stands for, since they are far from all.
        unlabelled: usize,
    },
    /// The part of a mesh's surface that can be seen from outside.
    Outside {
        /// Share of the area that can't, in [0, 1]: an estimate from the
        /// samples' candidates.
        left_out: f64,
    },
    /// All of a mesh, although only what can be seen from outside was asked
    /// for, since hardly anything can.
    WholeAsHidden,
}

impl SampledPart {
    /// Share of the area of a mesh that was left out.
    pub fn left_out(&self) -> f64 {
        match self {
            Self::Outside { left_out } => *left_out,
            Self::Whole | Self::Connected { .. } | Self::WholeAsHidden => 0.0,
        }
    }

    /// Number of points of a cloud that were left out as isolated.
    pub fn isolated(&self) -> usize {
        match self {
            Self::Connected { isolated, .. } => *isolated,
            Self::Whole | Self::Outside { .. } | Self::WholeAsHidden => 0,
        }
    }

    /// One sentence for a person, where there is something to tell.
    pub fn note(&self) -> Option<String> {
        match self {
            Self::Outside { left_out } if *left_out >= 0.005 => Some(format!(
                "{:.0} % of the surface is not visible from outside and was left out",
                100.0 * left_out
            )),
            Self::Connected { points, isolated, .. } => Some(format!(
                "{} of {} points are isolated outliers and were left out",
                grouped(*isolated),
                grouped(*points)
            )),
            Self::WholeAsHidden => Some(
                "almost none of the surface is visible from outside, so all of it was sampled".to_owned(),
            ),
            Self::Whole | Self::Outside { .. } => None,
        }
    }
}

/// A number with its thousands grouped: `12,345`.
pub(crate) fn grouped(count: usize) -> String {
    let digits = count.to_string();
    let mut text = String::with_capacity(digits.len() * 4 / 3);
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

impl SampleCloud {
    /// A cloud taken as it is: every point is its own sample. Points that are
    /// not finite are left out and map to [`NO_SAMPLE`].
    pub fn from_points(points: &[Point3<f64>]) -> Self {
        let mut kept = Vec::with_capacity(points.len());
        let sample_of_input = points
            .iter()
            .map(|p| {
                if p.iter().all(|c| c.is_finite()) {
                    kept.push(*p);
                    (kept.len() - 1) as u32
                } else {
                    NO_SAMPLE
                }
            })
            .collect();
        Self {
            points: kept,
            sample_of_input: Some(sample_of_input),
            part: SampledPart::Whole,
            viewpoints: Vec::new(),
        }
    }

    /// Labels of all input points, in input order, from the labels of the
    /// samples; `missing` where no sample stands for a point. For a mesh the
    /// samples themselves are the cloud, and their labels come back unchanged.
    pub fn labels_of_input(&self, labels: &[u32], missing: u32) -> Vec<u32> {
        match &self.sample_of_input {
            None => labels.to_vec(),
            Some(map) => {
                map.iter().map(|&s| if s == NO_SAMPLE { missing } else { labels[s as usize] }).collect()
            }
        }
    }
}
