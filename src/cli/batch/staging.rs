//! Staging of a job's files: they are created in a hidden folder, synced to disk, and moved to
//! their place together, so that an incomplete job never looks finished.
//!
//! Each batch has a staging folder in `.superform` in the output, named after its table, and holds
//! a lock next to it for as long as it runs. The lock keeps other batches from removing its files
//! or writing the same table. The system releases it when the process ends, for whatever reason.

use std::fs::{self, File, OpenOptions, TryLockError};
use std::io;
use std::path::{Path, PathBuf};
use std::time::Duration;

use anyhow::{Context, bail};
use serde::{Deserialize, Serialize};

use super::fingerprint::pieces;
use super::rows::Row;
use crate::cli::output::say;
use crate::inference::Cancel;
use crate::io as files;

/// The record of a finished job, in its folder.
pub(super) const RECORD_FILE: &str = "job.json";

/// Staging folder in the output, removed when the batch is done.
const HIDDEN_FOLDER: &str = ".superform";

/// Polling interval of a batch that waits for another.
const LOOK_AGAIN: Duration = Duration::from_millis(100);

const FORMAT: &str = "superform-job";
const VERSION: u32 = 1;

/// The record of a finished job, stored next to its files.
#[derive(Debug, Serialize, Deserialize)]
struct Record {
    format: String,
    version: u32,
    program: String,
    /// Fingerprint of everything the result depends on.
    fingerprint: String,
    files: Vec<FileEntry>,
    row: Row,
}

/// A file as it was written.
#[derive(Debug, PartialEq, Eq, Serialize, Deserialize)]
struct FileEntry {
    name: String,
    bytes: u64,
    crc32: u32,
}

impl FileEntry {
    /// Of a file of that name (with `/`) below a folder.
    fn of(folder: &Path, name: &str) -> io::Result<Self> {
        let (path, name) = (folder.join(name), name.to_owned());
        let mut hash = crc32fast::Hasher::new();
        let bytes = pieces(&path, |piece| hash.update(piece))?;
        Ok(Self { name, bytes, crc32: hash.finalize() })
    }
}

impl Record {
    fn read(folder: &Path) -> Option<Self> {
        let record: Self = serde_json::from_slice(&fs::read(folder.join(RECORD_FILE)).ok()?).ok()?;
        (record.format == FORMAT && record.version == VERSION).then_some(record)
    }

    /// Whether all files exist unchanged.
    fn is_whole(&self, folder: &Path) -> bool {
        !self.files.is_empty()
            && self.files.iter().all(|entry| {
                // A record is a file that anybody can write.
                is_below(&entry.name)
                    && fs::metadata(folder.join(&entry.name)).is_ok_and(|about| about.len() == entry.bytes)
                    && FileEntry::of(folder, &entry.name).is_ok_and(|found| found == *entry)
            })
    }
}

/// The name of a file below a folder, with `/`.
fn name_below(folder: &Path, file: &Path) -> String {
    let parts = file.strip_prefix(folder).unwrap_or(file).iter();
    parts.map(|part| part.to_string_lossy()).collect::<Vec<_>>().join("/")
}

/// Whether a name stays inside its folder.
fn is_below(name: &str) -> bool {
    let path = Path::new(name);
    !name.contains('\\') && path.components().all(|part| matches!(part, std::path::Component::Normal(_)))
}

/// The row of a job whose files are complete and have this fingerprint.
pub(super) fn finished(folder: &Path) -> Option<(Row, String)> {
    let record = Record::read(folder).filter(|record| record.is_whole(folder))?;
    Some((record.row, record.fingerprint))
}

/// The files of a job in a folder, including its record.
pub(super) fn made_before(folder: &Path) -> impl Iterator<Item = PathBuf> {
    let files = Record::read(folder).map(|record| record.files).unwrap_or_default();
    let names = files.into_iter().map(|entry| entry.name).filter(|name| is_below(name));
    names.chain([RECORD_FILE.to_owned()]).map(|name| folder.join(name))
}

/// A batch's staging folder.
#[derive(Debug)]
pub(super) struct StagingFolder {
    output: PathBuf,
    /// Where files are created.
    folder: PathBuf,
    lock: PathBuf,
    /// Held lock; `None` if the file system does not support locks.
    held: Option<File>,
}

