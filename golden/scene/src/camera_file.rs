//! Camera files of splat scenes: the `cameras.json` of 3D Gaussian splatting,
//! or one such camera alone, in the OpenCV convention.
//!
//! A camera holds `width`, `height`, `fx`, `fy` in pixels, `position`, and `rotation` (camera to
//! world, by rows). `cx` and `cy` default to the centre, `background` (linear RGB) to black. Other
//! fields are listed as unused, and refused if they describe a lens that is not a pinhole.

use std::path::{Path, PathBuf};

use glam::{DAffine3, DMat3, DVec2, DVec3};
use potamoi_formats::document::{self, Value};
use serde::Deserialize;
use thiserror::Error;

use super::lens_keys::{self, with_strange_lenses};
use potamoi_base::camera::Camera;
use potamoi_base::file_keys::Fate::{Honoured, Listed};
use potamoi_base::file_keys::{FileKeys, Format, Notes, key};

/// The largest camera file, in bytes.
const LIMIT: u64 = 1 << 26;
/// Maximum deviation of `rotation` from orthonormal: files hold about 7 digits.
const ROTATION_TOLERANCE: f64 = 1e-4;

/// The expected content, for messages.
const CAMERA: &str = "expected a camera, or a list of them, with width, height, fx, fy, position and \
                      rotation";
/// Names of the axis convention of these cameras.
const AXES: [&str; 4] = ["OPENCV", "COLMAP", "RDF", "CV"];

/// Keys of the format.
pub(super) static CAMERAS: Format = Format {
    name: "cameras.json",
    files: "`--camera` and `[camera] kind = \"opencv-json\"`: the cameras that 3D Gaussian splatting \
            writes, or one of them",
    keys: with_strange_lenses![
        key("width", Honoured, "pixels a row"),
        key("height", Honoured, "rows"),
        key("fx", Honoured, "focal length in pixels"),
        key("fy", Honoured, "the same of columns"),
        key(
            "cx",
            Honoured,
            "principal point in pixels; the middle unless given",
        ),
        key("cy", Honoured, "the same of columns"),
        key("position", Honoured, "where the camera is"),
        key("rotation", Honoured, "camera to world, by rows"),
        key(
            "background",
            Honoured,
            "linear RGB behind everything; black unless given",
        ),
        key("id", Listed, "the order of the file counts"),
        key("img_name", Listed, "the picture that the camera took"),
        key("*model*", Refused, crate::lens_keys::PINHOLE),
        key("rolling_shutter*", Refused, "a frame is seen at one moment"),
    ],
    others: Listed,
};

/// A camera with its background.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FileCamera {
    /// The camera.
    pub camera: Camera,
    /// Linear RGB.
    pub background: [f32; 3],
}

/// A camera file that is invalid or not supported.
#[derive(Debug, Error)]
pub enum CameraFileError {
    /// The file system returned an error.
    #[error("cannot read cameras {path}: {source}; name a readable JSON file")]
    Read {
        /// The file.
        path: PathBuf,
        /// The error of the file system.
        source: std::io::Error,
    },
    /// The file is larger than the limit.
    #[error("{path}: expected a camera file of at most {LIMIT} bytes")]
    TooLarge {
        /// The file.
        path: PathBuf,
    },
    /// The file is not JSON, or a field is missing or of the wrong kind.
    #[error("{origin}: {message}")]
    Parse {
        /// The file.
        origin: String,
        /// The problem.
        message: String,
    },
    /// The list has no cameras.
    #[error("{origin}: no camera: expected at least one")]
    Empty {
        /// The file.
        origin: String,
    },
    /// A value is not valid for a camera.
    #[error("{origin}: camera {index}: {field} is {value}: expected {expected}")]
    Value {
        /// The file.
        origin: String,
        /// Index of the camera, from 0.
        index: usize,
        /// The field.
        field: &'static str,
        /// The value.
        value: String,
        /// Allowed values.
        expected: &'static str,
    },
}

struct Entry {
    width: u32,
    height: u32,
    fx: f64,
    fy: f64,
    cx: Option<f64>,
    cy: Option<f64>,
    position: [f64; 3],
    rotation: [[f64; 3]; 3],
    background: Option<[f32; 3]>,
}

