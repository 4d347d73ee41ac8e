//! The journal of a running window: appended after every change, so that
//! nothing but the last change is lost, however the program ends.

use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, Write};
use std::path::Path;
use std::time::{Duration, Instant};

use super::container::write_header;
use super::folder::Claim;
use super::ledger::Ledger;
use super::writing::Writing;
use crate::session::workspace::Workspace;

/// A journal may hold so much that is not needed any more, besides as much as
/// is, before it is written anew.
const SLACK: u64 = 1 << 20;
/// At most so often is the system told to write through to the disk. What was
/// appended survives the end of the program at once, that of the system from
/// then on.
const SYNC_INTERVAL: Duration = Duration::from_secs(2);
const BUFFER: usize = 1 << 18;

/// A journal that belongs to this process.
#[derive(Debug)]
pub(super) struct Journal {
    claim: Claim,
    /// `None` until something was kept, and where it could not be written on.
    open: Option<Open>,
}

#[derive(Debug)]
struct Open {
    file: File,
    ledger: Ledger,
    /// Length of what is whole.
    bytes: u64,
    synced: Instant,
}

impl Journal {
    pub(super) fn new(folder: &Path) -> io::Result<Self> {
        Ok(Self { claim: Claim::new(folder)?, open: None })
    }

    /// Appends what of the session is new. Where that fails, the journal holds
    /// what it held before, and the next call writes it anew.
    pub(super) fn keep(&mut self, workspace: &Workspace) -> io::Result<()> {
        let Some(mut open) = self.open.take() else {
            self.open = Some(self.rewritten(workspace)?);
            return Ok(());
        };
        match open.append(workspace) {
            Ok(()) => {}
            Err(error) => {
                // Best effort: a torn end is passed over on reading.
                let _ = open.file.set_len(open.bytes);
                return Err(error);
            }
        }
        let is_large = open.bytes > 2 * open.ledger.reachable + SLACK;
        self.open = Some(match is_large.then(|| self.rewritten(workspace)) {
            Some(Ok(smaller)) => smaller,
            Some(Err(error)) => {
                tracing::warn!("cannot compact the journal, it keeps growing: {error}");
                open
            }
            None => open,
        });
        Ok(())
    }

    /// Writes the journal anew, whole or not at all.
    fn rewritten(&self, workspace: &Workspace) -> io::Result<Open> {
        let path = self.claim.journal();
        let part = path.with_extension("part");
        let mut open = Open {
            file: OpenOptions::new().write(true).create(true).truncate(true).open(&part)?,
            ledger: Ledger::default(),
            bytes: 0,
            synced: Instant::now(),
        };
        let written = write_header(&mut open.file).and_then(|bytes| {
            open.bytes = bytes;
            open.append(workspace)?;
            fs::rename(&part, path)
        });
        match written {
            Ok(()) => Ok(open),
            Err(error) => {
                let _ = fs::remove_file(&part);
                Err(error)
            }
        }
    }

    /// Ends the journal, which goes.
    pub(super) fn remove(self) -> io::Result<()> {
        self.claim.remove()
    }

    /// Ends the journal, which is kept as a file, in place of what stood there.
    pub(super) fn move_to(self, path: &Path) -> io::Result<()> {
        if let Some(open) = &self.open {
            open.file.sync_data()?;
        }
        self.claim.move_to(path)
    }

    #[cfg(test)]
    pub(super) fn path(&self) -> &Path {
        self.claim.journal()
    }
}

impl Open {
    fn append(&mut self, workspace: &Workspace) -> io::Result<()> {
        let before = self.ledger.written;
        let mut out = BufWriter::with_capacity(BUFFER, &self.file);
        Writing { ledger: &mut self.ledger, out: &mut out }.whole(workspace)?;
        out.flush()?;
        drop(out);
        self.bytes += self.ledger.written - before;
        if self.synced.elapsed() > SYNC_INTERVAL {
            self.file.sync_data()?;
            self.synced = Instant::now();
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::inference::Params;
    use crate::session::Session;
    use crate::worker::SamplingOptions;

    #[test]
    fn a_journal_does_not_grow_for_ever_and_outlives_a_failed_append() {
        let place = tempfile::tempdir().unwrap();
        let mut journal = Journal::new(place.path()).unwrap();
        let mut session = Session::new(Params::default(), SamplingOptions::default());
        let mut longest = 0;
        let mut was_shortened = false;
        for seed in 0..10_000 {
            session.params.seed = seed;
            session.hidden = (0..100).map(|i| i * 7 + seed as u32).collect();
            journal.keep(&session.workspace()).unwrap();
            let length = fs::metadata(journal.path()).unwrap().len();
            was_shortened |= length < longest;
            longest = longest.max(length);
            if was_shortened {
                break;
            }
        }
        assert!(was_shortened && longest < 2 * SLACK, "it has {longest} bytes");
        let kept = || super::super::open(journal.path()).unwrap().workspace.document;
        assert_eq!(kept(), session.document());
        // Written on through a file that can only be read: as if the disk were full.
        let before = fs::read(journal.path()).unwrap();
        let path = journal.path().to_owned();
        if let Some(open) = &mut journal.open {
            open.file = File::open(&path).unwrap();
        }
        session.params.seed = 77;
        assert!(journal.keep(&session.workspace()).is_err());
        assert_eq!(fs::read(&path).unwrap(), before, "what was kept is still there");
        journal.keep(&session.workspace()).unwrap();
        assert_eq!(super::super::open(&path).unwrap().workspace.document, session.document());
    }
}
