//! Camera paths as `transforms.json`: the convention of NeRF's synthetic
//! scenes (Mildenhall et al. 2020) and of Instant-NGP, in which a camera looks
//! along its -z axis, y up.

use std::path::{Path, PathBuf};

use glam::{DAffine3, DMat3, DVec2, DVec3};
use serde::Deserialize;
use thiserror::Error;

use crate::camera::Camera;

/// The largest file, in bytes.
const LIMIT: u64 = 1 << 26;
/// The most frames of a path.
const MAX_FRAMES: usize = 1 << 20;
/// How far a camera may be from the origin; poses past it lose their rotation to
/// rounding.
const FAR: f64 = 1e9;
/// Characters of what is wrong that are told.
const TOLD: usize = 300;

/// A camera path that cannot be used.
#[derive(Debug, Error)]
pub enum TransformsError {
    /// The file system refused.
    #[error("cannot read camera path {path}: {source}; name a readable JSON file")]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// It is not what it should be.
    #[error("camera path {path}: {problem}")]
    Wrong {
        /// The file.
        path: PathBuf,
        /// What is wrong and what was expected.
        problem: String,
    },
}

/// One frame of a path.
#[derive(Debug, Clone, PartialEq)]
pub struct PathFrame {
    /// Where it was seen from. Its size is the file's, or 800 x 800 where the
    /// file says none.
    pub camera: Camera,
    /// Its picture, as the file names it, from the file's folder.
    pub picture: PathBuf,
}

#[derive(Deserialize)]
struct Document {
    camera_angle_x: Option<f64>,
    camera_angle_y: Option<f64>,
    fl_x: Option<f64>,
    fl_y: Option<f64>,
    cx: Option<f64>,
    cy: Option<f64>,
    w: Option<f64>,
    h: Option<f64>,
    frames: Vec<Frame>,
}

#[derive(Deserialize)]
struct Frame {
    file_path: PathBuf,
    transform_matrix: Vec<Vec<f64>>,
}

/// A side where the file names none: that of NeRF's synthetic scenes.
const SIDE: f64 = 800.0;

/// Reads a path of at least one frame.
///
/// # Errors
/// The file cannot be read, is no camera path, or holds numbers that make no
/// camera.
pub fn read(path: &Path) -> Result<Vec<PathFrame>, TransformsError> {
    let fail = |source| TransformsError::Read {
        path: path.to_owned(),
        source,
    };
    let wrong = |problem: String| TransformsError::Wrong {
        path: path.to_owned(),
        problem,
    };
    let bytes = crate::files::read(path, LIMIT).map_err(fail)?;
    let bytes = bytes.ok_or_else(|| wrong(format!("expected at most {LIMIT} bytes")))?;
    parse(&bytes).map_err(wrong)
}

fn parse(bytes: &[u8]) -> Result<Vec<PathFrame>, String> {
    let mut reader = serde_json::Deserializer::from_slice(bytes);
    let document: Document = serde_path_to_error::deserialize(&mut reader).map_err(|e| {
        let problem = format!("field `{}`: {}", e.path(), e.inner());
        problem.chars().take(TOLD).collect::<String>()
    })?;
    if !(1..=MAX_FRAMES).contains(&document.frames.len()) {
        let count = document.frames.len();
        return Err(format!("{count} frames: expected 1 to {MAX_FRAMES}"));
    }
    let lens = lens(&document)?;
    let frames = document.frames.iter().enumerate();
    frames
        .map(|(i, frame)| {
            let world_to_camera =
                pose(frame).map_err(|e| format!("`frames[{i}].transform_matrix` {e}"))?;
            Ok(PathFrame {
                camera: Camera {
                    world_to_camera,
                    ..lens
                },
                picture: frame.file_path.clone(),
            })
        })
        .collect()
}

