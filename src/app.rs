//! The window: the composition root of worker, session and interface. `run` opens an [`App`], which
//! is made of `place`, `saving` and `screenshots`.

mod place;
mod run;
mod saving;
mod screenshots;

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender, sync_channel};
use std::time::{Duration, Instant};

use anyhow::Context as _;

use crate::cli::Journal;
use crate::inference::Params;
use crate::io;
use crate::session::action::{Level, Message};
use crate::session::saving::{KeepingEvent, Opening};
use crate::session::{Action, Effect, Session, Verb};
use crate::ui::{Interface, Purpose, Sizes};
use crate::worker::{Command, Event, Pace, SamplingOptions, Source, Worker};

use place::{Place, Placing};
pub use run::{RunError, run};
use saving::Saving;
use screenshots::{Saved, Screenshots};

/// Names in the store of what is remembered.
const PREFERENCES: &str = "preferences";
const SIZES: &str = "sizes";
const PLACE: &str = "place";
/// What eframe would keep of the window.
const OTHER_PLACE: &str = "window";

/// What the window is started with.
#[derive(Debug, Clone)]
pub struct Options {
    pub source: Source,
    pub sampling: SamplingOptions,
    pub params: Params,
    /// Save what the window shows when the run has ended, and close.
    pub screenshot: Option<PathBuf>,
    /// Where the session is kept for the case of a crash; `None` to keep nothing.
    pub state_folder: Option<PathBuf>,
    /// Start as if nothing had been remembered.
    pub reset_layout: bool,
}

/// The application.
#[derive(Debug)]
pub struct App {
    session: Session,
    worker: Worker,
    interface: Interface,
    title: String,
    screenshots: Screenshots,
    gpu_errors: Receiver<String>,
    /// What the program logs.
    journal: Option<Journal>,
    /// Whether what is set now is for the next start, too.
    remembers: bool,
    outcome: Option<Sender<anyhow::Result<()>>>,
    start: Start,
    saving: Saving,
    /// The window is to close, whatever is unsaved.
    is_leaving: bool,
    placing: Placing,
}

/// How far the program has come on its way to the first picture.
#[derive(Debug, Clone, Copy)]
enum Start {
    Since(Instant),
    /// The first frame was laid out; before the second it has been drawn.
    Drawn(Instant),
    Over,
}

impl App {
    /// Starts the worker, which loads the source and runs it at once.
    ///
    /// # Errors
    /// If the operating system gives no thread.
    pub fn new(cc: &eframe::CreationContext<'_>, options: &Options) -> std::io::Result<Self> {
        Self::with_dialogs(cc, options, true)
    }

    /// As [`App::new`], with paths always typed instead of the system's
    /// dialogs where `system_dialogs` is false.
    ///
    /// # Errors
    /// As [`App::new`].
    pub fn with_dialogs(
        cc: &eframe::CreationContext<'_>,
        options: &Options,
        system_dialogs: bool,
    ) -> std::io::Result<Self> {
        let (errors, gpu_errors) = sync_channel(8);
        if let Some(state) = &cc.wgpu_render_state {
            state.device.on_uncaptured_error(Arc::new(move |error: egui_wgpu::wgpu::Error| {
                // Another target than the journal's: it is told below.
                tracing::error!(target: "superform_graphics", "{error}");
                // A full channel means that the person knows already.
                let _ = errors.try_send(error.to_string());
            }));
        }
        let ctx = cc.egui_ctx.clone();
        let mut worker = Worker::spawn(move || ctx.request_repaint())?;
        let mut session = Session::new(options.params, options.sampling);
        let mut interface = Interface::new(&cc.egui_ctx, cc.wgpu_render_state.as_ref(), system_dialogs);
        // A picture shows what the program makes of its input, not what was set before.
        let remembers = options.screenshot.is_none();
        let mut place: Option<Place> = None;
        if let (true, false, Some(storage)) = (remembers, options.reset_layout, cc.storage) {
            if let Some(preferences) = stored(storage, PREFERENCES) {
                session.recall(preferences);
            }
            if let Some(sizes) = stored(storage, SIZES) {
                interface.set_sizes(sizes);
            }
            place = stored(storage, PLACE);
        }
        let placing = if remembers { Placing::new(cc, place) } else { Placing::default() };
        if options.screenshot.is_some() {
            session.pace = Pace::Unlimited;
        }
        // A window that is there for its picture keeps nothing.
        let state_folder = options.state_folder.clone().filter(|_| options.screenshot.is_none());
        let mut saving = Saving::start(state_folder, &cc.egui_ctx)?;
        // What is to be shown is read while the pipelines are built.
        match &options.source {
            Source::File(path) if io::has_session_ending(path) => {
                saving.open(Opening::File(path.clone()), &session);
                worker.send(Command::SetParams(session.params));
                worker.send(Command::SetPace(session.pace));
            }
            source => session.begin(source.clone()).into_iter().for_each(|command| worker.send(command)),
        }
        Ok(Self {
            session,
            worker,
            interface,
            title: String::new(),
            screenshots: Screenshots::new(options.screenshot.clone()),
            gpu_errors,
            journal: None,
            remembers,
            outcome: None,
            start: Start::Over,
            saving,
            is_leaving: false,
            placing,
        })
    }

