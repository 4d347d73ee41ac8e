//! Records become a session again: only what the last head refers to.

use std::collections::HashMap;
use std::path::Path;
use std::sync::Arc;

use serde::de::DeserializeOwned;

use super::container::{Kind, Record, scan};
use super::error::{Fault, OpenError};
use super::shapes::{CloudEntry, LoadedEntry, ShapeEntry, belong_together};
use super::states::{BranchEntry, DocumentEntry, HeadEntry, StateEntry, is_ascending, is_counter};
use crate::geometry::SampleCloud;
use crate::inference::normalised_scale;
use crate::io::Shape;
use crate::session::document::Document;
use crate::session::saving::Summary;
use crate::session::timeline::{Branch, Timeline};
use crate::session::undo::{Step, Undo};
use crate::session::workspace::Workspace;
use crate::worker::{LoadedShape, Snapshot};

/// A session that was read.
#[derive(Debug)]
pub struct Opened {
    pub workspace: Workspace,
    /// What was lost, one sentence each.
    pub notes: Vec<String>,
}

/// Reads the session in a file, or in a journal. Where its end is missing or
/// damaged, what was whole before that is opened, with a note.
///
/// # Errors
/// One [`OpenError`] that says what is wrong, where, and what to do. Memory
/// stays within a small multiple of the file's size, whatever the file claims.
pub fn open(path: &Path) -> Result<Opened, OpenError> {
    let scan = scan(path)?;
    let mut fault = scan.rest;
    let mut library = Library::of(&scan.records);
    for head in heads(&scan.records) {
        match library.workspace(head) {
            Ok(workspace) => {
                let lost = |Fault { byte, problem }| {
                    format!(
                        "The file is damaged at byte {byte} ({problem}). Everything before that was opened; \
                         the rest is lost"
                    )
                };
                return Ok(Opened { workspace, notes: fault.map(lost).into_iter().collect() });
            }
            // The first to be found is the one to tell.
            Err(new) => fault = fault.or(Some(new)),
        }
    }
    Err(fault.unwrap_or_else(|| Fault::at(0, "it contains no session")).in_file(path.to_owned()))
}

