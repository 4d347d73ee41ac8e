//! Keeps commands from overwriting their own input files.

use std::collections::HashMap;
use std::fs;
use std::path::{Path, PathBuf};

use super::error::WriteError;
use super::names::{PRIMITIVES_FILES, REPORT_FILE, SEGMENTED_FILE};
use super::read::{buffers_beside, holds_primitives, places_of_shape};
use super::write::is_standard_output;

/// The files that a command reads: known by what they are, and not by what they
/// are called.
#[derive(Debug, Default)]
pub struct Inputs(HashMap<Identity, PathBuf>);

impl Inputs {
    /// Adds a file and, for a glTF text, its external buffers. Missing files cannot be overwritten.
    pub fn add(&mut self, path: &Path) {
        for path in buffers_beside(path).into_iter().chain([path.to_owned()]) {
            if let Some(identity) = Identity::of(&path) {
                self.0.entry(identity).or_insert(path);
            }
        }
    }

    /// Adds what is read of a result: of the folder of a run its files and the
    /// shape that it is of, and so of one of them; else the file.
    pub fn add_result(&mut self, path: &Path) {
        self.add(path);
        let folder = match path.parent() {
            _ if path.is_dir() => path,
            Some(folder) if holds_primitives(path) => folder,
            _ => return,
        };
        for name in PRIMITIVES_FILES.into_iter().chain([SEGMENTED_FILE, REPORT_FILE]) {
            self.add(&folder.join(name));
        }
        places_of_shape(folder).iter().for_each(|path| self.add(path));
    }

    /// # Errors
    /// Where one of the outputs is one of the files.
    pub fn check(&self, outputs: impl IntoIterator<Item = impl AsRef<Path>>) -> Result<(), WriteError> {
        for output in outputs {
            let path = output.as_ref();
            if let Some(input) = Identity::of(path).and_then(|identity| self.0.get(&identity)) {
                return Err(WriteError::IsInput { path: path.to_owned(), input: input.clone() });
            }
        }
        Ok(())
    }
}

/// What makes a file the same, whatever leads to it.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
enum Identity {
    /// Device and inode.
    #[cfg(unix)]
    Inode(u64, u64),
    #[cfg(not(unix))]
    Path(PathBuf),
}

impl Identity {
    /// Of a regular file that is there: a terminal may well be read and written.
    fn of(path: &Path) -> Option<Self> {
        let path = if is_standard_output(path) { Path::new("/dev/stdout") } else { path };
        let about = fs::metadata(path).ok().filter(fs::Metadata::is_file)?;
        #[cfg(unix)]
        {
            use std::os::unix::fs::MetadataExt as _;
            Some(Self::Inode(about.dev(), about.ino()))
        }
        #[cfg(not(unix))]
        {
            let _ = about;
            fs::canonicalize(path).ok().map(Self::Path)
        }
    }
}

#[cfg(all(test, unix))]
mod tests {
    use std::os::unix::fs::symlink;

    use super::*;

    #[test]
    fn a_file_is_the_same_by_any_name() {
        let root = tempfile::tempdir().unwrap();
        let at = |name: &str| root.path().join(name);
        fs::create_dir(at("sub")).unwrap();
        for name in ["a.ply", "b.ply", "scene.bin"] {
            fs::write(at(name), name).unwrap();
        }
        fs::write(at("scene.gltf"), r#" {"buffers": [{"uri": "scene.bin"}, {"uri": "data:,x"}]}"#).unwrap();
        symlink("../a.ply", at("sub/link.ply")).unwrap();
        symlink("sub/link.ply", at("chain")).unwrap();
        fs::hard_link(at("a.ply"), at("hard")).unwrap();
        let mut inputs = Inputs::default();
        inputs.add(&at("a.ply"));
        inputs.add(&at("scene.gltf"));
        inputs.add(&at("gone.ply"));
        for name in ["a.ply", "./a.ply", "sub/../a.ply", "sub/link.ply", "chain", "hard", "scene.bin"] {
            let problem = inputs.check([at("b.ply"), at(name)]).unwrap_err().to_string();
            let input = if name == "scene.bin" { name } else { "a.ply" };
            assert!(problem.contains(name) && problem.contains(&format!("input {}", at(input).display())));
        }
        inputs.check([at("b.ply"), at("new"), at("sub"), at("gone.ply")]).unwrap();
    }
}
