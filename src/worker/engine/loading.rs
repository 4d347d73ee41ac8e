//! New shapes and new samples.

use std::sync::Arc;
use std::time::Duration;

use super::super::machine::Steppable;
use super::super::protocol::{Cause, Event, LoadedShape, SamplingOptions, Source};
use super::super::source;
use super::super::trouble::{Stop, guarded};
use super::Engine;
use super::present::Present;
use crate::geometry::SampleCloud;
use crate::inference::{Abstraction, Algorithm, Cancel, Occurrence, Params, Primitive};
use crate::io::{Opened, OpenedResult, ReadError, Shape};

impl<M: Steppable> Engine<M> {
    /// Whether there is a new shape; if not, all is as it was.
    pub(super) fn load(&mut self, source: &Source, sampling: SamplingOptions) -> bool {
        let what = match source {
            Source::File(path) => format!("Cannot open {}", path.display()),
            Source::BuiltIn => "Cannot open the built-in shape".to_owned(),
        };
        let cancel = self.cancel.clone();
        let params = self.params;
        let outcome = guarded(|| {
            if cancel.is_requested() {
                return Err(Stop::Cancelled);
            }
            match source::read(source).map_err(|error| Stop::trouble(what.as_str(), error))? {
                Opened::Shape(shape) => sampled::<M>(&what, Arc::from(shape), sampling, params, &cancel),
                Opened::Result(result) => taken::<M>(&what, *result, sampling, params, &cancel),
                Opened::Session(path) => {
                    Err(Stop::trouble(what.as_str(), ReadError::Session { path }.to_string()))
                }
            }
        });
        self.take_in(outcome)
    }

    /// Whether there are new samples; if not, all is as it was.
    pub(super) fn resample(&mut self, sampling: SamplingOptions) -> bool {
        let Some(present) = &self.present else {
            self.fail("Nothing to sample", "no shape is loaded; open one first");
            return false;
        };
        let shape = Arc::clone(&present.shape.shape);
        let cancel = self.cancel.clone();
        let params = self.params;
        let outcome = guarded(|| sampled::<M>("Cannot resample the shape", shape, sampling, params, &cancel));
        self.take_in(outcome)
    }

    /// Makes a freshly loaded shape the present one, or leaves all as it is;
    /// which of the two.
    fn take_in(&mut self, outcome: Result<Fresh<M>, Stop>) -> bool {
        match outcome {
            Ok(Fresh { shape, cloud, sampling, machine, abstraction, occurrences }) => {
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
    sampling: SamplingOptions,
    machine: M,
    abstraction: Abstraction,
    /// What was brought in with it.
    occurrences: Vec<Occurrence>,
}

fn sampled<M: Steppable>(
    what: &str,
    shape: Arc<Shape>,
    sampling: SamplingOptions,
    params: Params,
    cancel: &Cancel,
) -> Result<Fresh<M>, Stop> {
    let cloud = source::sample(&shape, sampling).map_err(|error| Stop::trouble(what, error))?;
    started(what, shape, cloud, sampling, params, cancel)
}

fn started<M: Steppable>(
    what: &str,
    shape: Arc<Shape>,
    cloud: Arc<SampleCloud>,
    sampling: SamplingOptions,
    params: Params,
    cancel: &Cancel,
) -> Result<Fresh<M>, Stop> {
    let machine =
        M::start(Arc::clone(&cloud), params, cancel).map_err(|error| Stop::inference(what, &error))?;
    let abstraction = machine.abstraction();
    Ok(Fresh { shape, cloud, sampling, machine, abstraction, occurrences: Vec::new() })
}

/// A result as the state that it was: on its own samples and with their labels,
/// where these are known.
fn taken<M: Steppable>(
    what: &str,
    result: OpenedResult,
    sampling: SamplingOptions,
    params: Params,
    cancel: &Cancel,
) -> Result<Fresh<M>, Stop> {
    // Only the sampler goes on from primitives.
    let params = Params { algorithm: Algorithm::Sampler, ..params };
    let known = result.samples();
    let edit = result.taken(known.as_ref().map_or_else(Vec::new, |(_, labels)| labels.clone()));
    let is_known = known.is_some();
    let is_lost = result.segmented.is_some() && !is_known;
    let (mut shape, stored) = (result.shape, result.stored);
    let mut notes = stored.notes.clone();
    if is_lost {
        notes.push(
            "its labels do not match the samples; each sample was assigned to the nearest primitive"
                .to_owned(),
        );
    }
    notes.append(&mut shape.notes);
    let shape = Arc::new(Shape { notes, ..shape });
    let mut fresh: Fresh<M> = match known {
        Some((cloud, _)) => started(what, shape, Arc::new(cloud), result.sampling, params, cancel)?,
        None => sampled(what, shape, sampling, params, cancel)?,
    };
    fresh.occurrences = fresh.machine.edit(&edit, cancel).map_err(|error| Stop::inference(what, &error))?;
    fresh.abstraction = fresh.machine.abstraction();
    let is_same = |(a, b): (&Primitive, &Primitive)| (a.id, a.points) == (b.id, b.points);
    let (found, known) = (&fresh.abstraction.primitives, &stored.primitives);
    if is_known && found.len() == known.len() && found.iter().zip(known).all(is_same) {
        // To the last bit, as the way to the run's own units and back is not.
        fresh.abstraction.primitives = stored.primitives.into();
    }
    Ok(fresh)
}