    /// What the window knows.
    pub fn session(&self) -> &Session {
        &self.session
    }

    /// Shows warnings and errors of this journal in the window's log.
    pub fn listen(&mut self, journal: Journal) {
        self.journal = Some(journal);
    }

    /// What stands in the window's title bar.
    pub fn title(&self) -> &str {
        &self.title
    }

    /// Waits for the next event of the worker and takes it in; whether there
    /// was one within `timeout`.
    pub fn wait(&mut self, ctx: &egui::Context, timeout: Duration) -> bool {
        let event = self.worker.next_event(timeout);
        let came = event.is_some();
        if let Some(event) = event {
            self.absorb(ctx, event);
        }
        came
    }

    fn absorb(&mut self, ctx: &egui::Context, event: Event) {
        match &event {
            Event::LiveStarted(_) => tracing::debug!("a renewal has begun"),
            Event::LiveFinished(_) => tracing::debug!("a renewal was finished"),
            _ => {}
        }
        let effects = self.session.absorb(event);
        self.carry_out(ctx, effects);
    }

    fn apply(&mut self, ctx: &egui::Context, action: Action) {
        let effects = self.session.apply(action);
        self.carry_out(ctx, effects);
    }

    fn carry_out(&mut self, ctx: &egui::Context, effects: Vec<Effect>) {
        for effect in effects {
            match effect {
                Effect::Send(command) => self.send(command),
                Effect::AskForShape => self.ask(ctx, Purpose::Open),
                Effect::AskForExport => self.interface.ask_for_export(&self.session),
                Effect::AskForPrimitives => self.ask(ctx, Purpose::Primitives),
                Effect::Copy(text) => ctx.copy_text(text.into_inner()),
                Effect::RequestPaste => ctx.send_viewport_cmd(egui::ViewportCommand::RequestPaste),
                Effect::AskForScreenshot => self.ask(ctx, Purpose::Screenshot),
                Effect::SaveScreenshot(path) => self.screenshots.request(ctx, path),
                Effect::AskForSession => self.ask(ctx, Purpose::Session),
                Effect::SaveSession(path) => self.saving.save(path, &self.session),
                Effect::OpenSession(opening) => self.saving.open(opening, &self.session),
                Effect::DiscardFound(id) => self.saving.discard(id),
                Effect::Quit => {
                    self.is_leaving = true;
                    ctx.send_viewport_cmd(egui::ViewportCommand::Close);
                }
                Effect::OpenIfThere(path) => {
                    let there = path.exists();
                    let action = if there { Action::OpenFile(path) } else { Action::ForgetRecent(path) };
                    self.apply(ctx, action);
                }
                Effect::ShowInFolder(path) => {
                    // No file manager selects a file by one call on all systems.
                    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
                    self.open_outside(ctx, folder.unwrap_or(Path::new(".")).as_os_str());
                }
                Effect::OpenLink(address) => self.open_outside(ctx, address.as_ref()),
                Effect::ResetLayout => {
                    self.interface.set_sizes(Sizes::default());
                }
                Effect::AskForPicture(kind) => self.interface.ask_for_picture(kind),
                Effect::SavePicture(kind, path) => {
                    if let Err(error) = self.interface.save_picture(ctx, &self.session, kind, path) {
                        let what = "Cannot render the picture".to_owned();
                        self.apply(ctx, Action::Tell { what, error });
                    }
                }
            }
        }
    }