/// Reads the cameras of a file, at least one, in the file's order. Unused fields are added to
/// `notes`.
///
/// # Errors
/// The file cannot be read, is not a camera file, or holds values that are not valid for a camera.
pub fn read(path: &Path, notes: &mut Notes) -> Result<Vec<FileCamera>, CameraFileError> {
    let fail = |source| CameraFileError::Read {
        path: path.to_owned(),
        source,
    };
    let bytes = potamoi_base::files::read(path, LIMIT).map_err(fail)?;
    let bytes = bytes.ok_or_else(|| CameraFileError::TooLarge {
        path: path.to_owned(),
    })?;
    parse(&bytes, &path.display().to_string(), notes)
}

/// Reads cameras from JSON; `origin` names it in errors.
///
/// # Errors
/// Those of [`read`].
pub fn parse(
    json: &[u8],
    origin: &str,
    notes: &mut Notes,
) -> Result<Vec<FileCamera>, CameraFileError> {
    let wrong = |message: String| CameraFileError::Parse {
        origin: origin.to_owned(),
        message,
    };
    let document = document::json(json).map_err(|e| wrong(format!("{e}; {CAMERA}")))?;
    let entries = match document {
        Value::List(values) => values.into_vec(),
        one => vec![one],
    };
    let entries = entries.into_iter().enumerate().map(|(i, value)| {
        Entry::read(value, notes).map_err(|message| wrong(format!("camera {i}: {message}")))
    });
    let entries: Vec<Entry> = entries.collect::<Result<_, _>>()?;
    if entries.is_empty() {
        return Err(CameraFileError::Empty {
            origin: origin.to_owned(),
        });
    }
    entries
        .iter()
        .enumerate()
        .map(|(index, e)| {
            e.check()
                .map_err(|(field, value, expected)| CameraFileError::Value {
                    origin: origin.to_owned(),
                    index,
                    field,
                    value,
                    expected,
                })
        })
        .collect()
}

/// The value of an optional field.
fn optional<T: for<'a> Deserialize<'a>>(
    record: &mut FileKeys<Value>,
    name: &str,
) -> Result<Option<T>, String> {
    let Some(value) = record.take(name).filter(|value| *value != Value::Null) else {
        return Ok(None);
    };
    let read = value.read().map_err(|e| e.under(name).to_string());
    read.map(Some)
}

fn required<T: for<'a> Deserialize<'a>>(
    record: &mut FileKeys<Value>,
    name: &str,
) -> Result<T, String> {
    optional(record, name)?.ok_or_else(|| format!("field `{name}`: it is missing"))
}

impl Entry {
    fn read(value: Value, notes: &mut Notes) -> Result<Self, String> {
        let Value::Map(entries) = value else {
            let found = value.shown();
            return Err(format!(
                "found {found}, expected named values, `{{...}}`; {CAMERA}"
            ));
        };
        for (key, value) in &entries {
            lens_keys::within(&CAMERAS, key, value, &AXES).map_err(|e| e.to_string())?;
        }
        let entries = lens_keys::telling(&CAMERAS, entries.into_vec(), &AXES);
        let mut record = FileKeys::new(&CAMERAS, entries.map(|(key, value)| (key.into(), value)));
        let from = &mut record;
        let entry = Self {
            width: required(from, "width")?,
            height: required(from, "height")?,
            fx: required(from, "fx")?,
            fy: required(from, "fy")?,
            cx: optional(from, "cx")?,
            cy: optional(from, "cy")?,
            position: required(from, "position")?,
            rotation: required(from, "rotation")?,
            background: optional(from, "background")?,
        };
        record
            .finish_valued(notes, |value| Some(value.shown()))
            .map_err(|e| e.to_string())?;
        Ok(entry)
    }

