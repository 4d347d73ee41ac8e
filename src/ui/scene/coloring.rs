//! Scalar values for colouring, computed in the background and cached until their source changes.

use std::sync::{Arc, OnceLock};

use egui::Context;

use super::SceneView;
use crate::geometry::metrics::Nearest;
use crate::inference::label_entropy;
use crate::io::{Shape, ShapeGeometry};
use crate::session::scalar::{
    Scalar, SurfaceScalar, Top, Unit, nearest_distances, own_distances, seed_entropy, surface_distances,
};
use crate::session::scene::SceneFromInput;
use crate::session::view::ColorBy;
use crate::ui::background::Background;
use crate::worker::{LoadedShape, Snapshot};

/// Maximum number of distances or labels computed within a frame; more are
/// computed in the background.
const QUICK: usize = 150_000;

/// What the values are computed from.
#[derive(Debug, Clone)]
struct Key {
    shape: Arc<LoadedShape>,
    by: ColorBy,
    /// That of the state, or the number of the runs.
    state: u64,
    /// States or runs that they are taken over.
    over: usize,
}

impl PartialEq for Key {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.shape, &other.shape)
            && (self.by, self.state, self.over) == (other.by, other.state, other.over)
    }
}

/// Values with a chosen end of the range.
#[derive(Debug, Clone)]
pub(super) enum Numbers {
    Points(Arc<Scalar>),
    Surfaces(Arc<SurfaceScalar>),
}

impl Numbers {
    fn with_top(&self, top: Top) -> Self {
        match self {
            Self::Points(scalar) => Self::Points(Arc::new(scalar.with_top(top))),
            Self::Surfaces(scalar) => Self::Surfaces(Arc::new(scalar.with_top(top))),
        }
    }
}

/// What the colours of a view show.
#[derive(Debug, Clone, Default)]
pub(super) enum ViewValues {
    /// No values.
    #[default]
    Nothing,
    /// Values that are not available, with the reason.
    Missing(&'static str),
    /// The last ones while new ones are computed.
    Numbers(Numbers),
}

/// Distances to a shape, prepared on first use.
type ToShape = Arc<OnceLock<Option<Nearest>>>;

/// The values of one view.
#[derive(Debug, Clone, Default)]
pub(super) struct Coloring {
    made: Background<Key, Numbers>,
    /// The last values, with the requested end of the range.
    shown: Option<(Arc<Numbers>, Top, Numbers)>,
    to_shape: Option<(Arc<Shape>, ToShape)>,
}

impl Coloring {
    /// What the view's colours show. If it takes long, `window` is redrawn when
    /// it is ready; without a window, this call waits.
    pub(super) fn update(&mut self, view: &SceneView<'_>, window: Option<&Context>) -> ViewValues {
        let by = view.view.color_by;
        let (Some(shape), Some(snapshot)) = (view.loaded, view.snapshot) else { return ViewValues::Nothing };
        let source = match self.source(by, view, shape, snapshot) {
            Ok(Some(source)) => source,
            Ok(None) => return ViewValues::Nothing,
            Err(why) => return ViewValues::Missing(why),
        };
        let (state, over) = source.key();
        let key = Key { shape: Arc::clone(shape), by, state, over };
        let is_quick = source.cost(shape) <= QUICK;
        let (shape, scene) = (Arc::clone(shape), *view.scene);
        let work = move || source.numbers(&shape, &scene);
        let found = self.made.get(&key, window.filter(|_| !is_quick), work);
        // The last ones stay, unless they tell of other samples or other things.
        let found = found.filter(|(of, _)| of.by == by && Arc::ptr_eq(&of.shape, &key.shape));
        let Some((_, numbers)) = found else { return ViewValues::Missing("Computing…") };
        let top = view.view.legend_top;
        let is_shown =
            |(of, with, _): &&(Arc<Numbers>, Top, Numbers)| Arc::ptr_eq(of, numbers) && *with == top;
        let shown = match self.shown.as_ref().filter(is_shown) {
            Some((.., shown)) => shown.clone(),
            None => numbers.with_top(top),
        };
        self.shown = Some((Arc::clone(numbers), top, shown.clone()));
        ViewValues::Numbers(shown)
    }

