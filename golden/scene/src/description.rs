//! Scene descriptions: TOML files that name a model, a camera and how to render.

use std::path::{Path, PathBuf};

use potamoi_base::precision::{NUMBERS, Number, Precision};
use potamoi_formats::document::{self, Value, Wrong};
use serde::de::{DeserializeOwned, Error as _};
use serde::{Deserialize, Deserializer};

use super::SceneError;
use potamoi_base::record::Fate::Honoured;
use potamoi_base::record::{Fate, Format, Key, told};
use potamoi_fields::{FieldFile, FileOptions, HashUnit, algorithms};
use potamoi_splats::Axes;

/// The largest description, in bytes.
const LIMIT: u64 = 1 << 20;

/// A `scene.toml`.
#[derive(Debug, Clone)]
pub(super) struct Description {
    /// What is shown.
    pub(super) model: ModelDescription,
    /// From where.
    pub(super) camera: CameraDescription,
    /// How.
    pub(super) render: RenderDescription,
}

/// Its fields.
pub(super) static DESCRIPTION: Format = Format {
    name: "Scene descriptions",
    files: "`.toml`. Every list has as many values as stand here, at every depth.",
    keys: &KEYS,
    others: Fate::Refused,
};

/// Those that are read here.
const OWN: [Key; 28] = [
    key(
        "model.kind",
        "builtin, splats, compact-3dgs, ngp, dvgo, tensorf or images",
    ),
    key("model.name", "of a built-in scene"),
    key("model.representation", "what a built-in scene is made into"),
    key(
        "model.path",
        "the file or folder, from the description's folder",
    ),
    key(
        "model.axes",
        "of splats and Compact-3DGS: where x, y and z of the file point, such as right-up-back",
    ),
    key(
        "model.hash_unit",
        "of Instant-NGP: vertex or mvoxel, as the file was fitted",
    ),
    key("model.depth", "of images: the folder of depths"),
    key(
        "model.depth_scale",
        "of images: units of the poses a unit of the depths, above 0",
    ),
    key(
        "model.void_above",
        "of images: depths above are void, above 0",
    ),
    key(
        "camera.kind",
        "orbit, opencv-json, transforms or colmap; not of images",
    ),
    key(
        "camera.path",
        "the file or folder, from the description's folder",
    ),
    key("camera.index", "which camera of the file, from 0"),
    key("camera.name", "of COLMAP: which image"),
    key("camera.width", "pixels a row, 1 to 16384"),
    key("camera.height", "rows, 1 to 16384"),
    key("camera.azimuth", "degrees"),
    key("camera.elevation", "degrees, between -89.9 and 89.9"),
    key("camera.distance", "1e-9 to 1e9"),
    key("camera.fov", "vertical field of view, 0.1 to 179 degrees"),
    key("camera.target", "three numbers from -1e9 to 1e9"),
    key("render.profile", "of splats: a renderer's rules"),
    key(
        "render.background",
        "linear RGB, three numbers; of images, too",
    ),
    key("render.order", "of splats: exact or approximate"),
    key(
        "render.group_tiles",
        "of splats: columns and rows of tiles, two whole numbers above 0",
    ),
    key(
        "render.group_side",
        "of voxels and fields: pixels a side of a ray group, above 0",
    ),
    key("render.halo", "of voxels and fields: shared or split"),
    key(
        "render.step",
        "of voxels: edges from sample to sample, 1/64 to 8",
    ),
    key(
        "render.antialiased",
        "of splats: as trained with antialiasing; what the file says unless given",
    ),
];

/// Those, and the numbers of [`Precision`].
static KEYS: [Key; OWN.len() + NUMBERS.len()] = {
    let mut keys = [OWN[0]; OWN.len() + NUMBERS.len()];
    let mut at = 0;
    while at < keys.len() {
        keys[at] = match at < OWN.len() {
            true => OWN[at],
            false => NUMBERS[at - OWN.len()].key,
        };
        at += 1;
    }
    keys
};

const fn key(name: &'static str, about: &'static str) -> Key {
    let fate = Honoured;
    Key { name, fate, about }
}

/// `[model]`.
#[derive(Debug, Clone, Deserialize)]
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
const MODEL_KINDS: [&str; 4] = ["builtin", "splats", "compact-3dgs", "images"];

/// What may be said of a field's file, all kinds together.
#[derive(Deserialize)]
struct FileDescription {
    path: PathBuf,
    hash_unit: Option<HashUnit>,
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
    /// Whether splats were trained with antialiasing; what their file says unless given.
    pub(super) antialiased: Option<bool>,
    /// Cut-offs, widths and levels.
    #[serde(skip)]
    pub(super) precision: Precision,
}