/// What the session in a file comes to; `None` where the file holds none.
///
/// # Errors
/// As [`open`], but where what the head refers to is damaged.
pub(super) fn summary(path: &Path) -> Result<Option<Summary>, OpenError> {
    let scan = scan(path)?;
    Ok(heads(&scan.records).find_map(|head| decoded::<HeadEntry<'_>>(head).ok()).map(|head| head.summary))
}

/// The heads, the last one first.
fn heads(records: &[Record]) -> impl Iterator<Item = &Record> {
    records.iter().rev().filter(|record| record.kind == Kind::Head)
}

/// What a record holds.
fn decoded<T: DeserializeOwned>(record: &Record) -> Result<T, Fault> {
    rmp_serde::from_slice(&record.content()?)
        .map_err(|error| Fault::at(record.byte, format!("a {} cannot be read: {error}", record.kind.name())))
}

/// The records of a file, and the values that were made of them.
#[derive(Debug)]
struct Library<'a> {
    records: &'a [Record],
    /// The generation of the present shape, and the newest one. They change
    /// places: whatever is loaded next is to be newer than all there is, and
    /// the worker is told of the present shape only.
    generations: (u64, u64),
    shapes: HashMap<u32, Arc<Shape>>,
    clouds: HashMap<u32, Arc<SampleCloud>>,
    loaded: HashMap<u32, Arc<LoadedShape>>,
    states: HashMap<u32, Arc<Snapshot>>,
    branches: HashMap<u32, Branch>,
    documents: HashMap<u32, Document>,
}

impl<'a> Library<'a> {
    fn of(records: &'a [Record]) -> Self {
        Self {
            records,
            generations: (0, 0),
            shapes: HashMap::new(),
            clouds: HashMap::new(),
            loaded: HashMap::new(),
            states: HashMap::new(),
            branches: HashMap::new(),
            documents: HashMap::new(),
        }
    }

    fn workspace(&mut self, record: &Record) -> Result<Workspace, Fault> {
        let head: HeadEntry<'_> = decoded(record)?;
        if !(is_counter(head.generations.0) && is_counter(head.generations.1)) {
            return Err(Fault::at(record.byte, "a counter in the header is out of range"));
        }
        if head.generations != self.generations {
            self.generations = head.generations;
            // They bear generations of another head.
            self.loaded.clear();
            self.states.clear();
            self.branches.clear();
            self.documents.clear();
        }
        let document = self.document(head.document)?;
        let mut steps = |entries: Vec<(_, u32)>| {
            let step = |(label, number): (std::borrow::Cow<'_, str>, u32)| {
                Ok(Arc::new(Step { label: label.into_owned(), document: self.document(number)? }))
            };
            entries.into_iter().map(step).collect::<Result<Vec<_>, Fault>>()
        };
        let (done, undone) = (steps(head.done)?, steps(head.undone)?);
        if !head.camera.is_sound() || !head.view.is_sound() {
            return Err(Fault::at(record.byte, "the camera or the view is out of range"));
        }
        Ok(Workspace {
            document,
            undo: Undo::from_parts(done, undone),
            pace: head.pace,
            is_live: head.is_live,
            view: head.view,
            camera: head.camera,
        })
    }

    /// The record of that number, if it is of that kind.
    fn record(&self, number: u32, kind: Kind) -> Result<&'a Record, Fault> {
        let record = self.records.get(number as usize);
        record.filter(|record| record.kind == kind).ok_or_else(|| {
            let byte = record.map_or(0, |record| record.byte);
            Fault::at(byte, format!("record {number} is not a {}", kind.name()))
        })
    }

    /// Decodes a record; also what says that its content can't be.
    fn read<T: DeserializeOwned>(
        &self,
        number: u32,
        kind: Kind,
    ) -> Result<(T, impl Fn(&str) -> Fault + use<T>), Fault> {
        let record = self.record(number, kind)?;
        let (byte, name) = (record.byte, kind.name());
        Ok((decoded(record)?, move |problem: &str| Fault::at(byte, format!("a {name} {problem}"))))
    }

    fn generation(&self, generation: u64) -> u64 {
        let (present, newest) = self.generations;
        match generation {
            g if g == present => newest,
            g if g == newest => present,
            g => g,
        }
    }

    fn document(&mut self, number: u32) -> Result<Document, Fault> {
        if let Some(document) = self.documents.get(&number) {
            return Ok(document.clone());
        }
        let (entry, wrong) = self.read::<DocumentEntry<'_>>(number, Kind::Document)?;
        let loaded = entry.loaded.map(|loaded| self.loaded(loaded)).transpose()?;
        let branches =
            entry.branches.into_iter().map(|b| self.branch(b)).collect::<Result<Vec<_>, Fault>>()?;
        let samples = loaded.as_ref().map_or(0, |loaded| loaded.cloud.points.len());
        let selected_points = entry.selected_points.into_vec();
        if !is_ascending(&selected_points, samples) {
            return Err(wrong("selects a sample that does not exist"));
        }
        if entry.params.check().is_err() || entry.sampling.check().is_err() {
            return Err(wrong("has a parameter out of range"));
        }
        let document = Document {
            loaded,
            params: entry.params,
            sampling: entry.sampling,
            timeline: Timeline::from_parts(branches, entry.current, entry.shown, entry.count)
                .ok_or_else(|| wrong("has a timeline without a shown state"))?,
            selection: entry.selection.into_owned(),
            selected_points: selected_points.into(),
            hidden: entry.hidden.into_owned(),
        };
        self.documents.insert(number, document.clone());
        Ok(document)
    }

    fn branch(&mut self, number: u32) -> Result<Branch, Fault> {
        if let Some(branch) = self.branches.get(&number) {
            return Ok(branch.clone());
        }
        let (entry, wrong) = self.read::<BranchEntry<'_>>(number, Kind::Branch)?;
        let loaded = self.loaded(entry.loaded)?;
        let states = entry.states.into_iter().map(|s| self.state(s)).collect::<Result<Vec<_>, Fault>>()?;
        let samples = loaded.cloud.points.len();
        let fits = |state: &Arc<Snapshot>| {
            state.abstraction.labels.len() == samples && is_ascending(&state.abstraction.pinned, samples)
        };
        if !states.iter().all(fits) {
            return Err(wrong("has a state of a different cloud"));
        }
        // A branch leaves an older one, at a state that both have.
        if entry.origin.is_some_and(|o| o.branch >= entry.id || o.index >= states.len()) {
            return Err(wrong("starts at a state that does not exist in its parent branch"));
        }
        let branch = Branch {
            id: entry.id,
            name: entry.name.into_owned(),
            origin: entry.origin,
            loaded,
            states,
            colors: Arc::new(entry.colors.into_owned()),
        };
        self.branches.insert(number, branch.clone());
        Ok(branch)
    }

    fn loaded(&mut self, number: u32) -> Result<Arc<LoadedShape>, Fault> {
        if let Some(loaded) = self.loaded.get(&number) {
            return Ok(Arc::clone(loaded));
        }
        let (entry, wrong) = self.read::<LoadedEntry>(number, Kind::Loaded)?;
        let (shape, cloud) = (self.shape(entry.shape)?, self.cloud(entry.cloud)?);
        if !belong_together(&shape, &cloud) {
            return Err(wrong("has the samples of a different shape"));
        }
        if entry.sampling.check().is_err() {
            return Err(wrong("has a parameter out of range"));
        }
        if normalised_scale(&cloud.points).is_none() {
            return Err(wrong("has samples with zero or too large an extent"));
        }
        if !is_counter(entry.generation) {
            return Err(wrong("has a counter out of range"));
        }
        let generation = self.generation(entry.generation);
        let loaded = Arc::new(LoadedShape { generation, shape, cloud, sampling: entry.sampling });
        self.loaded.insert(number, Arc::clone(&loaded));
        Ok(loaded)
    }

    fn shape(&mut self, number: u32) -> Result<Arc<Shape>, Fault> {
        if let Some(shape) = self.shapes.get(&number) {
            return Ok(Arc::clone(shape));
        }
        let (entry, wrong) = self.read::<ShapeEntry<'_>>(number, Kind::Shape)?;
        let shape = Arc::new(entry.checked().map_err(wrong)?);
        self.shapes.insert(number, Arc::clone(&shape));
        Ok(shape)
    }

    fn cloud(&mut self, number: u32) -> Result<Arc<SampleCloud>, Fault> {
        if let Some(cloud) = self.clouds.get(&number) {
            return Ok(Arc::clone(cloud));
        }
        let (entry, wrong) = self.read::<CloudEntry<'_>>(number, Kind::Cloud)?;
        let cloud = Arc::new(entry.checked().map_err(wrong)?);
        self.clouds.insert(number, Arc::clone(&cloud));
        Ok(cloud)
    }

    fn state(&mut self, number: u32) -> Result<Arc<Snapshot>, Fault> {
        if let Some(state) = self.states.get(&number) {
            return Ok(Arc::clone(state));
        }
        let (mut entry, wrong) = self.read::<StateEntry<'_>>(number, Kind::State)?;
        entry.generation = self.generation(entry.generation);
        let state = Arc::new(entry.checked().map_err(wrong)?);
        self.states.insert(number, Arc::clone(&state));
        Ok(state)
    }
}
