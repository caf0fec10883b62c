//! Model files of a field.

use std::path::Path;

use potamoi_base::file_keys::{Format, Notes};

use crate::AnyField;
use crate::error::FieldError;
use crate::hash::HashUnit;

/// A file format of a field's models.
#[derive(Debug)]
pub struct FieldFile {
    /// `model.kind` in descriptions that use this format.
    pub kind: &'static str,
    /// File extensions, in lower case, without the dot.
    pub endings: &'static [&'static str],
    /// Keys of the format.
    pub format: &'static Format,
    /// Keys of `[model]` in a description: `path`, and names of [`FileOptions`].
    pub keys: &'static [&'static str],
    /// Default background, linear RGB.
    pub background: [f32; 3],
    /// Reads a model.
    ///
    /// # Errors
    /// The file is missing or of another kind, a part is missing or inconsistent, the variant is
    /// not supported, or the file contradicts an option.
    pub load: fn(&Path, &FileOptions) -> Result<LoadedField, FieldError>,
}

/// Options that a description may give for a file; each applies only to some algorithms.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct FileOptions {
    /// What shares an entry of a hashed level; by default as the file states.
    pub hash_unit: Option<HashUnit>,
}

/// A loaded model.
#[derive(Debug)]
pub struct LoadedField {
    /// The model.
    pub field: AnyField,
    /// Unused parts of the file, and assumptions.
    pub notes: Notes,
}
