//! Camera paths as `transforms.json`, in the convention of NeRF's synthetic scenes (Mildenhall et
//! al. 2020), Instant-NGP and Nerfstudio: a camera looks along its -z axis, y up.

mod keys;
mod lens;
#[cfg(test)]
mod tests;

use std::path::{Path, PathBuf};

use glam::{DAffine3, DMat3, DVec3};
use potamoi_formats::document::{self, Value};
use thiserror::Error;

use super::lens_keys;
use potamoi_base::camera::Camera;
use potamoi_base::file_keys::{FileKeys, Format, Notes};

pub(super) use keys::{FRAME, PATH};
use lens::Lens;

/// Names of the axis convention of these cameras.
const AXES: [&str; 6] = ["OPENGL", "BLENDER", "NERF", "NERFSTUDIO", "RUB", "GL"];
/// The largest file, in bytes.
const LIMIT: u64 = 1 << 26;
/// Maximum number of frames in a path.
const MAX_FRAMES: usize = 1 << 20;
/// Largest distance of a camera from the origin. Beyond it, poses lose their rotation to rounding.
const FAR: f64 = 1e9;
/// Maximum deviation of a pose from a rotation: files hold few digits.
const ROUNDING: f64 = 1e-3;

/// A camera path that is invalid or not supported.
#[derive(Debug, Error)]
pub enum TransformsError {
    /// The file system returned an error.
    #[error("cannot read camera path {path}: {source}; name a readable JSON file")]
    Read {
        /// The file.
        path: PathBuf,
        /// The error of the file system.
        source: std::io::Error,
    },
    /// The content is invalid.
    #[error("camera path {path}: {problem}")]
    Wrong {
        /// The file.
        path: PathBuf,
        /// The problem and the expected content.
        problem: String,
    },
}

/// One frame of a path.
#[derive(Debug, Clone, PartialEq)]
pub struct PathFrame {
    /// The camera, with the size of the picture.
    pub camera: Camera,
    /// The picture as named in the file, relative to the file's folder.
    pub picture: PathBuf,
}

/// Reads a path of at least one frame, in the file's order. The values of a frame have precedence
/// over those for all frames. Unused parts and assumptions are added to `notes`.
///
/// # Errors
/// The file cannot be read, is not a camera path, holds values that are not valid for a camera, or
/// has a lens that is not a pinhole.
pub fn read(path: &Path, notes: &mut Notes) -> Result<Vec<PathFrame>, TransformsError> {
    let fail = |source| TransformsError::Read {
        path: path.to_owned(),
        source,
    };
    let wrong = |problem: String| TransformsError::Wrong {
        path: path.to_owned(),
        problem,
    };
    let bytes = potamoi_base::files::read(path, LIMIT).map_err(fail)?;
    let bytes = bytes.ok_or_else(|| wrong(format!("expected at most {LIMIT} bytes")))?;
    parse(&bytes, notes).map_err(wrong)
}

fn parse(bytes: &[u8], notes: &mut Notes) -> Result<Vec<PathFrame>, String> {
    let document = document::json(bytes).map_err(|e| e.to_string())?;
    let mut record = record(&PATH, document)?;
    let viewer = record.has("camera_path");
    let frames = record.take("frames").ok_or(match viewer {
        true => {
            "`frames` is missing, and `camera_path` is there: a camera path of Nerfstudio's viewer, \
             which is not read; expected a transforms.json"
        }
        false => "`frames` is missing: expected a transforms.json, with a list of frames",
    })?;
    let Value::List(frames) = frames else {
        let found = frames.shown();
        return Err(format!("`frames` is {found}: expected a list of frames"));
    };
    let count = frames.len();
    if !(1..=MAX_FRAMES).contains(&count) {
        return Err(format!("{count} frames: expected 1 to {MAX_FRAMES}"));
    }
    let lens = Lens::take(&mut record)?;
    record
        .finish_valued(notes, |value| Some(value.shown()))
        .map_err(|e| e.to_string())?;
    let frames = frames.into_vec().into_iter().enumerate();
    let frames: Result<Vec<_>, String> = frames
        .map(|(i, value)| frame(value, &lens, notes).map_err(|e| format!("frames[{i}]: {e}")))
        .collect();
    let frames = frames?;
    if !is_ordered(&frames) {
        notes.assume("order of frames: the file's, which is not that of their names");
    }
    Ok(frames)
}

