//! Exports results and imports primitives, with files and the clipboard.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::action::Level;
use super::window::ExportChoice;
use super::{Effect, Session};
use crate::io::{self, Format, Inputs, Kind, Outcome, PrimitiveSet, ShapeGeometry};
use crate::worker::{Command, ExportRequest, LoadedShape};

impl Session {
    /// Why the shown state cannot be exported to a format; `None` if it can.
    pub fn why_not_exported(&self, format: Format) -> Option<&'static str> {
        let is_cloud = |s: &io::Shape| matches!(s.geometry, ShapeGeometry::Cloud(_));
        let loaded = self.loaded.as_ref();
        if format.needs_mesh() && loaded.is_some_and(|l| is_cloud(&l.shape)) {
            return Some("The input is a point cloud; a segmented mesh needs a mesh");
        }
        let needs_primitives = !matches!(format.kind(), Kind::Cloud | Kind::Mesh);
        (needs_primitives && self.primitives().is_empty()).then_some("No primitives")
    }

    /// Approximate size of the shown state in a format, in bytes.
    pub fn export_size(&self, choice: &ExportChoice) -> Option<u64> {
        self.with_outcome(|outcome| io::estimated_size(choice.format, &choice.options, outcome))
    }

    /// A suggested file name, without folder.
    pub fn export_name(&self, format: Format) -> String {
        let name = self.loaded.as_ref().map_or("superform", |l| l.shape.name.as_str());
        let stem = Path::new(name).file_stem().map_or(name.into(), |s| s.to_string_lossy());
        let what = match format.kind() {
            Kind::Cloud => "segmented",
            Kind::Mesh => "parts",
            Kind::Primitives | Kind::Scene => "primitives",
        };
        format!("{stem}-{what}.{}", format.ending())
    }

    /// Exports the shown state with the last options.
    pub(super) fn export(&mut self, path: PathBuf) -> Vec<Effect> {
        let Some(state) = self.shown_state() else { return Vec::new() };
        let ExportChoice { format, options } = self.window.export;
        if !self.may_write(&path, &io::outputs(&path, format, &options)) {
            return Vec::new();
        }
        self.window.save_folder = path.parent().map(PathBuf::from);
        self.exported = Some((path.clone(), Arc::downgrade(&state.loaded.shape)));
        let colors = self.timeline.current().map(|b| Arc::clone(&b.colors)).unwrap_or_default();
        let request = ExportRequest { path, format, options, state, colors };
        vec![Effect::Send(Command::Export(Box::new(request)))]
    }

    /// The file of the current shape's last export. Exports of other shapes must
    /// not be overwritten.
    pub(super) fn exported(&self) -> Option<&Path> {
        let (path, shape) = self.exported.as_ref()?;
        let is_of = |loaded: &Arc<LoadedShape>| std::ptr::eq(shape.as_ptr(), Arc::as_ptr(&loaded.shape));
        self.loaded.as_ref().is_some_and(is_of).then_some(path)
    }

    /// Writes a file, unless it is the open one.
    pub(super) fn write(&mut self, path: PathBuf, effect: impl FnOnce(PathBuf) -> Effect) -> Vec<Effect> {
        if !self.may_write(&path, std::slice::from_ref(&path)) {
            return Vec::new();
        }
        self.window.save_folder = path.parent().map(PathBuf::from);
        vec![effect(path)]
    }

    /// Whether files may be written. Adds an error if one of them is the open shape's own file.
    fn may_write(&mut self, path: &Path, outputs: &[PathBuf]) -> bool {
        let mut inputs = Inputs::default();
        let open = self.loaded.as_ref().and_then(|loaded| loaded.shape.path.as_deref());
        open.into_iter().for_each(|path| inputs.add(path));
        let checked = inputs.check(outputs);
        if let Err(error) = &checked {
            self.fail(format!("Cannot write {}", path.display()), &error.to_string());
        }
        checked.is_ok()
    }

    /// Writes to the file of the last export again.
    pub(super) fn export_again(&mut self) -> Vec<Effect> {
        self.exported().map(Path::to_owned).map_or_else(Vec::new, |path| self.export(path))
    }

    /// The shown primitives as a text for the clipboard.
    pub(super) fn copy_primitives(&mut self, format: Format) -> Vec<Effect> {
        let text = self.with_outcome(|outcome| io::primitives_text(format, &PrimitiveSet::from(outcome)));
        match text {
            None => Vec::new(),
            Some(Err(error)) => {
                self.fail("Cannot copy the primitives".to_owned(), &error.to_string());
                Vec::new()
            }
            Some(Ok(text)) => {
                let count = self.primitives().len();
                let what = if count == 1 { "primitive" } else { "primitives" };
                let text_note = format!("Copied {count} {what} as {}", format.title());
                self.messages.push(Level::Note, text_note, "");
                vec![Effect::Copy(text.into())]
            }
        }
    }

    /// Replaces the shown primitives with those in a text.
    pub(super) fn paste_primitives(&mut self, text: &str) -> Vec<Effect> {
        match io::parse_primitives(text.as_bytes(), Path::new("the clipboard"), None) {
            Ok(stored) => self.edit(vec![stored.brought_in()]),
            Err(error) => {
                self.fail("Cannot paste primitives".to_owned(), &error.to_string());
                Vec::new()
            }
        }
    }

    /// Replaces the shown primitives with those in a file.
    pub(super) fn take_from(&mut self, path: PathBuf) -> Vec<Effect> {
        self.window.open_folder = path.parent().map(PathBuf::from);
        self.by_hand(vec![Command::TakeFrom(path)])
    }

    fn with_outcome<T>(&self, look: impl FnOnce(&Outcome<'_>) -> T) -> Option<T> {
        let state = self.shown_state()?;
        let colors = self.timeline.current().map(|b| Arc::clone(&b.colors)).unwrap_or_default();
        Some(look(&Outcome {
            colors: &colors,
            shape: &state.loaded.shape,
            cloud: &state.loaded.cloud,
            sampling: state.loaded.sampling,
            params: &state.snapshot.params,
            abstraction: &state.snapshot.abstraction,
        }))
    }
}
