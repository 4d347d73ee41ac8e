//! Files that are written whole or not at all, one or several.

use std::fs;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use tempfile::{NamedTempFile, TempPath};

use crate::io::WriteError;

/// Writes some bytes as a file.
///
/// # Errors
/// Where the file can't be written. It is written whole or not at all.
pub fn write_whole(path: &Path, content: &[u8]) -> Result<(), WriteError> {
    let file = staged(path, |w| w.write_all(content))?;
    persist(file, path)
}

/// Writes a file piece by piece.
///
/// # Errors
/// Where the file can't be written. It is written whole or not at all.
pub fn write_streamed(
    path: &Path,
    content: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> Result<(), WriteError> {
    let file = staged(path, |w| content(w))?;
    persist(file, path)
}

/// What a file is written through.
pub(super) type Sink<'a> = BufWriter<&'a mut fs::File>;

/// A temporary file with the content, in the folder of `path`. It goes when
/// it is dropped.
pub(super) fn staged(
    path: &Path,
    content: impl FnOnce(&mut Sink<'_>) -> io::Result<()>,
) -> Result<NamedTempFile, WriteError> {
    let failed = |reason: io::Error| match reason.kind() {
        io::ErrorKind::InvalidData => {
            WriteError::Content { path: path.to_owned(), problem: reason.to_string() }
        }
        _ => WriteError::Io { path: path.to_owned(), reason },
    };
    if path.is_dir() {
        return Err(WriteError::IsAFolder { path: path.to_owned() });
    }
    let mut builder = tempfile::Builder::new();
    builder.prefix(".superform-").suffix(".part");
    // Temporary files are private by default; results follow the umask.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    // The kind alone: the full text names the temporary file, which means nothing to anybody.
    let mut file = builder.tempfile_in(folder_of(path)).map_err(|e| failed(e.kind().into()))?;
    let mut writer = BufWriter::with_capacity(1 << 18, file.as_file_mut());
    content(&mut writer).and_then(|()| writer.flush()).map_err(failed)?;
    drop(writer);
    file.as_file().sync_all().map_err(failed)?;
    Ok(file)
}

fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// Gives a temporary file its name, in place of what stood there.
pub(super) fn persist(file: NamedTempFile, path: &Path) -> Result<(), WriteError> {
    file.persist(path).map(drop).map_err(|e| WriteError::Io { path: path.to_owned(), reason: e.error })
}

/// What can't be said in a file is an error of its content.
pub(super) fn unfit(problem: impl Into<String>) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, problem.into())
}

/// Several files that get their names together or not at all. All content is
/// on disk, under temporary names, before the first name is taken.
#[derive(Debug, Default)]
pub(super) struct Together {
    /// Folders that were made for the files, the outermost first.
    made: Vec<PathBuf>,
    files: Vec<(NamedTempFile, PathBuf)>,
}

impl Together {
    /// Makes a folder, and those above it, where there is none.
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
        self.files.push((staged(path, content)?, path.to_owned()));
        Ok(())
    }

    /// Gives all files their names, in the order in which they were added.
    /// Where one of them can't have its name, what stood at the others' is put
    /// back.
    pub(super) fn persist(mut self) -> Result<Vec<PathBuf>, WriteError> {
        let mut placed: Vec<(PathBuf, Option<TempPath>)> = Vec::new();
        let mut failure = None;
        for (file, path) in std::mem::take(&mut self.files) {
            let former = former(&path);
            match former.and_then(|former| persist(file, &path).map(|()| former)) {
                Ok(former) => placed.push((path, former)),
                Err(error) => {
                    failure = Some(error);
                    break;
                }
            }
        }
        let Some(error) = failure else {
            self.made.clear();
            return Ok(placed.into_iter().map(|(path, _)| path).collect());
        };
        for (path, former) in placed.into_iter().rev() {
            // Nothing can be done where this fails, too.
            let _ = match former {
                Some(former) => former.persist(&path).map_err(|e| e.error),
                None => fs::remove_file(&path),
            };
        }
        Err(error)
    }
}

impl Drop for Together {
    /// Folders that were made for nothing go again.
    fn drop(&mut self) {
        self.files.clear();
        for folder in self.made.iter().rev() {
            // Only goes if it is empty, as it should be.
            let _ = fs::remove_dir(folder);
        }
    }
}

/// What stands at the place now, under a second name that goes when it is
/// dropped.
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
