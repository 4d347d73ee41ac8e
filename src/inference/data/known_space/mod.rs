//! What is known of the space around a cloud that was seen from some
//! viewpoints: it is free in front of the seen surface, and unknown behind it.
//!
//! A place is free where the line of sight to it stays away from all points of
//! the cloud by [`CLEARANCE`] mean spacings, and goes on to a point behind it
//! or, for a viewpoint outside of the cloud, past it.

mod range_image;
mod search;
mod viewpoint;

use nalgebra::Point3;
use serde::{Deserialize, Serialize};

use crate::geometry::Superquadric;
use crate::geometry::kernel::{self, PointBlock};
use range_image::View;
pub(crate) use search::find_viewpoints;
pub(crate) use viewpoint::Viewpoint;

/// Mean spacings around each point that are not known to be free: the cloud is
/// no finer.
const CLEARANCE: f64 = 1.1;
/// Lines of sight that are sampled at most, and places on each.
const RAYS: usize = 1500;
const PLACES: usize = 2;

/// Whence the cloud of a run was seen, in input units.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Sighting {
    /// From all sides.
    #[default]
    AllSides,
    /// From so many viewpoints that were given.
    Given { viewpoints: usize },
    /// From one side, as the points tell: from this place.
    FoundPlace { viewpoint: [f64; 3] },
    /// From far away on one side, as the points tell: the unit vector towards
    /// the viewer.
    FoundDirection { towards: [f64; 3] },
}

impl Sighting {
    /// What it says, for people; `None` where the shape was seen from all sides.
    pub fn note(&self) -> Option<String> {
        let three = |[x, y, z]: &[f64; 3]| format!("{x:.3}, {y:.3}, {z:.3}");
        match self {
            Self::AllSides => None,
            Self::Given { viewpoints: 1 } => Some("seen from one viewpoint".to_owned()),
            Self::Given { viewpoints } => Some(format!("seen from {viewpoints} viewpoints")),
            Self::FoundPlace { viewpoint } => {
                Some(format!("seen from one side only, about from ({})", three(viewpoint)))
            }
            Self::FoundDirection { towards } => {
                Some(format!("seen from one side only, in the direction ({})", three(towards)))
            }
        }
    }
}

/// Free and unknown space.
#[derive(Debug)]
pub(crate) struct KnownSpace {
    views: Vec<View>,
    /// Whether only one of the views is true, and it is open which.
    is_guess: bool,
    /// Free places, evenly spread over the lines of sight.
    free: Vec<Point3<f64>>,
    /// Points of the cloud that each of them stands for.
    weight: f64,
}

impl KnownSpace {
    /// The space that the points, of mean spacing `spacing`, show to these
    /// viewpoints, or, as a guess, to one of these, most likely the first.
    pub(crate) fn new(
        viewpoints: &[Viewpoint],
        is_guess: bool,
        points: &[Point3<f64>],
        spacing: f64,
    ) -> Self {
        let views: Vec<View> =
            viewpoints.iter().map(|v| View::new(v, points, spacing, CLEARANCE * spacing)).collect();
        let stride = points.len().div_ceil(RAYS).max(1);
        let mut free = Vec::new();
        let mut rays = 0;
        let (likely, others) = views.split_at(if is_guess { 1 } else { views.len() });
        for view in likely {
            for (k, p) in points.iter().step_by(stride).enumerate() {
                rays += 1;
                free.extend((0..PLACES).filter_map(|place| {
                    // The golden ratio spreads a sequence evenly.
                    let share = (k as f64 * 0.618_033_988_749_895).fract();
                    view.free_place(p, (place as f64 + share) / PLACES as f64)
                }));
            }
        }
        free.retain(|p| others.iter().all(|view| view.is_free(p)));
        let weight = points.len() as f64 / (rays * PLACES).max(1) as f64;
        Self { views, is_guess, free, weight }
    }

    /// The viewpoint, where there is one, or the likeliest.
    pub(crate) fn viewpoint(&self) -> Option<Viewpoint> {
        let is_one = self.is_guess || self.views.len() == 1;
        self.views.first().filter(|_| is_one).map(|view| view.viewpoint)
    }

    /// Whether a place was seen to be free, whichever view is the true one.
    pub(crate) fn is_free(&self, place: &Point3<f64>) -> bool {
        let mut views = self.views.iter();
        if self.is_guess {
            views.all(|view| view.is_free(place))
        } else {
            views.any(|view| view.is_free(place))
        }
    }

    /// What the free space inside of a body adds to the energy: `cost` of its
    /// depth below the surface, each line of sight counted as one point.
    pub(crate) fn intrusion(&self, shape: &Superquadric, cost: impl Fn(f64) -> f64) -> f64 {
        let mut depths = Vec::new();
        let inside = self.inside(shape);
        kernel::euclidean_distances(shape, &inside, &mut depths);
        self.weight * depths.into_iter().map(|d| cost(f64::from(d))).sum::<f64>()
    }

    /// The free places inside of a body.
    pub(crate) fn inside(&self, shape: &Superquadric) -> PointBlock {
        self.free.iter().filter(|p| shape.contains(p)).copied().collect()
    }

    /// Points of the cloud that a free place stands for.
    pub(crate) fn weight(&self) -> f64 {
        self.weight
    }
}
