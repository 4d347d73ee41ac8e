//! New shapes and new samples.

use std::sync::Arc;
use std::time::Duration;

use super::super::machine::Machine;
use super::super::protocol::{Cause, Event, LoadedShape, SamplingOptions, Source};
use super::super::source;
use super::super::trouble::{Stop, guarded};
use super::{Engine, Present};
use crate::geometry::SampleCloud;
use crate::inference::{Abstraction, Algorithm, Cancel, Occurrence, Params};
use crate::io::Shape;

impl<M: Machine> Engine<M> {
    /// Whether there is a new shape; if not, all is as it was.
    pub(super) fn load(&mut self, source: &Source, sampling: SamplingOptions) -> bool {
        let what = match source {
            Source::File(path) => format!("{} could not be opened", path.display()),
            Source::BuiltIn => "The built-in shape could not be opened".to_owned(),
        };
        let cancel = self.cancel.clone();
        let params = self.params;
        let present = self.present.as_ref().map(|p| Arc::clone(&p.shape.shape));
        let outcome = guarded(|| {
            if cancel.is_requested() {
                return Err(Stop::Cancelled);
            }
            let found = source::read(source, present.as_ref())
                .map_err(|error| Stop::trouble(what.as_str(), error))?;
            let Some(edit) = found.primitives else {
                return sampled::<M>(&what, found.shape, sampling, params, &cancel);
            };
            // Only the sampler goes on from primitives.
            let params = Params { algorithm: Algorithm::Sampler, ..params };
            let mut fresh = sampled::<M>(&what, found.shape, sampling, params, &cancel)?;
            fresh.occurrences =
                fresh.machine.edit(&edit, &cancel).map_err(|error| Stop::inference(&what, &error))?;
            fresh.abstraction = fresh.machine.abstraction();
            Ok(fresh)
        });
        self.take_in(outcome, sampling)
    }

    /// Whether there are new samples; if not, all is as it was.
    pub(super) fn resample(&mut self, sampling: SamplingOptions) -> bool {
        let Some(present) = &self.present else {
            self.fail("There is nothing to sample", "no shape is loaded; open one first");
            return false;
        };
        let shape = Arc::clone(&present.shape.shape);
        let cancel = self.cancel.clone();
        let params = self.params;
        let outcome =
            guarded(|| sampled::<M>("The shape could not be sampled anew", shape, sampling, params, &cancel));
        self.take_in(outcome, sampling)
    }

    /// Makes a freshly loaded shape the present one, or leaves all as it is;
    /// which of the two.
    fn take_in(&mut self, outcome: Result<Fresh<M>, Stop>, sampling: SamplingOptions) -> bool {
        match outcome {
            Ok(Fresh { shape, cloud, machine, abstraction, occurrences }) => {
                self.drop_renewal();
                self.generation += 1;
                let shape = Arc::new(LoadedShape { generation: self.generation, shape, cloud, sampling });
                self.emit(Event::Loaded(Arc::clone(&shape)));
                self.present = Some(Present {
                    shape,
                    run: 1,
                    start: machine.params(),
                    machine,
                    abstraction,
                    elapsed: Duration::ZERO,
                    unmeasured: None,
                });
                self.emit_snapshot(Cause::Start, occurrences);
                true
            }
            Err(stop) => {
                self.report(stop);
                false
            }
        }
    }
}

/// What loading comes to.
struct Fresh<M> {
    shape: Arc<Shape>,
    cloud: Arc<SampleCloud>,
    machine: M,
    abstraction: Abstraction,
    /// What was brought in with it.
    occurrences: Vec<Occurrence>,
}

fn sampled<M: Machine>(
    what: &str,
    shape: Arc<Shape>,
    sampling: SamplingOptions,
    params: Params,
    cancel: &Cancel,
) -> Result<Fresh<M>, Stop> {
    let cloud = source::sample(&shape, sampling).map_err(|error| Stop::trouble(what, error))?;
    let machine =
        M::start(Arc::clone(&cloud), params, cancel).map_err(|error| Stop::inference(what, &error))?;
    let abstraction = machine.abstraction();
    Ok(Fresh { shape, cloud, machine, abstraction, occurrences: Vec::new() })
}
