//! The cloud that the sampler works on, and its tie to the input.

use nalgebra::Point3;

/// Marks an input point that no sample stands for (it had a coordinate that
/// was not finite).
pub const NO_SAMPLE: u32 = u32::MAX;

/// Points on the shape's surface, evenly spread, in the input's units.
///
/// Labels are inferred for these `points`; [`SampleCloud::labels_of_input`]
/// carries them back to every point of the input, in the input's order.
#[derive(Debug, Clone, PartialEq)]
pub struct SampleCloud {
    /// The samples, in input units; all coordinates finite.
    pub points: Vec<Point3<f64>>,
    /// For each point of an input *cloud*, in input order, the index into
    /// `points` of the sample that stands for it, or [`NO_SAMPLE`].
    /// `None` where the input is a mesh: its samples are the cloud.
    pub sample_of_input: Option<Vec<u32>>,
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
        Self { points: kept, sample_of_input: Some(sample_of_input) }
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
