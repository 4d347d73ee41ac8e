//! Writes one or several files completely or not at all.

use std::fs::{self, File};
use std::io::{self, BufWriter, Seek, Write};
#[cfg(unix)]
use std::os::unix::fs::PermissionsExt as _;
use std::path::{Path, PathBuf};

use tempfile::{NamedTempFile, TempPath};

use super::place::{Place, folder_of};
use crate::io::error::WriteError;

/// Writes some bytes as a file.
///
/// # Errors
/// Where the file can't be written. It is written whole or not at all.
pub fn write_whole(path: &Path, content: &[u8]) -> Result<(), WriteError> {
    Staged::with(path, |w| w.write_all(content))?.persist()
}

/// Writes a file piece by piece.
///
/// # Errors
/// Where the file can't be written. It is written whole or not at all.
pub fn write_streamed(
    path: &Path,
    content: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> Result<(), WriteError> {
    Staged::with(path, |w| content(w))?.persist()
}

/// Moves a file created elsewhere to its target, replacing what was there, as if
/// it had been written there.
///
/// # Errors
/// Where it can't have it. Then both are as they were.
pub fn move_whole(from: &Path, to: &Path) -> Result<(), WriteError> {
    let failed = |reason| WriteError::Io { path: to.to_owned(), reason };
    let place = Place::of(to).map_err(failed)?;
    if let Some(file) = place.file().filter(|file| !file.is_dir())
        && keep_mode(file, from).and_then(|()| fs::rename(from, file)).is_ok()
    {
        return Ok(());
    }
    let mut content = File::open(from).map_err(failed)?;
    Staged::with(to, |w| io::copy(&mut content, w).map(drop))?.persist()?;
    fs::remove_file(from).map_err(failed)
}

/// What a file is written through.
pub(super) type Sink<'a> = BufWriter<&'a mut File>;

/// The content of a file on its way. It is gone when it is dropped.
#[derive(Debug)]
pub(super) struct Staged {
    /// As a person named it.
    path: PathBuf,
    place: Place,
    /// Next to its target; elsewhere if it has none.
    content: NamedTempFile,
}

impl Staged {
    /// Begins the content of a file.
    pub(super) fn begin(path: &Path) -> Result<Self, WriteError> {
        if path.is_dir() {
            return Err(WriteError::IsAFolder { path: path.to_owned() });
        }
        let failed = |reason| WriteError::Io { path: path.to_owned(), reason };
        let place = Place::of(path).map_err(failed)?;
        let folder = match place.file() {
            Some(file) => folder_of(file).to_owned(),
            None => std::env::temp_dir(),
        };
        if !folder.is_dir() {
            return Err(WriteError::NoFolder { path: path.to_owned(), folder });
        }
        let mut builder = tempfile::Builder::new();
        builder.prefix(".superform-").suffix(".part");
        // Temporary files are private by default; results follow the umask.
        #[cfg(unix)]
        if place.file().is_some() {
            builder.permissions(fs::Permissions::from_mode(0o666));
        }
        // The kind alone: the full text names the temporary file, which means nothing to anybody.
        let content = builder.tempfile_in(folder).map_err(|e| failed(e.kind().into()))?;
        Ok(Self { path: path.to_owned(), place, content })
    }

    /// The whole content of a file.
    pub(super) fn with(
        path: &Path,
        content: impl FnOnce(&mut Sink<'_>) -> io::Result<()>,
    ) -> Result<Self, WriteError> {
        let mut staged = Self::begin(path)?;
        let failed = |reason: io::Error| match reason.kind() {
            io::ErrorKind::InvalidData => {
                WriteError::Content { path: path.to_owned(), problem: reason.to_string() }
            }
            _ => WriteError::Io { path: path.to_owned(), reason },
        };
        let mut writer = BufWriter::with_capacity(1 << 18, staged.content.as_file_mut());
        content(&mut writer).and_then(|()| writer.flush()).map_err(failed)?;
        drop(writer);
        // Now rather than when it gets its name: others may come with it.
        staged.content.as_file().sync_all().map_err(failed)?;
        Ok(staged)
    }

    /// Gives the content its name, in place of what stood there, or passes it on
    /// where there is no file to replace.
    pub(super) fn persist(self) -> Result<(), WriteError> {
        let Self { path, place, mut content } = self;
        let failed = |reason| WriteError::Io { path, reason };
        let Some(file) = place.file() else {
            let passed_on = content.rewind().and_then(|()| place.pass_on(content.as_file_mut()));
            return passed_on.map_err(failed);
        };
        let ready = content.as_file().sync_all().and_then(|()| keep_mode(file, content.path()));
        let named = ready.and_then(|()| content.persist(file).map_err(|e| e.error));
        named.map(drop).map_err(failed)
    }
}

impl Write for Staged {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.content.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.content.flush()
    }
}

/// Gives the file that takes another's place its permissions.
fn keep_mode(former: &Path, new: &Path) -> io::Result<()> {
    #[cfg(unix)]
    if let Ok(about) = fs::metadata(former) {
        return fs::set_permissions(new, fs::Permissions::from_mode(about.permissions().mode() & 0o777));
    }
    Ok(())
}

/// What can't be said in a file is an error of its content.
pub(in crate::io) fn unfit(problem: impl Into<String>) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, problem.into())
}

/// Several files that get their names together or not at all. All content is
/// on disk, under temporary names, before the first name is taken.
#[derive(Debug, Default)]
pub(super) struct Together {
    /// Folders created for the files, outermost first.
    made: Vec<PathBuf>,
    files: Vec<Staged>,
}