    /// Waits for the autosave's next event and takes it in; whether there was
    /// one within `timeout`.
    pub fn wait_for_keeper(&mut self, ctx: &egui::Context, timeout: Duration) -> bool {
        let event = self.saving.next_event(timeout);
        let came = event.is_some();
        if let Some(event) = event {
            self.absorb_kept(ctx, event);
        }
        came
    }

    fn absorb_kept(&mut self, ctx: &egui::Context, event: KeepingEvent) {
        let effects = self.session.absorb_keeping(event);
        self.carry_out(ctx, effects);
    }

    /// Asks before the window system closes the window over unsaved work that
    /// nothing else keeps.
    fn watch_closing(&mut self, ctx: &egui::Context) {
        if self.is_leaving || !ctx.input(|input| input.viewport().close_requested()) {
            return;
        }
        let effects = self.session.apply(Action::Verb(Verb::Quit));
        if !effects.iter().any(|effect| matches!(effect, Effect::Quit)) {
            ctx.send_viewport_cmd(egui::ViewportCommand::CancelClose);
        }
    }

    /// Waits until all that is to be kept is on the disk: unsaved work as the
    /// last session.
    pub fn close(&mut self) {
        self.saving.close(&self.session);
    }

    fn send(&mut self, command: Command) {
        tracing::debug!(?command, "to the worker");
        self.worker.send(command);
    }

    /// Opens a folder or an address in the program that the system has for it.
    fn open_outside(&mut self, ctx: &egui::Context, what: &std::ffi::OsStr) {
        if let Err(error) = open::that_detached(what) {
            let what = format!("Cannot open {}", what.display());
            self.apply(ctx, Action::Tell { what, error: error.to_string() });
        }
    }

    fn ask(&mut self, ctx: &egui::Context, purpose: Purpose) {
        let name = self.session.loaded.as_ref().map_or("superform", |l| l.shape.name.as_str());
        let stem = Path::new(name).file_stem().map_or_else(|| "superform".into(), |s| s.to_string_lossy());
        let window = &self.session.window;
        let folder = if purpose.is_reading() { &window.open_folder } else { &window.save_folder };
        // It may have gone since.
        let folder = folder.as_deref().filter(|folder| folder.is_dir());
        self.interface.ask(ctx, purpose, &stem, folder);
    }

    /// Saves the pictures that have been taken.
    fn save_pictures(&mut self, ctx: &egui::Context) {
        while let Some(Saved { path, result, is_last }) = self.screenshots.save_next() {
            if is_last {
                self.finish(ctx, result.with_context(|| format!("Cannot write {}", path.display())));
                continue;
            }
            let action = match result {
                Ok(()) => Action::Say(
                    Message::new(Level::Note, format!("Wrote the screenshot to {}", path.display()))
                        .offer("Show in folder", Action::ShowInFolder(path)),
                ),
                Err(error) => Action::Tell {
                    what: "Cannot save the screenshot".to_owned(),
                    error: format!("{error:#}"),
                },
            };
            self.apply(ctx, action);
        }
    }

    fn finish(&mut self, ctx: &egui::Context, result: anyhow::Result<()>) {
        if let Some(outcome) = &self.outcome {
            // The receiver waits in `run`.
            let _ = outcome.send(result);
        }
        ctx.send_viewport_cmd(egui::ViewportCommand::Close);
    }

    /// Logs when the first picture was there.
    fn advance_start(&mut self) {
        if let Start::Drawn(begun) = self.start {
            tracing::debug!(after = ?begun.elapsed(), "the first frame was drawn");
            self.start = Start::Over;
        }
    }

