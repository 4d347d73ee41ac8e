//! The folder of the journals, one a running window, and who owns which.
//!
//! A journal belongs to the process that holds the lock on the file beside it.
//! The lock goes with the process, however it ends, so that a journal whose
//! lock is free was left behind. A second lock on the whole folder guards the
//! moments in which journals are made or looked for.

use std::fs::{self, File, OpenOptions, TryLockError};
use std::io;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

const JOURNAL: &str = "journal";
const LOCK: &str = "lock";
const GUARD: &str = "folder.lock";
const LAST: &str = "last.superform";

/// Where this user's journals are kept: `$XDG_STATE_HOME/superform` (by default
/// `~/.local/state/superform`), `~/Library/Application Support/Superform` on
/// macOS, `%LOCALAPPDATA%\Superform` on Windows; `None` where there is no home.
pub fn user_folder() -> Option<PathBuf> {
    let absolute = |path: PathBuf| path.is_absolute().then_some(path);
    let home = || std::env::home_dir().and_then(absolute);
    if cfg!(windows) {
        let data = std::env::var_os("LOCALAPPDATA").map(PathBuf::from).and_then(absolute);
        return data.map(|folder| folder.join("Superform"));
    }
    if cfg!(target_os = "macos") {
        return home().map(|home| home.join("Library/Application Support/Superform"));
    }
    // Paths that are not absolute are to be ignored, says the standard.
    let state = std::env::var_os("XDG_STATE_HOME").map(PathBuf::from).and_then(absolute);
    state.or_else(|| home().map(|home| home.join(".local/state"))).map(|folder| folder.join("superform"))
}

/// The session that was closed last without being saved.
pub(super) fn last_session(folder: &Path) -> PathBuf {
    folder.join(LAST)
}

/// A journal that belongs to this process.
#[derive(Debug)]
pub(super) struct Claim {
    journal: PathBuf,
    lock: PathBuf,
    /// Locked while it is open.
    _held: File,
}

impl Claim {
    /// Claims a name that no journal has; the folder is made if it isn't there.
    pub(super) fn new(folder: &Path) -> io::Result<Self> {
        let _guard = guard(folder)?;
        let pid = std::process::id();
        for number in 1.. {
            let journal = folder.join(format!("{pid}-{number}.{JOURNAL}"));
            let lock = journal.with_extension(LOCK);
            if journal.exists() {
                continue;
            }
            let held = match OpenOptions::new().write(true).create_new(true).open(&lock) {
                Ok(file) => file,
                Err(error) if error.kind() == io::ErrorKind::AlreadyExists => continue,
                Err(error) => return Err(error),
            };
            held.try_lock()?;
            return Ok(Self { journal, lock, _held: held });
        }
        Err(io::ErrorKind::AlreadyExists.into())
    }

    /// Claims all journals that were left behind, the newest first.
    pub(super) fn orphans(folder: &Path) -> io::Result<Vec<Self>> {
        if !folder.is_dir() {
            return Ok(Vec::new());
        }
        let _guard = guard(folder)?;
        let mut found = Vec::new();
        for entry in fs::read_dir(folder)? {
            let lock = entry?.path();
            if lock.extension().is_none_or(|e| e != LOCK) || lock.file_name().is_some_and(|n| n == GUARD) {
                continue;
            }
            let held = OpenOptions::new().write(true).open(&lock)?;
            match held.try_lock() {
                Ok(()) => {}
                Err(TryLockError::WouldBlock) => continue,
                Err(TryLockError::Error(error)) => return Err(error),
            }
            let journal = lock.with_extension(JOURNAL);
            if journal.exists() {
                found.push(Self { journal, lock, _held: held });
            } else {
                // Its owner ended before there was anything to keep.
                fs::remove_file(&lock)?;
            }
        }
        found.sort_by_cached_key(|claim| std::cmp::Reverse(claim.kept_at()));
        Ok(found)
    }

    pub(super) fn journal(&self) -> &Path {
        &self.journal
    }

    /// When something was last written.
    pub(super) fn kept_at(&self) -> SystemTime {
        let about = fs::metadata(&self.journal).and_then(|about| about.modified());
        about.unwrap_or(SystemTime::UNIX_EPOCH)
    }

    /// Removes the journal, if there is one.
    pub(super) fn remove(self) -> io::Result<()> {
        match fs::remove_file(&self.journal) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(error),
            _ => {}
        }
        fs::remove_file(&self.lock)
    }

    /// Gives the journal another name, in place of what stood there.
    pub(super) fn move_to(self, path: &Path) -> io::Result<()> {
        fs::rename(&self.journal, path)?;
        fs::remove_file(&self.lock)
    }
}

/// Keeps other processes from making or looking for journals while it lives.
fn guard(folder: &Path) -> io::Result<File> {
    let mut builder = fs::DirBuilder::new();
    builder.recursive(true);
    // Nobody else's business.
    #[cfg(unix)]
    std::os::unix::fs::DirBuilderExt::mode(&mut builder, 0o700);
    builder.create(folder)?;
    let file = OpenOptions::new().write(true).create(true).truncate(false).open(folder.join(GUARD))?;
    file.lock()?;
    Ok(file)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_journal_is_an_orphan_only_without_its_owner() {
        let place = tempfile::tempdir().unwrap();
        let folder = place.path().join("deep/state");
        assert!(Claim::orphans(&folder).unwrap().is_empty());
        let [first, second, empty] = [0; 3].map(|_| Claim::new(&folder).unwrap());
        fs::write(first.journal(), "1").unwrap();
        fs::write(second.journal(), "2").unwrap();
        assert!(Claim::orphans(&folder).unwrap().is_empty(), "living owners");
        let left = first.journal().to_owned();
        drop((first, empty));
        let orphans = Claim::orphans(&folder).unwrap();
        assert_eq!(orphans.iter().map(Claim::journal).collect::<Vec<_>>(), [&left]);
        assert!(Claim::orphans(&folder).unwrap().is_empty(), "the orphan has an owner now");
        // Given back, it is found again; removed, it is not.
        drop(orphans);
        for orphan in Claim::orphans(&folder).unwrap() {
            orphan.remove().unwrap();
        }
        assert!(!left.exists() && Claim::orphans(&folder).unwrap().is_empty());
        second.move_to(&last_session(&folder)).unwrap();
        assert_eq!(fs::read_to_string(last_session(&folder)).unwrap(), "2");
        let left: Vec<_> = fs::read_dir(&folder).unwrap().map(|e| e.unwrap().file_name()).collect();
        assert_eq!(left.len(), 2, "{left:?}");
    }
}
