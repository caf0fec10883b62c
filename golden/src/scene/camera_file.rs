//! Camera files of splat scenes: the `cameras.json` of 3D Gaussian splatting,
//! or one such camera alone, in the OpenCV convention.
//!
//! A camera holds `width`, `height`, `fx`, `fy` in pixels, `position`, and
//! `rotation` (camera to world, by rows). `cx` and `cy` default to the centre;
//! `background` (linear RGB) to black. Other fields are ignored.

use std::path::{Path, PathBuf};

use glam::{DAffine3, DMat3, DVec2, DVec3};
use serde::Deserialize;
use thiserror::Error;

use crate::camera::Camera;

/// The largest camera file, in bytes.
const LIMIT: u64 = 1 << 26;
/// How far `rotation` may be from orthonormal: files hold some 7 digits.
const ROTATION_TOLERANCE: f64 = 1e-4;

/// A camera and what is behind everything that it sees.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FileCamera {
    /// The camera.
    pub camera: Camera,
    /// Linear RGB.
    pub background: [f32; 3],
}

/// A camera file that cannot be used.
#[derive(Debug, Error)]
pub enum CameraFileError {
    /// The file system refused.
    #[error("cannot read cameras {path}: {source}; name a readable JSON file")]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// Larger than any camera file.
    #[error("{path}: expected a camera file of at most {LIMIT} bytes")]
    TooLarge {
        /// The file.
        path: PathBuf,
    },
    /// Not JSON, or a field is missing or of the wrong kind.
    #[error(
        "{origin}: {message}; expected a camera, or a list of them, with \
         width, height, fx, fy, position and rotation"
    )]
    Parse {
        /// The file.
        origin: String,
        /// What is wrong.
        message: String,
    },
    /// A list without cameras.
    #[error("{origin}: no camera: expected at least one")]
    Empty {
        /// The file.
        origin: String,
    },
    /// A value that makes no camera.
    #[error("{origin}: camera {index}: {field} is {value}: expected {expected}")]
    Value {
        /// The file.
        origin: String,
        /// Which camera, from 0.
        index: usize,
        /// The field.
        field: &'static str,
        /// The value.
        value: String,
        /// What would be right.
        expected: &'static str,
    },
}

#[derive(Deserialize)]
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

/// Reads the cameras of a file, at least one.
///
/// # Errors
/// The file cannot be read, is no camera file, or holds values that make no
/// camera.
pub fn read(path: &Path) -> Result<Vec<FileCamera>, CameraFileError> {
    let fail = |source| CameraFileError::Read {
        path: path.to_owned(),
        source,
    };
    let bytes = crate::files::read(path, LIMIT).map_err(fail)?;
    let bytes = bytes.ok_or_else(|| CameraFileError::TooLarge {
        path: path.to_owned(),
    })?;
    let text = String::from_utf8(bytes).map_err(|e| fail(std::io::Error::other(e)))?;
    parse(&text, &path.display().to_string())
}

/// Reads cameras from text; `origin` names it in errors.
///
/// # Errors
/// As [`read`].
pub fn parse(text: &str, origin: &str) -> Result<Vec<FileCamera>, CameraFileError> {
    let wrong = |e: serde_json::Error| CameraFileError::Parse {
        origin: origin.to_owned(),
        message: e.to_string(),
    };
    // The shape is found first, so that errors name the field.
    let value: serde_json::Value = serde_json::from_str(text).map_err(wrong)?;
    let entries: Vec<Entry> = if value.is_array() {
        serde_json::from_value(value).map_err(wrong)?
    } else {
        vec![serde_json::from_value(value).map_err(wrong)?]
    };
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

impl Entry {
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

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    const ONE: &str = r#"{"id": 3, "width": 40, "height": 20, "fx": 30.5, "fy": 31,
        "position": [1, 2, 3], "rotation": [[0, 0, 1], [0, 1, 0], [-1, 0, 0]]}"#;

    #[test]
    fn a_camera_alone_and_a_list_are_read() {
        let one = parse(ONE, "c.json").unwrap();
        let many = parse(&format!("[{ONE}, {ONE}]"), "c.json").unwrap();
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
            let text = parse(&ONE.replace(from, to), "c.json")
                .unwrap_err()
                .to_string();
            assert!(text.contains("c.json") && text.contains(expected), "{text}");
        };
        refused("\"fx\": 30.5, ", "", "missing field `fx`");
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
        refused("[0, 1, 0]", "[0, 1]", "length");
        refused("\"width\"", "width", "c.json");
        assert!(
            parse("[]", "c.json")
                .unwrap_err()
                .to_string()
                .contains("no camera")
        );
        assert!(parse("", "c.json").is_err() && parse("7", "c.json").is_err());
    }

    #[test]
    fn files_that_cannot_be_read_are_refused() {
        let text = read(Path::new("no/camera.json")).unwrap_err().to_string();
        assert!(text.contains("no/camera.json"), "{text}");
        assert!(read(Path::new(env!("CARGO_MANIFEST_DIR"))).is_err());
    }
}