/// Size, focal lengths and principal point, all frames alike.
fn lens(document: &Document) -> Result<Camera, String> {
    let number = |field, value: Option<f64>, low: f64, high: f64| match value {
        Some(v) if !(low..=high).contains(&v) => {
            Err(format!("`{field}` is {v}: expected {low} to {high}"))
        }
        other => Ok(other),
    };
    let side = |field, value| number(field, value, 1.0, 16384.0);
    let (width, height) = (side("w", document.w)?, side("h", document.h)?);
    let width = width.unwrap_or(SIDE).round();
    let height = height.unwrap_or(width).round();
    let angle = |field, value| number(field, value, 1e-3, std::f64::consts::PI - 1e-3);
    let focal = |side: f64, angle: f64| side / 2.0 / (angle / 2.0).tan();
    let [ax, ay] = [
        angle("camera_angle_x", document.camera_angle_x)?,
        angle("camera_angle_y", document.camera_angle_y)?,
    ];
    let length = |field, value| number(field, value, 1e-3, 1e9);
    let fx = length("fl_x", document.fl_x)?.or(ax.map(|a| focal(width, a)));
    let fx = fx.ok_or("neither `camera_angle_x` nor `fl_x` is given")?;
    let fy = length("fl_y", document.fl_y)?.or(ay.map(|a| focal(height, a)));
    let centre = |field, value| number(field, value, -1e6, 1e6);
    Ok(Camera {
        width: width as u32,
        height: height as u32,
        // Square pixels unless the file says otherwise.
        focal: DVec2::new(fx, fy.unwrap_or(fx)),
        centre: DVec2::new(
            centre("cx", document.cx)?.unwrap_or(width / 2.0),
            centre("cy", document.cy)?.unwrap_or(height / 2.0),
        ),
        world_to_camera: DAffine3::IDENTITY,
    })
}

