//! Scene descriptions: TOML files that name a model, a camera and how to render.

use std::path::{Path, PathBuf};

use serde::Deserialize;
use serde::de::DeserializeOwned;
use toml::{Table, Value};

use super::SceneError;
use super::images::ImagesDescription;
use crate::fields::HashUnit;

/// The largest description, in bytes.
const LIMIT: u64 = 1 << 20;

/// A `scene.toml`.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Description {
    /// What is shown.
    pub(super) model: ModelDescription,
    /// From where.
    pub(super) camera: CameraDescription,
    /// How.
    pub(super) render: RenderDescription,
}

/// The sections of the file; two of them are read by their `kind`.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Sections {
    model: Table,
    camera: Option<Table>,
    #[serde(default)]
    render: RenderDescription,
}

/// `[model]`.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub(super) enum ModelDescription {
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
    },
    /// A Compact-3DGS model.
    #[serde(rename = "compact-3dgs")]
    Compact3dgs {
        /// Its `.npz`, from the description's folder.
        path: PathBuf,
    },
    /// An Instant-NGP snapshot.
    Ngp {
        /// Its `.ingp` or `.msgpack`, from the description's folder.
        path: PathBuf,
        /// What has an entry of a hashed level; what the file says unless given.
        hash_unit: Option<HashUnit>,
    },
    /// A DirectVoxGO checkpoint.
    Dvgo {
        /// Its fine stage, from the description's folder.
        path: PathBuf,
    },
    /// A TensoRF checkpoint.
    Tensorf {
        /// The `.th` file, from the description's folder.
        path: PathBuf,
    },
    /// An image sequence with depth.
    Images(ImagesDescription),
}

/// `[camera]`. Without it, the model's own.
#[derive(Debug, Clone, Default, PartialEq, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub(super) enum CameraDescription {
    /// The built-in scene's view, or an orbit that frames a model.
    #[default]
    #[serde(skip)]
    Default,
    /// A camera file in the OpenCV convention.
    OpencvJson {
        /// JSON file, from the description's folder.
        path: PathBuf,
        /// Which camera of the file, from 0.
        #[serde(default)]
        index: usize,
        /// Pixels a row; the file's unless given.
        width: Option<u32>,
        /// Rows; the file's unless given.
        height: Option<u32>,
    },
    /// A frame of a camera path in the convention of NeRF and Instant-NGP.
    Transforms {
        /// JSON file, from the description's folder.
        path: PathBuf,
        /// Which frame of the path, from 0.
        #[serde(default)]
        index: usize,
        /// Pixels a row; the file's unless given.
        width: Option<u32>,
        /// Rows; the file's unless given.
        height: Option<u32>,
    },
    /// An image of a COLMAP reconstruction in text form; images are sorted by
    /// name.
    Colmap {
        /// The folder, from the description's folder.
        path: PathBuf,
        /// Which image, from 0.
        index: Option<usize>,
        /// Or its name.
        name: Option<String>,
        /// Pixels a row; the file's unless given.
        width: Option<u32>,
        /// Rows; the file's unless given.
        height: Option<u32>,
    },
    /// Looking at a point from a distance.
    Orbit {
        /// Degrees about the vertical axis; the default's unless given.
        azimuth: Option<f64>,
        /// Degrees above the horizon.
        elevation: Option<f64>,
        /// In the scene's units.
        distance: Option<f64>,
        /// Vertical field of view in degrees.
        fov: Option<f64>,
        /// What is in the middle.
        target: Option<[f64; 3]>,
        /// Pixels a row.
        width: Option<u32>,
        /// Rows.
        height: Option<u32>,
    },
}

/// `[render]`.
#[derive(Debug, Clone, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RenderDescription {
    /// Rule set for splats.
    pub(super) profile: Option<String>,
    /// Linear RGB behind everything.
    pub(super) background: Option<[f32; 3]>,
    /// In which order splats are composited: exact or approximate.
    pub(super) order: Option<String>,
    /// Columns and rows of tiles of a ray group, for splats.
    pub(super) group_tiles: Option<[u32; 2]>,
    /// Pixels a side of a ray group, for voxels.
    pub(super) group_side: Option<u32>,
    /// How MVoxels share vertices, for voxels and fields: shared or split.
    pub(super) halo: Option<String>,
    /// Voxel edges from sample to sample, for voxels.
    pub(super) step: Option<f64>,
    /// What is left of the light where a pixel stops, for splats and voxels.
    pub(super) stop_below: Option<f64>,
    /// The alpha below which splats are skipped.
    pub(super) alpha_min: Option<f64>,
    /// Fraction bits of transmittances, for splats and voxels.
    pub(super) transmittance_bits: Option<u32>,
    /// Fraction bits of the factors of splats' conics.
    pub(super) conic_bits: Option<u32>,
    /// Levels whose vertices share entries that are gathered, from the coarsest.
    pub(super) hashed_levels: Option<u32>,
}

impl Description {
    /// Reads a description.
    ///
    /// # Errors
    /// The file cannot be read or is no description.
    pub(super) fn read(path: &Path) -> Result<Self, SceneError> {
        let fail = |source| SceneError::Read {
            path: path.to_owned(),
            source,
        };
        let wrong = |message| SceneError::Description {
            path: path.to_owned(),
            message,
        };
        let bytes = crate::files::read(path, LIMIT).map_err(fail)?;
        let bytes = bytes
            .ok_or_else(|| wrong(format!("expected a description of at most {LIMIT} bytes")))?;
        let text = String::from_utf8(bytes).map_err(|e| wrong(e.to_string()))?;
        Self::parse(&text).map_err(wrong)
    }

    /// Errors name the field, and its line where the reader knows it.
    fn parse(text: &str) -> Result<Self, String> {
        let reader = toml::Deserializer::parse(text).map_err(|e| e.to_string())?;
        let sections: Sections = serde_path_to_error::deserialize(reader)
            .map_err(|e| format!("field `{}`: {}", e.path(), e.inner()))?;
        Ok(Self {
            model: by_kind("model", sections.model)?,
            camera: match sections.camera {
                Some(table) => by_kind("camera", table)?,
                None => CameraDescription::Default,
            },
            render: sections.render,
        })
    }
}

/// Reads a section whose `kind` says which fields it has.
fn by_kind<T: DeserializeOwned>(section: &str, mut table: Table) -> Result<T, String> {
    let kind = match table.remove("kind") {
        Some(Value::String(kind)) => kind,
        Some(other) => return Err(format!("field `{section}.kind`: {other} is not a text")),
        None => return Err(format!("field `{section}.kind` is missing")),
    };
    let tagged = Table::from_iter([(kind.clone(), Value::Table(table))]);
    serde_path_to_error::deserialize(Value::Table(tagged)).map_err(|e| {
        let path = e.path().to_string();
        let field = match path.strip_prefix(&kind) {
            Some(rest) => format!("{section}{rest}"),
            None => format!("{section}.kind"),
        };
        format!("field `{field}`: {}", e.inner().message())
    })
}