    fn check(&self) -> Result<FileCamera, (&'static str, String, &'static str)> {
        for (field, value) in [("width", self.width), ("height", self.height)] {
            if !(1..=32_768).contains(&value) {
                return Err((field, value.to_string(), "1 to 32768 pixels"));
            }
        }
        for (field, value) in [("fx", self.fx), ("fy", self.fy)] {
            if !(1e-3..=1e7).contains(&value) {
                return Err((field, format!("{value:?}"), "0.001 to 10000000 pixels"));
            }
        }
        for (field, value) in [("cx", self.cx), ("cy", self.cy)] {
            if let Some(value) = value.filter(|v| v.abs() > 1e7) {
                return Err((
                    field,
                    format!("{value:?}"),
                    "at most 10000000 pixels from 0",
                ));
            }
        }
        if self.position.iter().any(|v| v.abs() > 1e38) {
            let value = format!("{:?}", self.position);
            return Err(("position", value, "coordinates of at most 1e38"));
        }
        let [r0, r1, r2] = self.rotation.map(DVec3::from);
        let to_world = DMat3::from_cols(r0, r1, r2).transpose();
        let off = to_world * to_world.transpose() - DMat3::IDENTITY;
        let orthonormal = off
            .to_cols_array()
            .iter()
            .all(|v| v.abs() < ROTATION_TOLERANCE);
        if !orthonormal || to_world.determinant() < 0.0 {
            return Err((
                "rotation",
                format!("{:?}", self.rotation),
                "rows of a right-handed orthonormal matrix",
            ));
        }
        let position = DVec3::from(self.position);
        let to_camera = to_world.transpose();
        let half = DVec2::new(f64::from(self.width), f64::from(self.height)) / 2.0;
        Ok(FileCamera {
            camera: Camera {
                width: self.width,
                height: self.height,
                focal: DVec2::new(self.fx, self.fy),
                centre: DVec2::new(self.cx.unwrap_or(half.x), self.cy.unwrap_or(half.y)),
                world_to_camera: DAffine3::from_mat3_translation(to_camera, to_camera * -position),
            },
            background: self.background.unwrap_or_default(),
        })
    }
}

