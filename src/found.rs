//! The file of a machine that a search finds: under another name until its Verilog is verified.

use std::ffi::OsString;
use std::path::{Path, PathBuf};

use potamoi_base::outputs::{self, FileError};

/// First line of the file of a machine whose Verilog is not verified.
const UNPROVED: &str = "# The best so far: its Verilog is not verified yet.\n";

/// The file, and what is written before it.
pub(crate) struct Found<'a> {
    file: &'a Path,
    /// As the file, with `.unverified` before its ending.
    unproved: PathBuf,
}

impl<'a> Found<'a> {
    pub(crate) fn new(file: &'a Path) -> Self {
        let mut ending = OsString::from("unverified");
        if let Some(own) = file.extension() {
            ending.push(".");
            ending.push(own);
        }
        Self {
            file,
            unproved: file.with_extension(ending),
        }
    }

    /// Keeps a machine that is not verified, in the place of an earlier one.
    pub(crate) fn keep_unproved(&self, text: &str) -> Result<(), FileError> {
        outputs::write(&self.unproved, &format!("{UNPROVED}{text}"))
    }

    /// Writes the machine, whose Verilog was verified.
    pub(crate) fn write(&self, text: &str) -> Result<(), FileError> {
        outputs::write(self.file, text)?;
        // What is not there any more needs no removal.
        let _ = std::fs::remove_file(&self.unproved);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;

    #[test]
    fn only_what_is_proved_has_the_file_s_name() {
        let folder = tempfile::tempdir().unwrap();
        for name in ["own.toml", "own"] {
            let file = folder.path().join(name);
            std::fs::write(&file, "earlier").unwrap();
            let found = Found::new(&file);
            found.keep_unproved("a = 1\n").unwrap();
            assert_eq!(std::fs::read_to_string(&file).unwrap(), "earlier");
            let kept = std::fs::read_to_string(&found.unproved).unwrap();
            assert!(kept.starts_with("# ") && kept.ends_with("\na = 1\n"));
            found.write("a = 2\n").unwrap();
            assert_eq!(std::fs::read_to_string(&file).unwrap(), "a = 2\n");
            assert!(!found.unproved.exists());
        }
        assert!(
            Found::new(Path::new("x/own.toml"))
                .unproved
                .ends_with("own.unverified.toml")
        );
    }
}