impl StagingFolder {
    /// Takes the staging folder of a table and removes leftovers of killed
    /// batches. Waits, with a message, while another process uses it; `None` if
    /// cancelled.
    /// have left behind. If another process works at it, says so and waits;
    /// `None` if that was cancelled.
    pub(super) fn take(output: &Path, table: &str, cancel: &Cancel) -> anyhow::Result<Option<Self>> {
        let wait =
            || say(&format!("waiting for another run that is writing {table}.csv in {}", output.display()));
        Self::take_or_wait(output, table, cancel, wait)
    }

    fn take_or_wait(
        output: &Path,
        table: &str,
        cancel: &Cancel,
        wait: impl FnOnce(),
    ) -> anyhow::Result<Option<Self>> {
        let about = || format!("cannot use the folder {}", output.display());
        let hidden = output.join(HIDDEN_FOLDER);
        let lock = hidden.join(format!("{table}.lock"));
        let mut wait = Some(wait);
        let held = loop {
            fs::create_dir_all(&hidden).with_context(about)?;
            match locked(&lock, true) {
                Ok(Locking::Held(file)) => break Some(file),
                Ok(Locking::Unknown) => break None,
                Ok(Locking::Taken) => {
                    if let Some(wait) = wait.take() {
                        wait();
                    }
                    std::thread::sleep(LOOK_AGAIN);
                }
                // Whoever had it has just put it away.
                Ok(Locking::Gone) => {}
                Err(e) if e.kind() == io::ErrorKind::NotFound => {}
                Err(e) => return Err(e).with_context(about),
            }
            if cancel.is_requested() {
                return Ok(None);
            }
        };
        let folder = match held {
            Some(_) => hidden.join(table),
            // Then nobody can tell whether another works there.
            None => hidden.join(format!("{table}.{}", std::process::id())),
        };
        let staging = Self { output: output.to_owned(), folder, lock, held };
        staging.clear().with_context(about)?;
        fs::create_dir_all(&staging.folder).with_context(about)?;
        sweep_up(&hidden, &staging.lock);
        Ok(Some(staging))
    }

    /// Removes everything in the own staging folder.
    fn clear(&self) -> io::Result<()> {
        match fs::remove_dir_all(&self.folder) {
            Err(e) if e.kind() != io::ErrorKind::NotFound => Err(e),
            _ => Ok(()),
        }
    }

    /// Where files are created, on the same file system as their targets.
    pub(super) fn folder(&self) -> &Path {
        &self.folder
    }

    /// An empty folder for a job's files.
    pub(super) fn place(&self, number: usize) -> io::Result<PathBuf> {
        let folder = self.folder.join(number.to_string());
        fs::create_dir_all(&folder)?;
        Ok(folder)
    }

    /// The folder of a finished job.
    pub(super) fn target(&self, name: &str) -> PathBuf {
        self.output.join(name)
    }

    /// Moves the files of a job from where they were made to the folder of its
    /// name, with the record that makes it finished. A folder that is there
    /// Moves the files of a job to its folder, with the record that marks it as
    /// finished. Other files in an existing folder are kept.
    pub(super) fn publish(
        &self,
        made: &Path,
        written: &[PathBuf],
        fingerprint: String,
        row: &Row,
    ) -> anyhow::Result<()> {
        let target = self.target(&row.name);
        if target.exists() && !target.is_dir() {
            bail!(
                "the file {} is in the way of the results; move it or choose another folder",
                target.display()
            );
        }
        let record = Record {
            format: FORMAT.to_owned(),
            version: VERSION,
            program: concat!("superform ", env!("CARGO_PKG_VERSION")).to_owned(),
            fingerprint,
            files: written
                .iter()
                .map(|path| FileEntry::of(made, &name_below(made, path)))
                .collect::<Result<_, _>>()?,
            row: row.clone(),
        };
        files::write_whole(&made.join(RECORD_FILE), &serde_json::to_vec_pretty(&record)?)?;
        sync(made);
        self.moved(made, &target, &record)
            .with_context(|| format!("cannot move the results to {}", target.display()))
    }