    /// What the numbers are made from; `None` where colours tell none, an error
    /// where there are none yet.
    fn source(
        &mut self,
        by: ColorBy,
        view: &SceneView<'_>,
        shape: &Arc<LoadedShape>,
        snapshot: &Arc<Snapshot>,
    ) -> Result<Option<Source>, &'static str> {
        let state = || {
            if snapshot.abstraction.primitives.is_empty() {
                return Err("This state has no primitives");
            }
            Ok(Arc::clone(snapshot))
        };
        Ok(Some(match by {
            ColorBy::Cluster | ColorBy::Input | ColorBy::Plain => return Ok(None),
            ColorBy::OwnDistance => Source::Own(state()?),
            ColorBy::NearestDistance => Source::Nearest(state()?),
            ColorBy::SurfaceDistance => Source::Surfaces(state()?, self.shape_distances(shape)),
            ColorBy::Uncertainty => {
                let window = view.view.uncertainty_window as usize;
                let last = &view.history[view.history.len().saturating_sub(window)..];
                if last.len() < 2 {
                    return Err("No history yet; step or run first");
                }
                Source::States(last.to_vec())
            }
            ColorBy::SeedUncertainty => {
                let seeds = view.seeds.filter(|s| s.loaded().is_some_and(|of| Arc::ptr_eq(of, shape)));
                let Some(seeds) = seeds else { return Err("No seed runs yet; choose Run 8 seeds") };
                let runs: Vec<Arc<Snapshot>> =
                    seeds.results().iter().filter_map(|r| r.last().cloned()).collect();
                if runs.len() < 2 {
                    return Err("Waiting for at least two seeds");
                }
                Source::Seeds(runs)
            }
        }))
    }

    fn shape_distances(&mut self, loaded: &LoadedShape) -> ToShape {
        let known = self.to_shape.as_ref().filter(|(shape, _)| Arc::ptr_eq(shape, &loaded.shape));
        let to_shape = known.map_or_else(ToShape::default, |(_, to_shape)| Arc::clone(to_shape));
        self.to_shape = Some((Arc::clone(&loaded.shape), Arc::clone(&to_shape)));
        to_shape
    }
}

/// What values are computed from.
enum Source {
    Own(Arc<Snapshot>),
    Nearest(Arc<Snapshot>),
    Surfaces(Arc<Snapshot>, ToShape),
    /// The last one is the present one.
    States(Vec<Arc<Snapshot>>),
    Seeds(Vec<Arc<Snapshot>>),
}

impl Source {
    /// The key's `state` and `over`.
    fn key(&self) -> (u64, usize) {
        match self {
            Self::Own(state) | Self::Nearest(state) | Self::Surfaces(state, _) => (state.key, 0),
            Self::States(states) => (states.last().map_or(0, |s| s.key), states.len()),
            Self::Seeds(runs) => (runs.first().map_or(0, |s| s.key), runs.len()),
        }
    }

    /// Approximate number of distances or labels to compute.
    fn cost(&self, shape: &LoadedShape) -> usize {
        let samples = shape.cloud.points.len();
        let primitives = |state: &Snapshot| state.abstraction.primitives.len();
        match self {
            Self::Own(_) => samples,
            Self::Nearest(state) => samples * primitives(state),
            // The first time a tree is built.
            Self::Surfaces(..) => usize::MAX,
            Self::States(states) | Self::Seeds(states) => samples * states.len(),
        }
    }

    fn numbers(self, shape: &LoadedShape, scene: &SceneFromInput) -> Numbers {
        let samples = &shape.cloud.points;
        let labels = |states: &[Arc<Snapshot>]| -> Vec<Arc<[u32]>> {
            states.iter().map(|s| Arc::clone(&s.abstraction.labels)).collect()
        };
        Numbers::Points(Arc::new(match self {
            Self::Own(state) => Scalar::from_zero(
                "Distance to own primitive",
                own_distances(samples, &state.abstraction, scene),
            ),
            Self::Nearest(state) => Scalar::from_zero(
                "Distance to nearest primitive",
                nearest_distances(samples, &state.abstraction, scene),
            ),
            Self::Surfaces(state, to_shape) => {
                let nearest = to_shape.get_or_init(|| {
                    match &shape.shape.geometry {
                        ShapeGeometry::Mesh(mesh) => Nearest::of_mesh(mesh),
                        ShapeGeometry::Cloud(cloud) => Nearest::of_cloud(&cloud.points),
                    }
                    .ok()
                });
                let values = nearest.as_ref().map_or_else(Vec::new, |nearest| {
                    surface_distances(&state.abstraction.primitives, nearest)
                });
                return Numbers::Surfaces(Arc::new(SurfaceScalar::from_zero("Distance to input", values)));
            }
            Self::States(states) => {
                let labels = labels(&states);
                let labels: Vec<&[u32]> = labels.iter().map(AsRef::as_ref).collect();
                let title = format!("Uncertainty over {} states", labels.len());
                Scalar::from_zero(&title, label_entropy(&labels)).with_unit(Unit::Share)
            }
            Self::Seeds(runs) => {
                let labels = labels(&runs);
                let labels: Vec<&[u32]> = labels.iter().map(AsRef::as_ref).collect();
                let title = format!("Disagreement among {} seeds", labels.len());
                Scalar::from_zero(&title, seed_entropy(&labels)).with_unit(Unit::Share)
            }
        }))
    }
}
