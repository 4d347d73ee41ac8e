//! The target of a path: a file, which is replaced, or something that is written directly, such as
//! a device, a pipe or an open descriptor.

use std::fs::{self, File, OpenOptions};
use std::io;
use std::path::{Path, PathBuf};

use super::standard::print;

/// The name of standard output. A file of that name is `./-`.
const STANDARD_OUTPUT: &str = "-";
/// As many links in a row as Linux follows.
const MOST_LINKS: usize = 40;

/// The target of a path, with all links followed.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Place {
    /// An existing file, or the name of a new one.
    File(PathBuf),
    StandardOutput,
    StandardError,
    /// Another descriptor that is open, by its path: what is there is kept.
    Descriptor(PathBuf),
    /// A device, a named pipe.
    Node(PathBuf),
}

impl Place {
    pub(super) fn of(path: &Path) -> io::Result<Self> {
        if path == Path::new(STANDARD_OUTPUT) {
            return Ok(Self::StandardOutput);
        }
        let mut at = path.to_owned();
        for _ in 0..MOST_LINKS {
            // Before it is followed as a link, which it is on Linux: the name that it
            // leads to may be gone, or be written by others, too.
            if let Some(place) = descriptor(&at) {
                return Ok(place);
            }
            match fs::symlink_metadata(&at) {
                Ok(about) if about.is_symlink() => at = folder_of(&at).join(fs::read_link(&at)?),
                Ok(about) if about.is_file() || about.is_dir() => return Ok(Self::File(at)),
                Ok(_) => return Ok(Self::Node(at)),
                Err(e) if e.kind() == io::ErrorKind::NotFound => return Ok(Self::File(at)),
                Err(e) => return Err(e),
            }
        }
        Err(io::Error::other("its links form a cycle"))
    }

    /// The file that is replaced, if it is one.
    pub(super) fn file(&self) -> Option<&Path> {
        if let Self::File(path) = self { Some(path) } else { None }
    }

    /// Writes through what is no file.
    pub(super) fn pass_on(&self, content: &mut File) -> io::Result<()> {
        let mut out = match self {
            Self::StandardOutput => return print(content),
            Self::StandardError => return io::copy(content, &mut io::stderr()).map(drop),
            Self::Descriptor(path) => OpenOptions::new().append(true).open(path)?,
            Self::Node(path) | Self::File(path) => OpenOptions::new().write(true).open(path)?,
        };
        io::copy(content, &mut out).map(drop)
    }
}

/// Whether what is written to a path arrives at standard output: then nothing
/// else may be said there.
pub fn is_standard_output(path: &Path) -> bool {
    matches!(Place::of(path), Ok(Place::StandardOutput))
}

/// Whether a path is written directly, so that no files can be placed next to it.
pub fn is_written_through(path: &Path) -> bool {
    Place::of(path).is_ok_and(|place| place.file().is_none())
}

pub(super) fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// The open descriptor that a path names, as `/dev/fd/1` and
/// `/proc/self/fd/1` do.
#[cfg(unix)]
fn descriptor(path: &Path) -> Option<Place> {
    let number: u32 = path.file_name()?.to_str()?.parse().ok()?;
    let folder = fs::canonicalize(folder_of(path)).ok()?;
    let parts: Vec<&str> = folder.iter().filter_map(|part| part.to_str()).collect();
    let is_own = match parts[..] {
        ["/", "dev", "fd"] => true,
        ["/", "proc", process, "fd"] | ["/", "proc", process, "task", _, "fd"] => {
            process.parse() == Ok(std::process::id())
        }
        _ => return None,
    };
    Some(match number {
        1 if is_own => Place::StandardOutput,
        2 if is_own => Place::StandardError,
        _ => Place::Descriptor(path.to_owned()),
    })
}

#[cfg(not(unix))]
fn descriptor(_: &Path) -> Option<Place> {
    None
}

#[cfg(all(test, unix))]
mod tests {
    use std::os::unix::fs::symlink;

    use super::*;

    #[test]
    fn links_are_followed_to_the_end_also_where_there_is_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::create_dir(at("deep")).unwrap();
        symlink("deep/second", at("first")).unwrap();
        symlink("../file", at("deep/second")).unwrap();
        symlink("round", at("round")).unwrap();
        let file = Place::of(&at("first")).unwrap();
        assert_eq!(file.file(), Some(folder.path().join("deep/../file").as_path()));
        fs::write(at("file"), "").unwrap();
        assert_eq!(Place::of(&at("first")).unwrap(), file);
        assert!(Place::of(&at("round")).unwrap_err().to_string().contains("form a cycle"));
        assert_eq!(Place::of(&at("-")).unwrap(), Place::File(at("-")));
        assert_eq!(Place::of(Path::new("-")).unwrap(), Place::StandardOutput);
    }

    #[test]
    fn descriptors_and_devices_are_no_files() {
        assert_eq!(Place::of(Path::new("/dev/fd/1")).unwrap(), Place::StandardOutput);
        assert_eq!(Place::of(Path::new("/dev/fd/2")).unwrap(), Place::StandardError);
        let folder = tempfile::tempdir().unwrap();
        symlink("/dev/null", folder.path().join("link")).unwrap();
        assert_eq!(Place::of(&folder.path().join("link")).unwrap(), Place::Node("/dev/null".into()));
        if cfg!(target_os = "linux") {
            for path in ["/dev/stdout", "/proc/self/fd/1", "/proc/thread-self/fd/1"] {
                assert_eq!(Place::of(Path::new(path)).unwrap(), Place::StandardOutput, "{path}");
            }
            // Of another process, whose own business it is.
            let parent = PathBuf::from(format!("/proc/{}/fd/1", std::os::unix::process::parent_id()));
            assert_eq!(Place::of(&parent).unwrap(), Place::Descriptor(parent));
        }
    }
}