/// The indices of a file's cameras, for messages.
pub(super) fn indices(count: usize, file: &Path) -> String {
    match count {
        1 => format!("0, the one camera of {}", file.display()),
        count => format!(
            "0 to {}, as {} has",
            count.saturating_sub(1),
            file.display()
        ),
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use potamoi_base::file_keys::Fate;

    const ONE: &str = r#"{"id": 3, "width": 40, "height": 20, "fx": 30.5, "fy": 31,
        "position": [1, 2, 3], "rotation": [[0, 0, 1], [0, 1, 0], [-1, 0, 0]]}"#;

    fn parsed(text: &str) -> Result<Vec<FileCamera>, CameraFileError> {
        parse(text.as_bytes(), "c.json", &mut Notes::default())
    }

    /// Every row of the table is met, and a key without one.
    #[test]
    fn every_key_is_honoured_refused_or_listed() {
        let rows = CAMERAS.keys.iter().map(|row| (row.name, row.fate));
        for (name, fate) in rows.chain([("a key that nobody knows", Listed)]) {
            let key = name.replace('*', "_");
            if fate == Honoured {
                continue;
            }
            let with = |value: &str| {
                let text = ONE.replacen("\"id\": 3", &format!("\"{key}\": {value}"), 1);
                let mut notes = Notes::default();
                let read = parse(text.as_bytes(), "c.json", &mut notes);
                let listed = notes.not_used() == [&key[..]];
                (
                    read.is_err_and(|e| e.to_string().contains(&format!("`{key}`"))),
                    listed,
                )
            };
            assert_eq!(with("11"), (fate == Fate::Refused, fate == Listed), "{key}");
            assert_eq!(with("0"), (false, fate == Listed), "{key}");
        }
    }

    /// Lenses and axes that are told by a name, or deeper in the file.
    #[test]
    fn what_changes_the_camera_is_refused_wherever_it_stands() {
        let with = |more: &str| parsed(&ONE.replacen("\"id\": 3", more, 1));
        for (harm, key) in [
            (r#""camera_type": "fisheye""#, "camera_type"),
            (r#""projection": "equirectangular""#, "projection"),
            (r#""lens_type": "FISHEYE""#, "lens_type"),
            (r#""model": "OPENCV_FISHEYE""#, "model"),
            (r#""convention": "OpenGL""#, "convention"),
            (r#""coordinate_system": "RUB""#, "coordinate_system"),
            (r#""K": [[1, 0, 0], [0, 1, 0], [0, 0, 1]]"#, "K"),
            (r#""crop": [1, 2, 3, 4]"#, "crop"),
            (r#""pixel_aspect_ratio": 2"#, "pixel_aspect_ratio"),
            (r#""lens": {"k1": 0.1}"#, "lens.k1"),
            (r#""camera": {"model": "FISHEYE"}"#, "camera.model"),
            (r#""metadata": [{"a": {"k7": 1}}]"#, "metadata.a.k7"),
        ] {
            let error = with(harm).unwrap_err().to_string();
            assert!(error.contains(&format!("`{key}` cannot be")), "{error}");
            assert!(!error.contains("expected a camera, or a list"), "{error}");
        }
        for none in [
            r#""camera_type": "perspective""#,
            r#""model": "OPENCV""#,
            r#""convention": "OpenCV (x right, y down)""#,
            r#""lens": {"k1": 0, "model": "pinhole"}"#,
            r#""pixel_aspect_ratio": 1.0"#,
        ] {
            assert!(with(none).is_ok(), "{none}");
        }
    }

    #[test]
    fn numbers_and_marks_are_read_as_others_do() {
        let sound = parsed(ONE).unwrap();
        let floats = ONE.replace("40", "40.0").replace("20,", "2e1,");
        assert_eq!(parsed(&floats).unwrap(), sound);
        assert_eq!(parsed(&format!("\u{feff}{ONE}\r\n")).unwrap(), sound);
    }

    #[test]
    fn a_camera_alone_and_a_list_are_read() {
        let one = parsed(ONE).unwrap();
        let many = parsed(&format!("[{ONE}, {ONE}]")).unwrap();
        assert_eq!(many, [one[0], one[0]]);
        let c = one[0].camera;
        assert_eq!(c.centre, DVec2::new(20.0, 10.0));
        assert!((c.position() - DVec3::new(1.0, 2.0, 3.0)).length() < 1e-12);
        // The third column of camera-to-world is the view direction.
        let (_, forward) = Camera {
            centre: DVec2::splat(0.5),
            ..c
        }
        .ray(0, 0);
        assert!((forward - DVec3::X).length() < 1e-12, "{forward}");
        assert_eq!(one[0].background, [0.0; 3]);
    }

    #[test]
    fn what_makes_no_camera_is_refused_by_field() {
        let refused = |from: &str, to: &str, expected: &str| {
            let text = parsed(&ONE.replace(from, to)).unwrap_err().to_string();
            assert!(text.contains("c.json") && text.contains(expected), "{text}");
        };
        refused("\"fx\": 30.5, ", "", "camera 0: field `fx`: it is missing");
        refused("30.5", "0", "fx is 0");
        refused("30.5", "-1e999", "c.json");
        refused("30.5", "1e300", "fx is 1e300");
        refused(
            "[1, 2, 3]",
            "[1e300, 2, 3]",
            "position is [1e300, 2.0, 3.0]",
        );
        refused("\"fx\"", "\"cx\": -1e300, \"fx\"", "cx is -1e300");
        refused("\"width\": 40", "\"width\": 0", "width is 0");
        refused("\"width\": 40", "\"width\": -4", "-4");
        refused("[0, 1, 0]", "[0, 2, 0]", "rotation");
        refused("[0, 1, 0]", "[0, -1, 0]", "rotation");
        refused(
            "[0, 1, 0]",
            "[0, 1]",
            "`rotation[1]`: found 2 values, expected 3",
        );
        refused(
            "[1, 2, 3]",
            "[1, 2, 3, 4]",
            "`position`: found 4 values, expected 3",
        );
        refused("[0, 1, 0]", "[0, 0, 0]", "rotation");
        refused("40", "40.5", "`width`: found 40.5, expected a whole number");
        refused("\"id\"", "\"fx\": 1, \"id\"", "it stands twice");
        refused("\"width\"", "width", "c.json");
        assert!(parsed("[]").unwrap_err().to_string().contains("no camera"));
        assert!(parsed("").is_err() && parsed("7").is_err() && parsed("[7]").is_err());
    }

    #[test]
    fn files_that_cannot_be_read_are_refused() {
        let text = read(Path::new("no/camera.json"), &mut Notes::default())
            .unwrap_err()
            .to_string();
        assert!(text.contains("no/camera.json"), "{text}");
        assert!(read(Path::new(env!("CARGO_MANIFEST_DIR")), &mut Notes::default()).is_err());
    }
}
