//! A session becomes records: each value once, before whatever refers to it.

use std::any::Any;
use std::borrow::Cow;
use std::io::{self, Write};
use std::sync::Arc;

use serde::Serialize;

use super::container::Kind;
use super::ledger::Ledger;
use super::raw::Raw;
use super::shapes::{CloudEntry, LoadedEntry, ShapeEntry};
use super::states::{BranchEntry, DocumentEntry, HeadEntry, StateEntry};
use crate::session::document::Document;
use crate::session::saving::Summary;
use crate::session::timeline::Branch;
use crate::session::undo::Step;
use crate::session::workspace::Workspace;
use crate::worker::{LoadedShape, Snapshot};

/// Writes what of the session isn't there yet, and a head.
pub(super) struct Writing<'a> {
    pub(super) ledger: &'a mut Ledger,
    pub(super) out: &'a mut dyn Write,
}

impl Writing<'_> {
    /// The present document and a head without undo history; then that history
    /// and a head with all: where the end of the file is lost, the document is
    /// not.
    pub(super) fn in_two_heads(&mut self, workspace: &Workspace) -> io::Result<()> {
        if !workspace.undo.done().is_empty() || !workspace.undo.undone().is_empty() {
            self.head(workspace, &[], &[])?;
        }
        self.whole(workspace)
    }

    /// All that isn't there yet and a head.
    pub(super) fn whole(&mut self, workspace: &Workspace) -> io::Result<()> {
        let head = self.head(workspace, workspace.undo.done(), workspace.undo.undone())?;
        self.ledger.settle(head);
        Ok(())
    }

    fn head(&mut self, workspace: &Workspace, done: &[Arc<Step>], undone: &[Arc<Step>]) -> io::Result<u32> {
        let document = self.document(&workspace.document)?;
        let mut refers = vec![document];
        let mut steps = |steps: &[Arc<Step>]| {
            let mut entries = Vec::with_capacity(steps.len());
            for step in steps {
                let number = self.step(step)?;
                refers.push(number);
                entries.push((Cow::Owned(step.label.clone()), number));
            }
            Ok::<_, io::Error>(entries)
        };
        let (done, undone) = (steps(done)?, steps(undone)?);
        let entry = HeadEntry {
            program: Cow::Borrowed(env!("CARGO_PKG_VERSION")),
            summary: Summary::of(&workspace.document, workspace.undo.done().len()),
            generations: generations(workspace),
            document,
            done,
            undone,
            pace: workspace.pace,
            is_live: workspace.is_live,
            view: workspace.view,
            camera: workspace.camera,
        };
        self.ledger.write(self.out, Kind::Head, &packed(&entry)?, refers)
    }

    fn step(&mut self, step: &Arc<Step>) -> io::Result<u32> {
        if let Some(number) = self.ledger.find(step) {
            return Ok(number);
        }
        let number = self.document(&step.document)?;
        self.ledger.note(step, number);
        Ok(number)
    }

    fn document(&mut self, document: &Document) -> io::Result<u32> {
        let Document { loaded, params, sampling, timeline, selection, selected_points, hidden } = document;
        let loaded = loaded.as_ref().map(|loaded| self.loaded(loaded)).transpose()?;
        let branches = timeline.branches().iter().map(|b| self.branch(b)).collect::<io::Result<Vec<_>>>()?;
        let refers = loaded.into_iter().chain(branches.iter().copied()).collect();
        let entry = DocumentEntry {
            loaded,
            params: *params,
            sampling: *sampling,
            branches,
            current: timeline.current_index(),
            shown: timeline.shown_index(),
            count: timeline.count(),
            selection: Cow::Borrowed(selection),
            selected_points: Raw::of(selected_points),
            hidden: Cow::Borrowed(hidden),
        };
        self.ledger.write_once(self.out, Kind::Document, packed(&entry)?, refers)
    }

    fn branch(&mut self, branch: &Branch) -> io::Result<u32> {
        let loaded = self.loaded(&branch.loaded)?;
        let states = branch.states.iter().map(|state| self.state(state)).collect::<io::Result<Vec<_>>>()?;
        let refers = states.iter().copied().chain([loaded]).collect();
        let entry = BranchEntry {
            id: branch.id,
            name: Cow::Borrowed(&branch.name),
            origin: branch.origin,
            loaded,
            states,
            colors: Cow::Borrowed(&branch.colors),
        };
        self.ledger.write_once(self.out, Kind::Branch, packed(&entry)?, refers)
    }

    fn loaded(&mut self, loaded: &Arc<LoadedShape>) -> io::Result<u32> {
        if let Some(number) = self.ledger.find(loaded) {
            return Ok(number);
        }
        let shape = self.shared(&loaded.shape, Kind::Shape, |shape| packed(&ShapeEntry::from(shape)))?;
        let cloud = self.shared(&loaded.cloud, Kind::Cloud, |cloud| packed(&CloudEntry::from(cloud)))?;
        let entry = LoadedEntry { generation: loaded.generation, shape, cloud, sampling: loaded.sampling };
        let number = self.ledger.write(self.out, Kind::Loaded, &packed(&entry)?, vec![shape, cloud])?;
        self.ledger.note(loaded, number);
        Ok(number)
    }

    fn state(&mut self, state: &Arc<Snapshot>) -> io::Result<u32> {
        self.shared(state, Kind::State, |state| packed(&StateEntry::from(state)))
    }

    /// The record of a value that refers to no other.
    fn shared<T: Any + Send + Sync>(
        &mut self,
        value: &Arc<T>,
        kind: Kind,
        content: impl FnOnce(&T) -> io::Result<Vec<u8>>,
    ) -> io::Result<u32> {
        if let Some(number) = self.ledger.find(value) {
            return Ok(number);
        }
        let number = self.ledger.write(self.out, kind, &content(value)?, Vec::new())?;
        self.ledger.note(value, number);
        Ok(number)
    }
}

/// MessagePack with the names of the fields.
fn packed(entry: &impl Serialize) -> io::Result<Vec<u8>> {
    rmp_serde::to_vec_named(entry).map_err(io::Error::other)
}

/// The generation of the present shape, and the newest of all.
fn generations(workspace: &Workspace) -> (u64, u64) {
    let steps = workspace.undo.done().iter().chain(workspace.undo.undone());
    let documents = steps.map(|step| &step.document).chain([&workspace.document]);
    let of = |document: &Document| document.loaded.as_ref().map_or(0, |loaded| loaded.generation);
    let branches = documents.clone().flat_map(|d| d.timeline.branches()).map(|b| b.loaded.generation);
    let newest = documents.map(of).chain(branches).max().unwrap_or(0);
    (of(&workspace.document), newest)
}
