//! The thread that keeps the session: it writes the journal, session files,
//! and reads them, so that the window never waits for a disk.

use std::path::PathBuf;
use std::sync::mpsc::{Receiver, sync_channel};
use std::thread::JoinHandle;
use std::time::Duration;

use super::folder::{Claim, last_session};
use super::journal::Journal;
use super::reading::{self, Opened};
use super::saving::save;
use crate::io::caught;
use crate::io::cause;
use crate::session::saving::Found;
use crate::session::workspace::Workspace;
use crate::worker::Outbox;

/// Orders and events on their way between the threads.
const ORDERS: usize = 64;
const EVENTS: usize = 64;

/// Where an opened session came from.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Origin {
    File(PathBuf),
    /// What was left behind, by the id of its [`Found`].
    Recovered(u64),
    /// What was closed last without being saved.
    Last,
}

/// What the autosave tells.
#[derive(Debug)]
pub enum Event {
    /// What was left behind, the newest first; told at the start.
    Found(Vec<Found>),
    /// Whether there is a session that was closed without being saved.
    HasLast(bool),
    /// So many sessions were handed to [`Autosave::keep`] until the one that is
    /// in the journal now.
    Kept(u64),
    /// Nothing can be kept for now; told once until it can again.
    NotKept(String),
    Saved {
        path: PathBuf,
        workspace: Box<Workspace>,
    },
    Opened {
        origin: Origin,
        opened: Box<Opened>,
    },
    /// What was asked for can't be had; all is as it was.
    Failed {
        what: String,
        error: String,
    },
}

#[derive(Debug)]
enum Request {
    Keep(u64, Box<Workspace>),
    Save(PathBuf, Box<Workspace>),
    /// Open it; then set the journal aside as the last session, where the
    /// present one is given.
    Open(Origin, Option<Box<Workspace>>),
    Discard(u64),
    /// The end: keep the session as the last one, or remove the journal.
    Close(Option<Box<Workspace>>),
}

/// The owner's end of the thread.
#[derive(Debug)]
pub struct Autosave {
    orders: Outbox<Request>,
    events: Receiver<Event>,
    count: u64,
    thread: Option<JoinHandle<()>>,
}

impl Autosave {
    /// Starts the thread, which looks for what was left behind in `folder`. It
    /// calls `wake` whenever there is an event.
    ///
    /// # Errors
    /// If the operating system gives no thread.
    pub fn spawn(folder: Option<PathBuf>, wake: impl Fn() + Send + 'static) -> std::io::Result<Self> {
        let (orders, received) = sync_channel(ORDERS);
        let (sender, events) = sync_channel(EVENTS);
        let tell = move |event| {
            // Fails only when the owner is gone, who then doesn't want to know.
            let _ = sender.send(event);
            wake();
        };
        let thread = std::thread::Builder::new().name("keeper".to_owned()).spawn(move || {
            let mut desk =
                AutosaveThread { folder, journal: None, orphans: Vec::new(), is_failing: false, tell };
            desk.guarded(AutosaveThread::look_around);
            while let Ok(order) = received.recv() {
                let orders: Vec<Request> = std::iter::once(order).chain(received.try_iter()).collect();
                desk.obey_all(orders);
            }
        })?;
        Ok(Self { orders: Outbox::new(orders), events, count: 0, thread: Some(thread) })
    }

    /// Hands the session over to be kept in the journal; never blocks. Where
    /// the disk lags behind, the latest is kept. Returns the number by which
    /// [`Event::Kept`] tells of it.
    pub fn keep(&mut self, workspace: Workspace) -> u64 {
        self.count += 1;
        self.order(Request::Keep(self.count, Box::new(workspace)));
        self.count
    }

    /// Writes a session file; answered by [`Event::Saved`].
    pub fn save(&mut self, path: PathBuf, workspace: Workspace) {
        self.order(Request::Save(path, Box::new(workspace)));
    }

    /// Reads a session; answered by [`Event::Opened`]. The present one, where
    /// it holds unsaved work, becomes the last session as soon as that worked.
    pub fn open(&mut self, origin: Origin, unsaved: Option<Workspace>) {
        self.order(Request::Open(origin, unsaved.map(Box::new)));
    }

