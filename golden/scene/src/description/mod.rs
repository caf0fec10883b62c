//! Scene descriptions: TOML files with a model, a camera and render options.

mod keys;
mod model;
#[cfg(test)]
mod tests;
mod trajectory;

use std::path::{Path, PathBuf};

use potamoi_base::precision::{NUMBERS, Number, Precision};
use potamoi_formats::document::{self, Value, Wrong};
use serde::Deserialize;
use serde::de::DeserializeOwned;

use super::SceneError;
pub(super) use keys::DESCRIPTION;
pub(super) use model::{ImagesDescription, ModelDescription};
use potamoi_base::file_keys::told;
pub(super) use trajectory::TrajectoryDescription;

/// The largest description, in bytes.
const LIMIT: u64 = 1 << 20;

/// A `scene.toml`.
#[derive(Debug, Clone)]
pub(super) struct Description {
    /// The model.
    pub(super) model: ModelDescription,
    /// The camera.
    pub(super) camera: CameraDescription,
    /// The render options.
    pub(super) render: RenderDescription,
}

/// `[camera]`; by default the model's own camera.
#[derive(Debug, Clone, Default, PartialEq, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub(super) enum CameraDescription {
    /// The built-in scene's camera, or an orbit that frames a model.
    #[default]
    #[serde(skip)]
    Default,
    /// A camera file in the OpenCV convention.
    OpencvJson {
        /// JSON file, relative to the description's folder.
        path: PathBuf,
        /// Index of the camera in the file, from 0.
        #[serde(default)]
        index: usize,
        /// Width in pixels; by default the file's.
        width: Option<u32>,
        /// Height in pixels; by default the file's.
        height: Option<u32>,
    },
    /// A frame of a camera path in the convention of NeRF and Instant-NGP.
    Transforms {
        /// JSON file, relative to the description's folder.
        path: PathBuf,
        /// Index of the frame in the path, from 0.
        #[serde(default)]
        index: usize,
        /// Width in pixels; by default the file's.
        width: Option<u32>,
        /// Height in pixels; by default the file's.
        height: Option<u32>,
    },
    /// An image of a COLMAP reconstruction in text form; images are sorted by
    /// name.
    Colmap {
        /// The folder, relative to the description's folder.
        path: PathBuf,
        /// Index of the image, from 0.
        index: Option<usize>,
        /// Name of the image, in place of the index.
        name: Option<String>,
        /// Width in pixels; by default the file's.
        width: Option<u32>,
        /// Height in pixels; by default the file's.
        height: Option<u32>,
    },
    /// Recorded motion, placed in the scene.
    Trajectory(Box<TrajectoryDescription>),
    /// A camera that looks at a point from a distance.
    Orbit {
        /// Degrees about the vertical axis; by default that of the default orbit.
        azimuth: Option<f64>,
        /// Degrees above the horizon.
        elevation: Option<f64>,
        /// Distance in the scene's units.
        distance: Option<f64>,
        /// Vertical field of view in degrees.
        fov: Option<f64>,
        /// The point in the middle of the picture.
        target: Option<[f64; 3]>,
        /// Width in pixels.
        width: Option<u32>,
        /// Height in pixels.
        height: Option<u32>,
    },
}

/// `[render]`.
#[derive(Debug, Clone, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RenderDescription {
    /// Rule set for splats.
    pub(super) profile: Option<String>,
    /// Background, linear RGB.
    pub(super) background: Option<[f32; 3]>,
    /// The order in which splats are composited: exact or approximate.
    pub(super) order: Option<String>,
    /// Columns and rows of tiles in a ray group, for splats.
    pub(super) group_tiles: Option<[u32; 2]>,
    /// Side of a ray group in pixels, for voxels.
    pub(super) group_side: Option<u32>,
    /// The kind of halo, for voxels and fields: shared or split.
    pub(super) halo: Option<String>,
    /// Step in voxel edges, for voxels.
    pub(super) step: Option<f64>,
    /// Whether splats were trained with antialiasing; by default as their file states.
    pub(super) antialiased: Option<bool>,
    /// Thresholds, widths and levels.
    #[serde(skip)]
    pub(super) precision: Precision,
}