    fn moved(&self, made: &Path, target: &Path, record: &Record) -> io::Result<()> {
        let parent = target.parent().unwrap_or(&self.output);
        fs::create_dir_all(parent)?;
        if !target.exists() && fs::rename(made, target).is_ok() {
            self.sync_up_to_output(parent);
            return Ok(());
        }
        // From here on it is unfinished until the record is there again.
        fs::create_dir_all(target)?;
        let before = Record::read(target);
        match fs::remove_file(target.join(RECORD_FILE)) {
            Err(e) if e.kind() != io::ErrorKind::NotFound => return Err(e),
            _ => sync(target),
        }
        for old in before.iter().flat_map(|record| &record.files) {
            // Only what was made there.
            if !record.files.iter().any(|new| new.name == old.name) && is_below(&old.name) {
                let _ = fs::remove_file(target.join(&old.name));
            }
        }
        for name in record.files.iter().map(|entry| entry.name.as_str()) {
            if let Some(folder) = target.join(name).parent() {
                fs::create_dir_all(folder)?;
            }
            files::move_whole(&made.join(name), &target.join(name)).map_err(io::Error::other)?;
        }
        sync(target);
        files::move_whole(&made.join(RECORD_FILE), &target.join(RECORD_FILE)).map_err(io::Error::other)?;
        sync(target);
        self.sync_up_to_output(parent);
        fs::remove_dir_all(made)
    }

    /// Syncs new folder names to disk.
    fn sync_up_to_output(&self, from: &Path) {
        for folder in from.ancestors() {
            sync(folder);
            if folder == self.output {
                break;
            }
        }
    }
}

impl Drop for StagingFolder {
    fn drop(&mut self) {
        if let Err(e) = self.clear() {
            tracing::warn!("cannot remove {}: {e}", self.folder.display());
        }
        if self.held.is_some() {
            put_away(&self.lock);
        }
    }
}

/// Releases and removes the lock, and the hidden folder if no other batch uses it.
fn put_away(lock: &Path) {
    // Elsewhere nobody could tell an old lock from a new one of the same name.
    if cfg!(unix) {
        let _ = fs::remove_file(lock);
        if let Some(hidden) = lock.parent() {
            let _ = fs::remove_dir(hidden);
        }
    }
}

/// Removes staging folders whose owners have ended.
fn sweep_up(hidden: &Path, own: &Path) {
    for path in fs::read_dir(hidden).into_iter().flatten().flatten().map(|entry| entry.path()) {
        if path == own || path.extension().is_none_or(|e| e != "lock") {
            continue;
        }
        if let Ok(Locking::Held(_held)) = locked(&path, false) {
            let _ = fs::remove_dir_all(path.with_extension(""));
            put_away(&path);
        }
    }
}

#[derive(Debug)]
enum Locking {
    Held(File),
    /// Held by another process.
    Taken,
    /// Removed while it was being acquired.
    Gone,
    /// The file system does not support locks.
    Unknown,
}

fn locked(path: &Path, make: bool) -> io::Result<Locking> {
    let file = OpenOptions::new().read(true).write(true).create(make).truncate(false).open(path)?;
    match file.try_lock() {
        Ok(()) if is_at(&file, path) => Ok(Locking::Held(file)),
        Ok(()) => Ok(Locking::Gone),
        Err(TryLockError::WouldBlock) => Ok(Locking::Taken),
        Err(TryLockError::Error(e)) => {
            tracing::debug!("cannot lock {}: {e}", path.display());
            Ok(Locking::Unknown)
        }
    }
}

/// Whether an open file is still the one of that name.
#[cfg(unix)]
fn is_at(file: &File, path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt as _;
    match (file.metadata(), fs::metadata(path)) {
        (Ok(open), Ok(there)) => (open.dev(), open.ino()) == (there.dev(), there.ino()),
        _ => false,
    }
}

/// Nobody removes locks here.
#[cfg(not(unix))]
fn is_at(_: &File, _: &Path) -> bool {
    true
}

/// Syncs the names in a folder, so that they survive a power failure, if the system supports it.
fn sync(folder: &Path) {
    #[cfg(unix)]
    if let Err(e) = File::open(folder).and_then(|folder| folder.sync_all()) {
        tracing::debug!("cannot sync {}: {e}", folder.display());
    }
    #[cfg(not(unix))]
    let _ = folder;
}

#[cfg(test)]
mod tests {
    use super::super::rows::tests::job;
    use super::*;