fn record(format: &'static Format, value: Value) -> Result<FileKeys<Value>, String> {
    let Value::Map(entries) = value else {
        let found = value.shown();
        return Err(format!("found {found}: expected named values, `{{...}}`"));
    };
    // Frames have a table of their own.
    for (key, value) in entries.iter().filter(|(key, _)| &**key != "frames") {
        lens_keys::within(format, key, value, &AXES).map_err(|e| e.to_string())?;
    }
    let entries = lens_keys::telling(format, entries.into_vec(), &AXES);
    let record = FileKeys::new(format, entries.map(|(key, value)| (key.into(), value)));
    Ok(record)
}

fn frame(value: Value, common: &Lens, notes: &mut Notes) -> Result<PathFrame, String> {
    let mut record = record(&FRAME, value)?;
    let picture = record.take("file_path").ok_or("`file_path` is missing")?;
    let Some(picture) = picture.text().map(PathBuf::from) else {
        let found = picture.shown();
        return Err(format!("`file_path` is {found}: expected a file's name"));
    };
    let matrix = record.take("transform_matrix");
    let matrix = matrix.ok_or("`transform_matrix` is missing")?;
    let world_to_camera = pose(&matrix).map_err(|e| format!("`transform_matrix` {e}"))?;
    let lens = Lens::take(&mut record)?.over(common);
    let mut own = Notes::default();
    record
        .finish_valued(&mut own, |value| Some(value.shown()))
        .map_err(|e| e.to_string())?;
    notes.extend(own.under("frames[]."));
    let camera = Camera {
        world_to_camera,
        ..lens.camera(notes)?
    };
    Ok(PathFrame { camera, picture })
}

/// Whether pictures are named in the order of frames, by numbers or alphabetically.
fn is_ordered(frames: &[PathFrame]) -> bool {
    let names = || frames.iter().map(|f| f.picture.to_string_lossy());
    let numbered = |name: &str| -> Vec<(String, u64)> {
        let mut parts = vec![];
        let mut rest = name;
        while !rest.is_empty() {
            let digits = rest
                .find(|c: char| c.is_ascii_digit())
                .unwrap_or(rest.len());
            let (text, behind) = rest.split_at(digits);
            let end = behind.find(|c: char| !c.is_ascii_digit());
            let (number, behind) = behind.split_at(end.unwrap_or(behind.len()));
            parts.push((text.to_owned(), number.parse().unwrap_or(u64::MAX)));
            rest = behind;
        }
        parts
    };
    names().is_sorted() || names().map(|name| numbered(&name)).is_sorted()
}

/// The world-to-camera transform, looking along +z with y down.
fn pose(matrix: &Value) -> Result<DAffine3, String> {
    let rows = matrix.list().unwrap_or_default();
    let numbers = |row: &Value| -> Option<[f64; 4]> {
        let all: Option<Vec<f64>> = row.list()?.iter().map(Value::number).collect();
        all?.try_into().ok()
    };
    let rows: Option<Vec<[f64; 4]>> = rows.iter().map(numbers).collect();
    let rows = rows.filter(|rows| (3..=4).contains(&rows.len()));
    let Some(rows) = rows else {
        let found = matrix.shown();
        return Err(format!("is {found}: expected 3 or 4 rows of 4 numbers"));
    };
    if let Some(last) = rows.get(3) {
        let off = |(value, unit): (&f64, f64)| (value - unit).abs() > ROUNDING || value.is_nan();
        if last.iter().zip([0.0, 0.0, 0.0, 1.0]).any(off) {
            return Err(format!("has the last row {last:?}: expected [0, 0, 0, 1]"));
        }
    }
    let column = |c: usize| DVec3::new(rows[0][c], rows[1][c], rows[2][c]);
    let rotation = DMat3::from_cols(column(0), -column(1), -column(2));
    let off = rotation * rotation.transpose() - DMat3::IDENTITY;
    let rigid = off.to_cols_array().iter().all(|v| v.abs() < ROUNDING);
    if !(rigid && rotation.determinant() > 0.0) {
        let found = matrix.shown();
        return Err(format!(
            "is no rotation and translation but {found}: expected columns of length 1 at right \
             angles, right-handed"
        ));
    }
    if !column(3).abs().cmple(DVec3::splat(FAR)).all() {
        return Err(format!("is at {}: expected -1e9 to 1e9", column(3)));
    }
    // Rounding of the file is taken out, so that the inverse is exact.
    let turn = glam::DQuat::from_mat3(&rotation).normalize();
    let to_world = DAffine3::from_rotation_translation(turn, column(3));
    Ok(to_world.inverse())
}
