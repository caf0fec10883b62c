//! `[model]`: what is shown.

use std::path::PathBuf;

use potamoi_base::record::told;
use potamoi_fields::{FieldFile, FileOptions, HashUnit, algorithms};
use potamoi_formats::document::{Value, Wrong};
use potamoi_splats::Axes;
use serde::de::Error as _;
use serde::{Deserialize, Deserializer};

use super::{kind_of, of_kind};

/// `[model]`.
#[derive(Debug, Clone, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub(crate) enum ModelDescription {
    /// A scene that is built in.
    Builtin {
        /// Its name.
        name: String,
        /// What it is made into, if it is known exactly.
        representation: Option<String>,
    },
    /// A model file of Gaussians.
    Splats {
        /// A file or SOG folder, from the description's folder.
        path: PathBuf,
        /// Where its x, y and z point; what the file says or its format has unless given.
        #[serde(default, deserialize_with = "axes")]
        axes: Option<Axes>,
    },
    /// A Compact-3DGS model.
    #[serde(rename = "compact-3dgs")]
    Compact3dgs {
        /// Its `.npz`, from the description's folder.
        path: PathBuf,
        /// Where its x, y and z point; right, down and to the front unless given.
        #[serde(default, deserialize_with = "axes")]
        axes: Option<Axes>,
    },
    /// An image sequence with depth.
    Images(ImagesDescription),
    /// A file of a field; its kind is the file's.
    #[serde(skip)]
    Field {
        /// How such files are read.
        file: &'static FieldFile,
        /// Which one, from the description's folder.
        path: PathBuf,
        /// What is said of it.
        options: FileOptions,
    },
}

/// Kinds of models that are no fields.
pub(super) const MODEL_KINDS: [&str; 4] = ["builtin", "splats", "compact-3dgs", "images"];

/// What may be said of a field's file, all kinds together.
#[derive(Deserialize)]
struct FileDescription {
    path: PathBuf,
    hash_unit: Option<HashUnit>,
}

fn axes<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<Axes>, D::Error> {
    let text = String::deserialize(deserializer)?;
    text.parse().map(Some).map_err(D::Error::custom)
}

impl ModelDescription {
    pub(super) fn of(value: &Value) -> Result<Self, String> {
        let (kind, fields) = kind_of("model", value)?;
        if let Some(file) = algorithms::files().find(|file| file.kind == kind) {
            return Self::of_field(file, &fields).map_err(|e| e.under("model").to_string());
        }
        if !MODEL_KINDS.contains(&&*kind) {
            let kinds = [&MODEL_KINDS[..3], &field_kinds(), &MODEL_KINDS[3..]].concat();
            let (found, all) = (told(&kind), kinds.join(", "));
            return Err(format!(
                "field `model.kind`: found \"{found}\", expected one of {all}"
            ));
        }
        of_kind("model", &kind, fields)
    }

    fn of_field(file: &'static FieldFile, fields: &Value) -> Result<Self, Wrong> {
        if let Value::Map(entries) = fields {
            let unknown = entries.iter().find(|(key, _)| !file.keys.contains(&&**key));
            if let Some((key, _)) = unknown {
                return Err(Wrong::unknown_field(key, file.keys));
            }
        }
        let FileDescription { path, hash_unit } = fields.read()?;
        Ok(Self::Field {
            file,
            path,
            options: FileOptions { hash_unit },
        })
    }
}

pub(super) fn field_kinds() -> Vec<&'static str> {
    algorithms::files().map(|file| file.kind).collect()
}

/// `[model]` of `kind = "images"`.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct ImagesDescription {
    /// The folder, with `transforms.json` and the pictures that it names.
    pub(crate) path: PathBuf,
    /// In it, the folder of the depths: OpenEXR files named as the pictures, the
    /// depth along the camera's axis in their red channel.
    #[serde(default = "depth_folder")]
    pub(crate) depth: PathBuf,
    /// Units of the poses a unit of the depths.
    #[serde(default = "one")]
    pub(crate) depth_scale: f64,
    /// Depths above this, in units of the poses, are void.
    #[serde(default = "infinity")]
    pub(crate) void_above: f64,
}

fn depth_folder() -> PathBuf {
    PathBuf::from("depth")
}

const fn one() -> f64 {
    1.0
}

const fn infinity() -> f64 {
    f64::INFINITY
}
