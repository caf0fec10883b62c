//! Device files: figures of hardware in TOML, each with the publication that states it or the
//! reason why it is assumed.
//!
//! ```
//! use potamoi_formats::device_file::{Figure, Kind, Origin};
//!
//! const LAMP: Kind = Kind {
//!     name: "lamp",
//!     example: "lamps/desk.toml",
//!     texts: &["title"],
//! };
//! let watts = Figure { key: "watts", unit: "W", least: 1.0, most: 100.0 };
//! let text = "title = \"Desk\"\nwatts = { value = 40, source = \"its label\" }";
//! let read = LAMP.read("desk.toml", text, &[watts])?;
//! assert_eq!(read.figures["watts"], (40.0, Origin::Source("its label".to_owned())));
//!
//! let error = LAMP.read("desk.toml", "title = \"Desk\"", &[watts]).unwrap_err();
//! assert!(error.to_string().contains("`watts` is missing"), "{error}");
//! # Ok::<(), potamoi_formats::device_file::DeviceError>(())
//! ```

mod error;
mod read;

use std::collections::BTreeMap;
use std::path::Path;

pub use error::DeviceError;

use crate::files;

/// Size limit of a device file, in bytes.
const LARGEST: u64 = 1 << 20;

/// Where a figure comes from.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Origin {
    /// A publication that states it, or that it follows from.
    Source(String),
    /// Why it is assumed.
    Assumed(String),
}

/// A kind of device, in messages, and the keys of its files that hold text.
#[derive(Debug, Clone, Copy)]
pub struct Kind {
    /// Its name, such as `memory device`.
    pub name: &'static str,
    /// A file to start from.
    pub example: &'static str,
    /// Keys that hold text.
    pub texts: &'static [&'static str],
}

/// A figure that every file of a kind has.
#[derive(Debug, Clone, Copy)]
pub struct Figure {
    /// Key in the file.
    pub key: &'static str,
    /// Unit, for messages and tables.
    pub unit: &'static str,
    /// Least value that is accepted.
    pub least: f64,
    /// Largest value that is accepted.
    pub most: f64,
}

/// Contents of a device file.
#[derive(Debug, Clone, Default)]
pub struct Contents {
    /// Texts by key.
    pub texts: BTreeMap<String, String>,
    /// Figures by key, with their origins.
    pub figures: BTreeMap<String, (f64, Origin)>,
}

impl Kind {
    /// Reads the text of a file; `file` stands in messages.
    ///
    /// # Errors
    /// [`DeviceError`], where the text is not TOML, has a key that no device has, lacks a text, a
    /// figure or its origin, or has a value out of range.
    pub fn read(
        &self,
        file: &str,
        text: &str,
        figures: &[Figure],
    ) -> Result<Contents, DeviceError> {
        read::contents(self, file, text, figures)
    }

    /// Name and text of a file. The name is the file's without the ending.
    ///
    /// # Errors
    /// [`DeviceError::Unreadable`].
    pub fn open(&self, path: &Path) -> Result<(String, String), DeviceError> {
        let text = files::read_text(path, LARGEST).map_err(|source| DeviceError::Unreadable {
            file: path.display().to_string(),
            source,
            example: self.example,
        })?;
        let stem = path.file_stem().unwrap_or_default();
        Ok((stem.to_string_lossy().into_owned(), text))
    }

    /// The error for a name that no device has, with the nearest of `names`.
    #[must_use]
    pub fn unknown(&self, name: &str, names: &[&str]) -> DeviceError {
        let near = crate::nearest::nearest(name, names.iter().copied());
        DeviceError::Unknown {
            kind: self.name,
            name: name.to_owned(),
            suggestion: near.map_or_else(String::new, |n| format!("; did you mean `{n}`?")),
            known: names.join(", "),
        }
    }
}

/// Whether a text is the path of a device file, and no name of a device.
#[must_use]
pub fn is_file(given: &str) -> bool {
    given.contains(['/', '\\', '.'])
}
