//! A machine that counts instead of sampling, and stalls or panics on demand.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use nalgebra::{Point3, Vector3};

use crate::geometry::{SampleCloud, Superquadric};
use crate::inference::{
    Abstraction, Cancel, Checkpoint, Edit, Figures, InferenceError, MergeProposal, MergeReason, MergeReport,
    Occurrence, Params, Phase, Primitive, Sighting, UNASSIGNED,
};
use crate::worker::machine::Steppable;

/// The seed tells the scripted machine how to behave.
pub(super) const WELL_BEHAVED: u64 = 1;
pub(super) const PANICS_AT_THIRD: u64 = 2;
/// Panics where nothing catches it.
pub(super) const ENDS_AT_THIRD: u64 = 3;
pub(super) const FINDS_NOTHING: u64 = 4;
pub(super) const STALLS_AT_THIRD: u64 = 10;
/// As those that stall, until the gate is opened.
pub(super) const WAITS_AT_THIRD: u64 = 20;
pub(super) const MERGES_LEFT: u32 = 3;

/// Whether a machine of this seed is inside a step that only cancelling, or the
/// gate, ends.
pub(super) static STALLED: [AtomicBool; 30] = [const { AtomicBool::new(false) }; 30];
pub(super) static GATES: [AtomicBool; 30] = [const { AtomicBool::new(false) }; 30];
/// Steps that machines of this seed have begun.
pub(super) static STEPS: [AtomicUsize; 30] = [const { AtomicUsize::new(0) }; 30];

/// Counts instead of sampling.
#[derive(Debug, Clone)]
pub(super) struct Scripted {
    points: usize,
    /// About as large as the shape, and where that is: quickly measured.
    ball: Superquadric,
    params: Params,
    iteration: u32,
    merges: u32,
}

/// The ball around the centre of points that about half of them are in.
fn ball(points: &[Point3<f64>]) -> Superquadric {
    let count = points.len().max(1) as f64;
    let center = Point3::from(points.iter().map(|p| p.coords).sum::<Vector3<f64>>() / count);
    let spread = points.iter().map(|p| (p - center).norm_squared()).sum::<f64>() / count;
    Superquadric::sphere(center, spread.sqrt().max(1.0))
}

impl Steppable for Scripted {
    fn start(cloud: Arc<SampleCloud>, params: Params, _: &Cancel) -> Result<Self, InferenceError> {
        Ok(Self { points: cloud.points.len(), ball: ball(&cloud.points), params, iteration: 0, merges: 0 })
    }
    fn restarted(&self, params: Params, _: &Cancel) -> Result<Self, InferenceError> {
        Ok(Self { params, iteration: 0, merges: 0, ..self.clone() })
    }
    fn resumed(&self, checkpoint: &Checkpoint, cancel: &Cancel) -> Result<Self, InferenceError> {
        let cloud = Arc::new(SampleCloud::from_points(&[]));
        let Self { points, ball, .. } = *self;
        Ok(Self { points, ball, ..Self::resume(cloud, checkpoint, cancel)? })
    }
    fn resume(cloud: Arc<SampleCloud>, checkpoint: &Checkpoint, _: &Cancel) -> Result<Self, InferenceError> {
        let Checkpoint { params, iteration, next_id, .. } = *checkpoint;
        let ball = ball(&cloud.points);
        Ok(Self { points: cloud.points.len(), ball, params, iteration, merges: next_id })
    }
    fn checkpoint(&self) -> Checkpoint {
        assert!(self.params.seed != ENDS_AT_THIRD || self.iteration != 3, "nobody catches this");
        Checkpoint {
            params: self.params,
            phase: Phase::Sampling,
            iteration: self.iteration,
            clusters: Vec::new(),
            labels: Vec::new(),
            frozen: Vec::new(),
            pinned: Vec::new(),
            next_id: self.merges,
            next_revision: 0,
            work: crate::inference::runs::checkpoint::Remaining::Sampler,
        }
    }
    /// Any edit is one more merge; that of primitive 0 is refused.
    fn edit(&mut self, edit: &Edit, _: &Cancel) -> Result<Vec<Occurrence>, InferenceError> {
        if *edit == (Edit::Refit { id: 0 }) {
            return Err(InferenceError::Params("there is no primitive 0".to_owned()));
        }
        self.merges += 1;
        Ok(vec![Occurrence::Died { id: 100 }])
    }
    fn extend(&mut self, iterations: u32) -> Result<(), InferenceError> {
        self.params.iterations = self.iteration + iterations;
        Ok(())
    }
    fn propose_merge(
        &mut self,
        _: Option<(u32, u32)>,
        _: &[(u32, u32)],
        _: &Cancel,
    ) -> Result<Option<MergeProposal>, InferenceError> {
        Ok(None)
    }
    fn params(&self) -> Params {
        self.params
    }
    fn set_params(&mut self, params: Params) -> Result<(), InferenceError> {
        self.params = params;
        Ok(())
    }
    fn is_finished(&self) -> bool {
        self.iteration >= self.params.iterations
    }
    fn step(&mut self, cancel: &Cancel) -> Result<Vec<Occurrence>, InferenceError> {
        self.iteration += 1;
        let seed = self.params.seed;
        STEPS[seed as usize].fetch_add(1, Ordering::SeqCst);
        if seed == PANICS_AT_THIRD && self.iteration == 3 {
            panic!("the third step always panics");
        }
        if seed >= STALLS_AT_THIRD && self.iteration == 3 {
            STALLED[seed as usize].store(true, Ordering::SeqCst);
            let is_open = || seed >= WAITS_AT_THIRD && GATES[seed as usize].load(Ordering::SeqCst);
            while !cancel.is_requested() && !is_open() {
                std::thread::yield_now();
            }
            if cancel.is_requested() {
                return Err(InferenceError::Cancelled);
            }
        }
        Ok(vec![Occurrence::Died { id: self.iteration }])
    }
    fn step_merge(&mut self, _: &Cancel) -> Result<Vec<MergeReport>, InferenceError> {
        if self.merges == MERGES_LEFT {
            return Ok(Vec::new());
        }
        self.merges += 1;
        Ok(vec![MergeReport { merged: (self.merges, 9), into: 9, reason: MergeReason::SwitchedOff }])
    }
    fn abstraction(&self) -> Abstraction {
        let found =
            Primitive { id: 1, shape: self.ball, sigma: 0.1, points: 0, mean_distance: 0.0, locked: false };
        let primitives = if self.params.seed == FINDS_NOTHING { Vec::new() } else { vec![found] };
        Abstraction {
            phase: Phase::Sampling,
            iteration: self.iteration,
            labels: vec![UNASSIGNED; self.points].into(),
            pinned: [].into(),
            primitives: primitives.into(),
            figures: Figures { clusters: self.merges as usize, ..Figures::default() },
            sighting: Sighting::default(),
        }
    }
}
