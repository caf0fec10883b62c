//! How the models of a field are found and read.

use std::path::Path;

use potamoi_base::record::{Format, Notes};

use crate::AnyField;
use crate::error::FieldError;
use crate::hash::HashUnit;

/// The files of a field's models.
#[derive(Debug)]
pub struct FieldFile {
    /// `model.kind` of descriptions that name one.
    pub kind: &'static str,
    /// How their names end, in small letters, without the dot.
    pub endings: &'static [&'static str],
    /// Their keys.
    pub format: &'static Format,
    /// Keys of `[model]` in a description: `path`, and names of [`FileOptions`].
    pub keys: &'static [&'static str],
    /// Linear RGB behind such models unless something else is asked for.
    pub background: [f32; 3],
    /// Reads one.
    ///
    /// # Errors
    /// No such file, a part that is missing or does not fit, a variant that is not read, or an
    /// option that the file contradicts.
    pub load: fn(&Path, &FileOptions) -> Result<LoadedField, FieldError>,
}

/// What a description says of a file; each is of some algorithms alone.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct FileOptions {
    /// What has an entry of a hashed level; what the file says unless given.
    pub hash_unit: Option<HashUnit>,
}

/// A model that was read.
#[derive(Debug)]
pub struct LoadedField {
    /// The model.
    pub field: AnyField,
    /// What its file says that is not used, and what it leaves to be assumed.
    pub notes: Notes,
}
