//! The `[model]` section.

use std::path::PathBuf;

use potamoi_base::file_keys::told;
use potamoi_fields::{FieldFile, FileOptions, HashUnit, algorithms};
use potamoi_formats::document::{Value, Wrong};
use potamoi_gaussians::Axes;
use serde::de::Error as _;
use serde::{Deserialize, Deserializer};

use super::{kind_of, of_kind};

/// The `[model]` section.
#[derive(Debug, Clone, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub(crate) enum ModelDescription {
    /// A built-in scene.
    Builtin {
        /// Its name.
        name: String,
        /// Its representation, for analytic scenes.
        representation: Option<String>,
    },
    /// A file of Gaussians.
    Splats {
        /// A file or SOG folder, relative to the description's folder.
        path: PathBuf,
        /// Directions of its x, y and z axes; by default those of the file or of its format.
        #[serde(default, deserialize_with = "axes")]
        axes: Option<Axes>,
        /// The level of detail of streamed SOG; by default 0, the finest.
        level: Option<usize>,
    },
    /// A Compact-3DGS model.
    #[serde(rename = "compact-3dgs")]
    Compact3dgs {
        /// Its `.npz`, relative to the description's folder.
        path: PathBuf,
        /// Directions of its x, y and z axes; by default right, down and front.
        #[serde(default, deserialize_with = "axes")]
        axes: Option<Axes>,
    },
    /// An image sequence with depth.
    Images(ImagesDescription),
    /// A field, whose file format determines the kind.
    #[serde(skip)]
    Field {
        /// The file format.
        file: &'static FieldFile,
        /// The file, relative to the description's folder.
        path: PathBuf,
        /// Options for the file.
        options: FileOptions,
    },
}

/// Kinds of models other than fields.
pub(super) const MODEL_KINDS: [&str; 4] = ["builtin", "splats", "compact-3dgs", "images"];

/// Options for a field's file, of all kinds together.
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

/// The `[model]` section of `kind = "images"`.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct ImagesDescription {
    /// The folder with `transforms.json` and the pictures that it names.
    pub(crate) path: PathBuf,
    /// The folder of the depths in it: OpenEXR files named like the pictures, with the depth along
    /// the camera's axis in the red channel.
    #[serde(default = "depth_folder")]
    pub(crate) depth: PathBuf,
    /// Length of a depth unit in units of the poses.
    #[serde(default = "one")]
    pub(crate) depth_scale: f64,
    /// Depths above this, in units of the poses, count as void.
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