impl Together {
    /// Creates a folder and its parents, if missing.
    pub(super) fn folder(&mut self, path: &Path) -> Result<(), WriteError> {
        let missing: Vec<&Path> = path
            .ancestors()
            .take_while(|folder| !folder.as_os_str().is_empty() && !folder.exists())
            .collect();
        for folder in missing.into_iter().rev() {
            fs::create_dir(folder).map_err(|reason| WriteError::Io { path: folder.to_owned(), reason })?;
            self.made.push(folder.to_owned());
        }
        if path.is_dir() {
            return Ok(());
        }
        let reason = io::Error::new(io::ErrorKind::NotADirectory, "a file is in the way of the folder");
        Err(WriteError::Io { path: path.to_owned(), reason })
    }

    /// Adds a file.
    pub(super) fn stage(
        &mut self,
        path: &Path,
        content: impl FnOnce(&mut Sink<'_>) -> io::Result<()>,
    ) -> Result<(), WriteError> {
        self.files.push(Staged::with(path, content)?);
        Ok(())
    }

    /// Gives all files their names, in the order in which they were added; what
    /// is passed on comes last. Where one of them can't have its name, what stood
    /// at the others' is put back.
    pub(super) fn persist(mut self) -> Result<Vec<PathBuf>, WriteError> {
        let mut files = std::mem::take(&mut self.files);
        let paths = files.iter().map(|staged| staged.path.clone()).collect();
        files.sort_by_key(|staged| staged.place.file().is_none());
        let mut placed: Vec<(PathBuf, Option<TempPath>)> = Vec::new();
        let mut failure = None;
        for staged in files {
            let file = staged.place.file().map(Path::to_owned);
            let former = file.as_deref().map_or(Ok(None), former);
            match former.and_then(|former| staged.persist().map(|()| former)) {
                Ok(former) => placed.extend(file.map(|file| (file, former))),
                Err(error) => {
                    failure = Some(error);
                    break;
                }
            }
        }
        let Some(error) = failure else {
            self.made.clear();
            return Ok(paths);
        };
        for (file, former) in placed.into_iter().rev() {
            // Nothing can be done where this fails, too.
            let _ = match former {
                Some(former) => former.persist(&file).map_err(|e| e.error),
                None => fs::remove_file(&file),
            };
        }
        Err(error)
    }
}

impl Drop for Together {
    /// Removes folders that were created in vain.
    fn drop(&mut self) {
        self.files.clear();
        for folder in self.made.iter().rev() {
            // Only goes if it is empty, as it should be.
            let _ = fs::remove_dir(folder);
        }
    }
}

/// The existing file at the target, under a second name that is removed on drop.
fn former(path: &Path) -> Result<Option<TempPath>, WriteError> {
    if !path.exists() {
        return Ok(None);
    }
    let mut builder = tempfile::Builder::new();
    builder.prefix(".superform-").suffix(".old");
    // Some file systems have no second names; there a copy does it.
    let kept = builder
        .make_in(folder_of(path), |second| fs::hard_link(path, second))
        .or_else(|_| builder.make_in(folder_of(path), |second| fs::copy(path, second).map(drop)));
    match kept {
        Ok(kept) => Ok(Some(kept.into_temp_path())),
        Err(reason) => Err(WriteError::Io { path: path.to_owned(), reason }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let entries = fs::read_dir(folder).expect("a folder");
        let mut names: Vec<String> =
            entries.map(|f| f.expect("readable").file_name().to_string_lossy().into_owned()).collect();
        names.sort();
        names
    }

    #[test]
    fn several_files_come_together() {
        let root = tempfile::tempdir().expect("a folder");
        let inner = root.path().join("a/b");
        let mut files = Together::default();
        files.folder(&inner).expect("made");
        files.stage(&inner.join("1"), |w| w.write_all(b"one")).expect("staged");
        files.stage(&root.path().join("2"), |w| w.write_all(b"two")).expect("staged");
        let paths = files.persist().expect("placed");
        assert_eq!(paths, [inner.join("1"), root.path().join("2")]);
        assert_eq!(names(root.path()), ["2", "a"]);
        assert_eq!(fs::read(&paths[0]).expect("there"), b"one");
    }

    #[test]
    fn what_stood_there_is_put_back_where_the_last_file_fails() {
        let root = tempfile::tempdir().expect("a folder");
        let at = |name: &str| root.path().join(name);
        fs::write(at("old"), "mine").expect("written");
        let mut files = Together::default();
        files.folder(&at("made/for/nothing")).expect("made");
        for name in ["old", "new", "last"] {
            files.stage(&at(name), |w| w.write_all(b"other")).expect("staged");
        }
        // The last name is taken only after all have been written.
        fs::create_dir(at("last")).expect("made");
        assert!(files.persist().is_err());
        assert_eq!(names(root.path()), ["last", "old"]);
        assert_eq!(fs::read(at("old")).expect("there"), b"mine");
    }

    #[test]
    fn what_is_not_persisted_leaves_nothing() {
        let root = tempfile::tempdir().expect("a folder");
        let mut files = Together::default();
        files.folder(&root.path().join("x")).expect("made");
        files.stage(&root.path().join("x/1"), |w| w.write_all(b"one")).expect("staged");
        let problem = files.stage(&root.path().join("x/2"), |_| Err(unfit("a hole"))).expect_err("unfit");
        assert!(problem.to_string().ends_with("a hole"), "{problem}");
        drop(files);
        assert!(names(root.path()).is_empty());
    }
}