    fn staging(output: &Path, table: &str) -> StagingFolder {
        StagingFolder::take_or_wait(output, table, &Cancel::default(), || panic!("somebody sits there"))
            .unwrap()
            .unwrap()
    }

    /// Publishes a job that consists of some files.
    fn publish(staging: &StagingFolder, name: &str, fingerprint: &str, content: &[(&str, &str)]) -> Row {
        let place = staging.place(1).unwrap();
        let written: Vec<PathBuf> = content
            .iter()
            .map(|(name, text)| {
                fs::write(place.join(name), text).unwrap();
                place.join(name)
            })
            .collect();
        let row = Row::cancelled(&job(1, name));
        staging.publish(&place, &written, fingerprint.to_owned(), &row).unwrap();
        assert!(!place.exists());
        row
    }

    #[test]
    fn a_job_is_finished_once_its_files_are_whole() {
        let output = tempfile::tempdir().unwrap();
        let target = output.path().join("a/b");
        let staging = staging(output.path(), "results");
        assert!(finished(&target).is_none());
        let row = publish(&staging, "a/b", "f1", &[("x.txt", "one"), ("y.txt", "two")]);
        assert_eq!(finished(&target), Some((row, "f1".to_owned())));
        // Cut, changed, missing.
        for spoil in [
            |path: &Path| fs::write(path, "on").unwrap(),
            |path: &Path| fs::write(path, "eno").unwrap(),
            |path: &Path| fs::remove_file(path).unwrap(),
        ] {
            spoil(&target.join("x.txt"));
            assert!(finished(&target).is_none());
            publish(&staging, "a/b", "f2", &[("x.txt", "one"), ("y.txt", "two")]);
            assert!(finished(&target).is_some());
        }
        let record = fs::read(target.join(RECORD_FILE)).unwrap();
        fs::write(target.join(RECORD_FILE), &record[..record.len() / 2]).unwrap();
        assert!(finished(&target).is_none());
    }

    #[test]
    fn what_is_not_ours_stays_and_what_was_ours_goes() {
        let output = tempfile::tempdir().unwrap();
        let target = output.path().join("a");
        fs::create_dir(&target).unwrap();
        fs::write(target.join("notes.txt"), "mine").unwrap();
        let staging = staging(output.path(), "results");
        publish(&staging, "a", "f1", &[("x.txt", "one"), ("old.txt", "two")]);
        publish(&staging, "a", "f2", &[("x.txt", "three")]);
        assert_eq!(fs::read_to_string(target.join("x.txt")).unwrap(), "three");
        assert!(!target.join("old.txt").exists());
        assert_eq!(fs::read_to_string(target.join("notes.txt")).unwrap(), "mine");
        drop(staging);
        assert_eq!(cfg!(unix), !output.path().join(HIDDEN_FOLDER).exists());
    }

    #[test]
    fn leftovers_of_the_dead_go_and_those_of_the_living_stay() {
        let output = tempfile::tempdir().unwrap();
        let hidden = output.path().join(HIDDEN_FOLDER);
        let living = staging(output.path(), "results.0-of-2");
        let at_work = living.place(7).unwrap();
        // What a process leaves that was killed: its lock is free.
        for table in ["results.1-of-2", "results"] {
            fs::create_dir_all(hidden.join(table).join("3")).unwrap();
            fs::write(hidden.join(table).join("3/segmented.ply"), "half").unwrap();
            fs::write(hidden.join(format!("{table}.lock")), "").unwrap();
        }
        let next = staging(output.path(), "results.1-of-2");
        assert!(at_work.exists());
        assert!(!hidden.join("results").exists());
        assert_eq!(fs::read_dir(&next.folder).unwrap().count(), 0);
    }

    #[test]
    fn a_second_batch_of_the_same_table_waits() {
        let output = tempfile::tempdir().unwrap();
        let first = staging(output.path(), "results");
        let cancel = Cancel::default();
        let stop = cancel.clone();
        let second =
            StagingFolder::take_or_wait(output.path(), "results", &cancel, move || stop.request()).unwrap();
        assert!(second.is_none());
        // The first ends as soon as the second has begun to wait.
        let mut first = Some(first);
        let second =
            StagingFolder::take_or_wait(output.path(), "results", &Cancel::default(), || first = None)
                .unwrap();
        assert!(second.is_some());
    }
}