fn axes<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<Axes>, D::Error> {
    let text = String::deserialize(deserializer)?;
    text.parse().map(Some).map_err(D::Error::custom)
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
        let bytes = potamoi_base::files::read(path, LIMIT).map_err(fail)?;
        let bytes = bytes
            .ok_or_else(|| wrong(format!("expected a description of at most {LIMIT} bytes")))?;
        Self::parse(&bytes).map_err(wrong)
    }

    /// Errors name the field, or the line of what is no TOML.
    fn parse(bytes: &[u8]) -> Result<Self, String> {
        let document = document::toml(bytes).map_err(|e| e.to_string())?;
        let sections = |name: &str| document.get(name);
        if let Value::Map(entries) = &document {
            let known = ["model", "camera", "render"];
            let unknown = entries.iter().find(|(key, _)| !known.contains(&&**key));
            if let Some((key, _)) = unknown {
                let all = known.join(", ");
                return Err(format!(
                    "field `{}`: no such section: expected some of {all}",
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
    fn of(value: &Value) -> Result<Self, String> {
        let numbers: Vec<_> = NUMBERS.iter().map(Number::name).collect();
        let wrong = |e: Wrong| {
            let more = match e.problem().starts_with("no such field") {
                true => format!(", {}", numbers.join(", ")),
                false => String::new(),
            };
            format!("{}{more}", e.under("render"))
        };
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

impl ModelDescription {
    fn of(value: &Value) -> Result<Self, String> {
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

fn field_kinds() -> Vec<&'static str> {
    algorithms::files().map(|file| file.kind).collect()
}

/// Reads a section whose `kind` says which fields it has.
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

/// `[model]` of `kind = "images"`.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ImagesDescription {
    /// The folder, with `transforms.json` and the pictures that it names.
    pub(super) path: PathBuf,
    /// In it, the folder of the depths: OpenEXR files named as the pictures, the
    /// depth along the camera's axis in their red channel.
    #[serde(default = "depth_folder")]
    pub(super) depth: PathBuf,
    /// Units of the poses a unit of the depths.
    #[serde(default = "one")]
    pub(super) depth_scale: f64,
    /// Depths above this, in units of the poses, are void.
    #[serde(default = "infinity")]
    pub(super) void_above: f64,
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

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn kinds() -> [(&'static str, Vec<&'static str>); 2] {
        let models = [&MODEL_KINDS[..], &field_kinds()].concat();
        let cameras = vec!["opencv-json", "transforms", "colmap", "orbit"];
        [("model", models), ("camera", cameras)]
    }

    fn parsed(text: &str) -> Result<Description, String> {
        Description::parse(text.as_bytes())
    }

    /// The fields that the readers themselves name, against the rows of the table.
    #[test]
    fn every_field_has_a_row_and_no_other_is_read() {
        let mut fields = vec!["model.kind".to_owned(), "camera.kind".to_owned()];
        let mut refused = |section: &str, text: &str| {
            let error = parsed(text).unwrap_err();
            let start = format!("field `{section}.kin`: no such field here: expected ");
            let names = error.strip_prefix(&start).unwrap();
            let names = names.trim_start_matches("one of ").replace('`', "");
            fields.extend(names.split(", ").map(|name| format!("{section}.{name}")));
        };
        for (section, kinds) in kinds() {
            for kind in kinds {
                let other = match section {
                    "model" => "",
                    _ => "[model]\nkind = \"builtin\"\nname = \"moons\"\n",
                };
                let text = format!("{other}[{section}]\nkind = \"{kind}\"\nkin = 1\n");
                refused(section, &text);
            }
        }
        refused(
            "render",
            "[model]\nkind = \"builtin\"\nname = \"a\"\n[render]\nkin = 1\n",
        );
        fields.sort();
        fields.dedup();
        let mut rows: Vec<_> = DESCRIPTION.keys.iter().map(|row| row.name).collect();
        rows.sort_unstable();
        assert_eq!(fields, rows);
        let kinds = DESCRIPTION.row("model.kind").unwrap().about;
        for kind in [&MODEL_KINDS[..], &field_kinds()].concat() {
            assert!(kinds.contains(kind), "the row of model.kind has no {kind}");
        }
        let error = parsed("modell = 1").unwrap_err();
        assert!(
            error.starts_with("field `modell`: no such section"),
            "{error}"
        );
    }

    #[test]
    fn what_is_no_description_is_refused_by_field_in_words_of_our_own() {
        let model = "[model]\nkind = \"builtin\"\nname = \"moons\"\n";
        for (text, expected) in [
            ("", "section `[model]` is missing"),
            (
                "model = 3",
                "field `model`: found 3, expected a section with a `kind`",
            ),
            ("[model]\n", "field `model.kind`: it is missing"),
            (
                "[model]\nkind = 3",
                "field `model.kind`: found 3, expected a text",
            ),
            (
                "[model]\nkind = \"ply\"",
                "field `model.kind`: found \"ply\", expected one of builtin,",
            ),
            (
                "[model]\nkind = \"splats\"",
                "field `model.path`: it is missing",
            ),
            ("[model", "line 1, column 7: no TOML: "),
        ] {
            let error = parsed(text).unwrap_err();
            assert!(error.starts_with(expected), "{text}: {error}");
        }
        for (text, expected) in [
            (
                "background = [1, 0, 0, 9]",
                "render.background`: found 4 values, expected 3",
            ),
            (
                "background = [1, 0]",
                "render.background`: found 2 values, expected 3",
            ),
            (
                "group_tiles = [1, 2, 3]",
                "render.group_tiles`: found 3 values, expected 2",
            ),
            (
                "group_side = 1.5",
                "render.group_side`: found 1.5, expected a whole number",
            ),
            ("halo = 3", "render.halo`: found 3, expected a text"),
        ] {
            let error = parsed(&format!("{model}[render]\n{text}")).unwrap_err();
            assert!(
                error.starts_with(&format!("field `{expected}")),
                "{text}: {error}"
            );
        }
        let target = "[camera]\nkind = \"orbit\"\ntarget = [0, 0, 0, 1]";
        let error = parsed(&format!("{model}{target}")).unwrap_err();
        assert_eq!(error, "field `camera.target`: found 4 values, expected 3");
        let size = "[camera]\nkind = \"orbit\"\nwidth = 64.0\nheight = 4.8e1";
        let CameraDescription::Orbit { width, height, .. } =
            parsed(&format!("\u{feff}{model}{size}\r\n"))
                .unwrap()
                .camera
        else {
            unreachable!()
        };
        assert_eq!((width, height), (Some(64), Some(48)));
    }
}
