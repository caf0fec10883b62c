//! Working folder of the programs.

use std::path::{Path, PathBuf};

use potamoi_verilated::cache::Scratch;

use crate::SynthError;

/// A temporary folder, removed when dropped, or at the next run if the process is killed.
pub(crate) struct WorkFolder(Scratch);

impl WorkFolder {
    /// An empty folder.
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

    /// Path of a file in it.
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

    /// Text of a file in it, if present.
    pub(crate) fn read(&self, name: &str) -> Option<String> {
        std::fs::read_to_string(self.file(name)).ok()
    }
}

fn cannot(path: &Path) -> impl FnOnce(std::io::Error) -> SynthError {
    let path = path.to_owned();
    move |source| SynthError::Temporary { path, source }
}
