//! The folder in which programs work on a result.

use std::path::{Path, PathBuf};

use potamoi_verilated::cache::Scratch;

use crate::SynthError;

/// A temporary folder; it goes when it is dropped, or with the next run where the process is
/// killed.
pub(crate) struct WorkFolder(Scratch);

impl WorkFolder {
    /// An empty one.
    ///
    /// # Errors
    /// The folder of temporary files cannot be written.
    pub(crate) fn new() -> Result<Self, SynthError> {
        let made = Scratch::temporary().map_err(cannot(&std::env::temp_dir()))?;
        Ok(Self(made))
    }

    pub(crate) fn path(&self) -> &Path {
        self.0.path()
    }

    /// A file's path.
    pub(crate) fn file(&self, name: &str) -> PathBuf {
        self.path().join(name)
    }

    /// Writes a file.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub(crate) fn write(&self, name: &str, text: &str) -> Result<(), SynthError> {
        let path = self.file(name);
        std::fs::write(&path, text).map_err(cannot(&path))
    }

    /// What a program left in a file, if it left one.
    pub(crate) fn read(&self, name: &str) -> Option<String> {
        std::fs::read_to_string(self.file(name)).ok()
    }
}

fn cannot(path: &Path) -> impl FnOnce(std::io::Error) -> SynthError {
    let path = path.to_owned();
    move |source| SynthError::Temporary { path, source }
}