/// World to camera, looking along +z with y down.
fn pose(frame: &Frame) -> Result<DAffine3, String> {
    let rows = &frame.transform_matrix;
    let shaped = (3..=4).contains(&rows.len()) && rows.iter().all(|r| r.len() == 4);
    if !shaped {
        let sizes: Vec<_> = rows.iter().map(Vec::len).collect();
        return Err(format!(
            "has rows of {sizes:?}: expected 3 or 4 of 4 numbers"
        ));
    }
    let column = |c: usize| DVec3::new(rows[0][c], rows[1][c], rows[2][c]);
    let rotation = DMat3::from_cols(column(0), -column(1), -column(2));
    let off = rotation * rotation.transpose() - DMat3::IDENTITY;
    let rigid = off.to_cols_array().iter().all(|v| v.abs() < 1e-3);
    if !(rigid && rotation.determinant() > 0.0) {
        return Err("is no rotation and translation".to_owned());
    }
    if !column(3).abs().cmple(DVec3::splat(FAR)).all() {
        return Err(format!("is at {}: expected -1e9 to 1e9", column(3)));
    }
    // Rounding of the file is taken out, so that the inverse is exact.
    let turn = glam::DQuat::from_mat3(&rotation).normalize();
    let to_world = DAffine3::from_rotation_translation(turn, column(3));
    Ok(to_world.inverse())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::super::fuzz::{damaged, damages, sound};
    use super::*;

    const FRAME: &str = r#"{"file_path": "a/r_0",
        "transform_matrix": [[1,0,0,0],[0,0,-1,-4],[0,1,0,0],[0,0,0,1]]}"#;

    /// From (0, -4, 0) along +y, z up.
    #[test]
    fn the_camera_looks_along_minus_z_with_y_up() {
        let text = format!(r#"{{"camera_angle_x": 0.8, "frames": [{FRAME}]}}"#);
        let frame = &parse(text.as_bytes()).unwrap()[0];
        let camera = &frame.camera;
        assert!((camera.position() - DVec3::new(0.0, -4.0, 0.0)).length() < 1e-12);
        let to = |p: DVec3| camera.world_to_camera.transform_vector3(p);
        assert!((to(DVec3::Y) - DVec3::Z).length() < 1e-12, "ahead");
        assert!((to(DVec3::Z) - DVec3::NEG_Y).length() < 1e-12, "up");
        assert_eq!((camera.width, camera.height), (800, 800));
        assert!((camera.focal.x - 400.0 / 0.4f64.tan()).abs() < 1e-9);
        assert_eq!(frame.picture, Path::new("a/r_0"));
    }

    #[test]
    fn sizes_and_lenses_of_the_file_are_taken() {
        let text = format!(
            r#"{{"w": 640, "h": 480, "fl_x": 500, "fl_y": 510, "cx": 300, "cy": 250,
                "aabb_scale": 4, "frames": [{FRAME}, {FRAME}]}}"#
        );
        let frames = parse(text.as_bytes()).unwrap();
        let camera = frames[1].camera;
        assert_eq!((camera.width, camera.height), (640, 480));
        assert_eq!(camera.focal, DVec2::new(500.0, 510.0));
        assert_eq!(camera.centre, DVec2::new(300.0, 250.0));
    }

    #[test]
    fn what_is_no_path_is_refused_by_field() {
        let bent = FRAME.replace("[1,0,0,0]", "[2,0,0,0]");
        let mirrored = FRAME.replace("[1,0,0,0]", "[-1,0,0,0]");
        let short = FRAME.replace("[0,0,-1,-4],", "");
        let narrow = FRAME.replace("[0,0,-1,-4]", "[0,0,-1]");
        for (text, expected) in [
            ("[]".to_owned(), "field"),
            (r#"{"camera_angle_x": 1}"#.to_owned(), "frames"),
            (
                r#"{"camera_angle_x": 1, "frames": []}"#.to_owned(),
                "0 frames",
            ),
            (format!(r#"{{"frames": [{FRAME}]}}"#), "neither"),
            (
                format!(r#"{{"camera_angle_x": 4, "frames": [{FRAME}]}}"#),
                "`camera_angle_x` is 4",
            ),
            (
                format!(r#"{{"fl_x": 9, "w": 0, "frames": [{FRAME}]}}"#),
                "`w` is 0",
            ),
            (format!(r#"{{"fl_x": 9, "frames": [{bent}]}}"#), "frames[0]"),
            (
                format!(r#"{{"fl_x": 9, "frames": [{mirrored}]}}"#),
                "no rotation",
            ),
            (
                format!(r#"{{"fl_x": 9, "frames": [{FRAME}, {short}]}}"#),
                "no rotation",
            ),
            (format!(r#"{{"fl_x": 9, "frames": [{narrow}]}}"#), "rows of"),
            (format!(r#"{{"fl_x": "9", "frames": [{FRAME}]}}"#), "fl_x"),
        ] {
            let error = parse(text.as_bytes()).unwrap_err();
            assert!(error.contains(expected), "{text}: {error}");
        }
    }

    #[test]
    fn cameras_lie_where_numbers_are_exact() {
        let far = FRAME.replace("-1,-4]", "-1,1e10]");
        let text = format!(r#"{{"fl_x": 9, "frames": [{far}]}}"#);
        let error = parse(text.as_bytes()).unwrap_err();
        assert!(error.contains("expected -1e9 to 1e9"), "{error}");
        let long = format!(r#"{{"fl_x": "{}", "frames": []}}"#, "9".repeat(10_000));
        assert!(parse(long.as_bytes()).unwrap_err().len() < 1000);
    }

    proptest::proptest! {
        #![proptest_config(proptest::prelude::ProptestConfig::with_cases(600))]

        /// Whatever stands in a file, it is a path or one clear error.
        #[test]
        fn damaged_files_are_read_or_refused(harm in damages()) {
            let text = format!(
                r#"{{"w": 640, "h": 480, "fl_x": 500, "fl_y": 510.5, "cx": 300, "cy": 250,
                    "camera_angle_x": 0.7, "camera_angle_y": 0.6, "aabb_scale": 4,
                    "frames": [{FRAME}, {FRAME}]}}"#
            );
            let folder = tempfile::tempdir().unwrap();
            let path = folder.path().join("transforms.json");
            std::fs::write(&path, damaged(text.as_bytes(), &harm)).unwrap();
            sound(read(&path), &path)?;
        }
    }
}