    /// Removes what was left behind.
    pub fn discard(&mut self, id: u64) {
        self.order(Request::Discard(id));
    }

    /// What was told since the last call; never blocks. Whoever owns a autosave
    /// calls this whenever `wake` was called.
    pub fn try_events(&mut self) -> impl Iterator<Item = Event> + '_ {
        self.flush();
        self.events.try_iter()
    }

    /// Waits for the next event, at most `timeout`; `None` if there was none.
    pub fn next_event(&mut self, timeout: Duration) -> Option<Event> {
        self.flush();
        self.events.recv_timeout(timeout).ok()
    }

    /// Ends the thread once all is on the disk: unsaved work is kept as the
    /// last session.
    pub fn close(mut self, unsaved: Option<Workspace>) {
        self.orders.waiting().retain(|order| !matches!(order, Request::Keep(..)));
        self.orders.push(Request::Close(unsaved.map(Box::new)));
    }

    fn order(&mut self, order: Request) {
        self.orders.push(order);
        self.flush();
    }

    fn flush(&mut self) {
        if !self.orders.flush() {
            tracing::error!("the recovery thread has ended; the session is no longer journalled");
        }
    }
}

impl Drop for Autosave {
    /// Waits until what was handed over is on the disk.
    fn drop(&mut self) {
        while self.orders.flush() && !self.orders.waiting().is_empty() {
            // A autosave that waits for room among the events would wait for ever.
            let _ = self.events.recv_timeout(Duration::from_millis(1));
        }
        self.orders.close();
        let (_, nobody) = sync_channel(1);
        self.events = nobody;
        if let Some(thread) = self.thread.take()
            && thread.join().is_err()
        {
            tracing::error!("the recovery thread panicked");
        }
    }
}

/// The thread's own.
struct AutosaveThread<F> {
    /// `None` where there is no place for journals.
    folder: Option<PathBuf>,
    journal: Option<Journal>,
    /// What was left behind; the locks are held as long as they are here.
    orphans: Vec<(u64, Claim)>,
    is_failing: bool,
    tell: F,
}

impl<F: Fn(Event)> AutosaveThread<F> {
    /// Tells what was left behind.
    fn look_around(&mut self) {
        let Some(folder) = &self.folder else { return };
        let has_last = last_session(folder).exists();
        let orphans = Claim::orphans(folder).unwrap_or_else(|error| {
            tracing::warn!("cannot look for sessions in {}: {error}", folder.display());
            Vec::new()
        });
        let mut found = Vec::new();
        for (id, claim) in (1..).zip(orphans) {
            match reading::summary(claim.journal()) {
                Ok(Some(summary)) => {
                    found.push(Found { id, summary, kept_at: claim.kept_at() });
                    self.orphans.push((id, claim));
                }
                Ok(None) => {
                    // Its owner ended before there was anything to keep.
                    if let Err(error) = claim.remove() {
                        tracing::warn!("cannot remove an empty journal: {error}");
                    }
                }
                // A newer program may be able to.
                Err(error) => tracing::warn!("cannot read a session left for recovery: {error}"),
            }
        }
        if has_last {
            (self.tell)(Event::HasLast(true));
        }
        if !found.is_empty() {
            (self.tell)(Event::Found(found));
        }
    }

    /// Of the sessions to keep the latest is enough.
    fn obey_all(&mut self, orders: Vec<Request>) {
        let latest = orders.iter().rposition(|order| matches!(order, Request::Keep(..)));
        for (at, order) in orders.into_iter().enumerate() {
            if !matches!(order, Request::Keep(..)) || Some(at) == latest {
                self.guarded(|desk| desk.obey(order));
            }
        }
    }

    /// Goes on after a fault, which is told: whoever keeps work doesn't end.
    fn guarded(&mut self, work: impl FnOnce(&mut Self)) {
        if let Err(error) = caught(|| work(self)) {
            let what = "The thread that saves sessions stopped after an internal error".to_owned();
            let error = format!("{error}; save the session under another name and please report this");
            (self.tell)(Event::Failed { what, error });
        }
    }