impl Description {
    /// Reads a description.
    ///
    /// # Errors
    /// The file cannot be read or is not a description.
    pub(super) fn read(path: &Path) -> Result<Self, SceneError> {
        let fail = |source| SceneError::Read {
            path: path.to_owned(),
            source,
        };
        let wrong = |message| SceneError::Description {
            path: path.to_owned(),
            message,
        };
        let bytes = potamoi_base::files::read(path, LIMIT).map_err(fail)?;
        let bytes = bytes
            .ok_or_else(|| wrong(format!("expected a description of at most {LIMIT} bytes")))?;
        Self::parse(&bytes).map_err(wrong)
    }

    /// Parses a description. Errors name the field, or the line of invalid TOML.
    fn parse(bytes: &[u8]) -> Result<Self, String> {
        let document = document::toml(bytes).map_err(|e| e.to_string())?;
        let sections = |name: &str| document.get(name);
        if let Value::Map(entries) = &document {
            let known = ["model", "camera", "render"];
            let unknown = entries.iter().find(|(key, _)| !known.contains(&&**key));
            if let Some((key, _)) = unknown {
                let all = known.join(", ");
                let place = match ["gu", "vu", "su", "rit", "mvoxel", "system", "preset"]
                    .contains(&&**key)
                {
                    true => "; that is of a machine's file, which --config takes",
                    false => "",
                };
                return Err(format!(
                    "field `{}`: no such section: expected some of {all}{place}",
                    told(key)
                ));
            }
        }
        let model = sections("model").ok_or("section `[model]` is missing")?;
        let render = match sections("render") {
            Some(value) => RenderDescription::of(value)?,
            None => RenderDescription::default(),
        };
        Ok(Self {
            model: ModelDescription::of(model)?,
            camera: match sections("camera") {
                Some(value) => by_kind("camera", value)?,
                None => CameraDescription::Default,
            },
            render,
        })
    }
}

impl RenderDescription {
    pub(super) fn of(value: &Value) -> Result<Self, String> {
        let numbers: Vec<_> = NUMBERS.iter().map(Number::name).collect();
        let wrong = |e: Wrong| e.with_known(&numbers).under("render").to_string();
        let Value::Map(entries) = value else {
            return value.read().map_err(wrong);
        };
        let all = entries.iter().cloned();
        let (own, rest): (Vec<_>, Vec<_>) = all.partition(|(key, _)| numbers.contains(&&**key));
        let [own, rest] = [own, rest].map(|part| Value::Map(part.into()));
        Ok(Self {
            precision: own.read().map_err(wrong)?,
            ..rest.read().map_err(wrong)?
        })
    }
}

/// Reads a section whose `kind` selects its fields.
fn by_kind<T: DeserializeOwned>(section: &str, value: &Value) -> Result<T, String> {
    let (kind, fields) = kind_of(section, value)?;
    of_kind(section, &kind, fields)
}

/// The `kind` of a section, and its other fields.
fn kind_of(section: &str, value: &Value) -> Result<(String, Value), String> {
    let Value::Map(entries) = value else {
        let found = value.shown();
        return Err(format!(
            "field `{section}`: found {found}, expected a section with a `kind`"
        ));
    };
    let kind = match value.get("kind") {
        Some(Value::Text(kind)) => kind.to_string(),
        Some(other) => {
            let found = other.shown();
            return Err(format!(
                "field `{section}.kind`: found {found}, expected a text"
            ));
        }
        None => return Err(format!("field `{section}.kind`: it is missing")),
    };
    let fields = entries.iter().filter(|(key, _)| **key != *"kind").cloned();
    Ok((kind, Value::Map(fields.collect())))
}

fn of_kind<T: DeserializeOwned>(section: &str, kind: &str, fields: Value) -> Result<T, String> {
    let tagged = Value::Map([(kind.into(), fields)].into());
    tagged.read().map_err(|e| {
        let path = e.field();
        let field = match path.strip_prefix(kind) {
            Some(rest) => format!("{section}{rest}"),
            None => format!("{section}.kind"),
        };
        format!("field `{field}`: {}", e.problem())
    })
}