    fn update_title(&mut self, ctx: &egui::Context) {
        let mark = if self.session.is_changed() { "• " } else { "" };
        let title = match self.session.title() {
            Some(name) => format!("{mark}{name} – Superform"),
            None => "Superform".to_owned(),
        };
        if title != self.title {
            ctx.send_viewport_cmd(egui::ViewportCommand::Title(title.clone()));
            self.title = title;
        }
    }
}

impl eframe::App for App {
    fn raw_input_hook(&mut self, _ctx: &egui::Context, input: &mut egui::RawInput) {
        // A pointer that happens to rest over the window is no part of its picture.
        if self.screenshots.is_pending() {
            input.events.retain(|event| !is_of_pointer(event));
        }
    }

    fn save(&mut self, storage: &mut dyn eframe::Storage) {
        if self.remembers {
            store(storage, PREFERENCES, &self.session.preferences());
            store(storage, SIZES, self.interface.sizes());
            if let Some(place) = &self.placing.kept {
                store(storage, PLACE, place);
            }
            storage.remove_string(OTHER_PLACE);
        }
    }

    fn persist_egui_memory(&self) -> bool {
        // It would bring back what belongs to another shape and another version.
        false
    }

    fn logic(&mut self, ctx: &egui::Context, _frame: &mut eframe::Frame) {
        let events: Vec<Event> = self.worker.try_events().collect();
        for event in events {
            self.absorb(ctx, event);
        }
        let effects = self.session.background();
        self.carry_out(ctx, effects);
        while let Ok(error) = self.gpu_errors.try_recv() {
            let what = "Cannot render the 3D view".to_owned();
            self.apply(ctx, Action::Tell { what, error });
        }
        for event in self.saving.news() {
            self.absorb_kept(ctx, event);
        }
        self.watch_closing(ctx);
        let records: Vec<_> = self.journal.iter().flat_map(Journal::records).collect();
        for record in records {
            let level = if record.is_error { Level::Error } else { Level::Warning };
            self.apply(ctx, Action::Say(Message::new(level, record.text)));
        }
        self.advance_start();
        self.save_pictures(ctx);
        if let Some(error) = self.screenshots.advance(ctx, &self.session) {
            self.finish(ctx, Err(error));
        }
        self.saving.keep(&self.session);
        self.placing.advance(ctx);
        self.update_title(ctx);
    }

    fn on_exit(&mut self) {
        self.close();
    }

    fn ui(&mut self, ui: &mut egui::Ui, frame: &mut eframe::Frame) {
        let ctx = ui.ctx().clone();
        if let Start::Since(begun) = self.start {
            self.start = Start::Drawn(begun);
            ctx.request_repaint();
        }
        tracing::trace!(seconds = frame.info().cpu_usage, "the frame before");
        let actions = self.interface.show(ui, &self.session);
        if !actions.is_empty() {
            // What was asked for is seen in the next frame.
            ctx.request_repaint();
        }
        for action in actions {
            self.apply(&ctx, action);
        }
    }
}

/// What was stored under this name; `None` if nothing was, or nothing that
/// can be read.
fn stored<T: serde::de::DeserializeOwned>(storage: &dyn eframe::Storage, name: &str) -> Option<T> {
    let text = storage.get_string(name)?;
    serde_json::from_str(&text)
        .inspect_err(|error| tracing::warn!("cannot read the stored {name}; using defaults: {error}"))
        .ok()
}

fn store<T: serde::Serialize>(storage: &mut dyn eframe::Storage, name: &str, value: &T) {
    match serde_json::to_string(value) {
        Ok(text) => storage.set_string(name, text),
        Err(error) => tracing::warn!("cannot store the {name}: {error}"),
    }
}

fn is_of_pointer(event: &egui::Event) -> bool {
    use egui::Event::{MouseMoved, MouseWheel, PointerButton, PointerMoved, Touch, Zoom};
    matches!(
        event,
        MouseMoved(_) | MouseWheel { .. } | PointerButton { .. } | PointerMoved(_) | Touch { .. } | Zoom(_)
    )
}