    fn obey(&mut self, order: Request) {
        match order {
            Request::Keep(number, workspace) => {
                if self.keep(&workspace) {
                    (self.tell)(Event::Kept(number));
                }
            }
            Request::Save(path, workspace) => match save(&path, &workspace) {
                Ok(()) => (self.tell)(Event::Saved { path, workspace }),
                Err(error) => self.fail("Cannot save the session", &error),
            },
            Request::Open(origin, unsaved) => self.open(origin, unsaved.as_deref()),
            Request::Discard(id) => {
                if let Some(claim) = self.take_orphan(id)
                    && let Err(error) = claim.remove()
                {
                    self.fail("Cannot discard the session", &error);
                }
            }
            Request::Close(unsaved) => self.set_aside(unsaved.as_deref()),
        }
    }

    fn fail(&self, what: &str, error: &dyn std::error::Error) {
        (self.tell)(Event::Failed { what: what.to_owned(), error: error.to_string() });
    }

    /// Keeps the session in the journal; whether it is there.
    fn keep(&mut self, workspace: &Workspace) -> bool {
        let Some(folder) = &self.folder else { return false };
        let kept = match &mut self.journal {
            Some(journal) => journal.keep(workspace),
            none => Journal::new(folder).and_then(|journal| none.insert(journal).keep(workspace)),
        };
        match kept {
            Ok(()) => self.is_failing = false,
            Err(error) => {
                tracing::warn!("cannot journal the session: {error}");
                if !std::mem::replace(&mut self.is_failing, true) {
                    let (folder, why) = (folder.display(), cause(&error));
                    let text = format!("{folder}: {why}; fix this or save the session elsewhere");
                    (self.tell)(Event::NotKept(text));
                }
            }
        }
        !self.is_failing
    }

    fn open(&mut self, origin: Origin, unsaved: Option<&Workspace>) {
        let what = match &origin {
            Origin::File(path) => format!("Cannot open {}", path.display()),
            Origin::Recovered(_) => "Cannot recover the session".to_owned(),
            Origin::Last => "Cannot open the last session".to_owned(),
        };
        let Some(path) = self.path_of(&origin) else { return };
        let opened = match reading::open(&path) {
            Ok(opened) => opened,
            Err(error) => return self.fail(&what, &error),
        };
        self.set_aside(unsaved);
        // What is in no file of its own is kept at once, as what it came from goes.
        if !matches!(origin, Origin::File(_))
            && self.keep(&opened.workspace)
            && let Origin::Recovered(id) = origin
            && let Some(claim) = self.take_orphan(id)
            && let Err(error) = claim.remove()
        {
            tracing::warn!("cannot remove a recovered journal: {error}");
        }
        (self.tell)(Event::Opened { origin, opened: Box::new(opened) });
    }

    fn path_of(&self, origin: &Origin) -> Option<PathBuf> {
        match origin {
            Origin::File(path) => Some(path.clone()),
            Origin::Recovered(id) => {
                let orphan = self.orphans.iter().find(|(found, _)| found == id);
                orphan.map(|(_, claim)| claim.journal().to_owned())
            }
            Origin::Last => self.folder.as_deref().map(last_session),
        }
    }

    fn take_orphan(&mut self, id: u64) -> Option<Claim> {
        let index = self.orphans.iter().position(|(found, _)| *found == id)?;
        Some(self.orphans.remove(index).1)
    }

    /// Ends the journal: as the last session, where there is unsaved work.
    fn set_aside(&mut self, unsaved: Option<&Workspace>) {
        let is_kept = unsaved.is_some_and(|workspace| self.keep(workspace));
        let Some(journal) = self.journal.take() else { return };
        let ended = match (&self.folder, is_kept) {
            (Some(folder), true) => {
                let moved = journal.move_to(&last_session(folder));
                (self.tell)(Event::HasLast(moved.is_ok()));
                moved
            }
            // What could not be kept is found at the next start as it was kept last.
            _ if unsaved.is_some() => Ok(()),
            _ => journal.remove(),
        };
        if let Err(error) = ended {
            tracing::warn!("cannot set the journal aside: {error}");
        }
    }
}
