//! Poses and picture names from `images.txt`.

use std::collections::{BTreeMap, HashSet};
use std::path::PathBuf;

use glam::{DAffine3, DQuat, DVec3};
use potamoi_base::file_keys::Notes;

use super::cameras::Lens;
use super::error::{ColmapError, Wrong};
use super::text::{Fields, MAX_ENTRIES, Text, shown};

/// Maximum deviation of a quaternion's length from 1: files may hold few digits.
const UNIT_TOLERANCE: f64 = 1e-2;

/// A line of `images.txt`.
pub(super) struct Posed {
    /// Its `CAMERA_ID`, which exists in `cameras.txt`.
    pub(super) lens: u32,
    pub(super) world_to_camera: DAffine3,
    pub(super) picture: PathBuf,
}

/// Reads images, either each followed by a line of points, which may be empty, or images alone. A
/// line that could be both is refused, so that no image is mistaken for points, whatever its name.
pub(super) fn images(
    text: &mut Text,
    cameras: &BTreeMap<u32, Lens>,
    notes: &mut Notes,
) -> Result<Vec<Posed>, ColmapError> {
    let read = |line: &[u8]| Fields::of(line).and_then(|fields| image(fields, cameras));
    let mut frames = vec![];
    let mut ids = HashSet::new();
    let mut has_points = None;
    while text.advance_to_text()? {
        loop {
            let (id, frame) = read(text.line()).map_err(|wrong| text.at(wrong))?;
            if has_points == Some(false) && are_points(text.line()) {
                return Err(text.at(either()));
            }
            if !ids.insert(id) {
                let wrong = ("IMAGE_ID", id.to_string(), "each image once".to_owned());
                return Err(text.at(wrong));
            }
            frames.push(frame);
            if frames.len() > MAX_ENTRIES {
                let expected = format!("at most {MAX_ENTRIES} images");
                return Err(text.wrong("more".to_owned(), &expected));
            }
            if has_points == Some(false) {
                break;
            }
            if !text.advance()? {
                return Ok(frames);
            }
            let (points, next) = (are_points(text.line()), read(text.line()));
            match (points, next) {
                (true, Ok(_)) => return Err(text.at(either())),
                (true, Err(_)) => {
                    if !text.line().is_empty() {
                        notes.list("images.txt: POINTS2D[]");
                    }
                    has_points = Some(true);
                    break;
                }
                // The second line of the file tells that there are none.
                (false, Ok(_)) if has_points.is_none() => has_points = Some(false),
                (false, _) => {
                    let found = format!("\"{}\"", shown(String::from_utf8_lossy(text.line())));
                    let expected = "X, Y and POINT3D_ID of each point, as behind the images \
                                    before, or an empty line";
                    return Err(text.at(("POINTS2D[]", found, expected.to_owned())));
                }
            }
        }
    }
    Ok(frames)
}

/// `IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME`.
fn image(mut fields: Fields<'_>, cameras: &BTreeMap<u32, Lens>) -> Result<(u32, Posed), Wrong> {
    let image = fields.id("IMAGE_ID")?;
    let mut part = |field| fields.number(field, -2.0..=2.0, "a part of a unit quaternion");
    let [w, x, y, z] = [part("QW")?, part("QX")?, part("QY")?, part("QZ")?];
    let turn = DQuat::from_xyzw(x, y, z, w);
    if (turn.length() - 1.0).abs() > UNIT_TOLERANCE {
        let value = format!("({w}, {x}, {y}, {z})");
        return Err(("QW QX QY QZ", value, "a unit quaternion".to_owned()));
    }
    let mut along = |field| fields.number(field, -1e9..=1e9, "-1e9 to 1e9");
    let shift = DVec3::new(along("TX")?, along("TY")?, along("TZ")?);
    let lens = fields.id("CAMERA_ID")?;
    if !cameras.contains_key(&lens) {
        let expected = "a camera of cameras.txt".to_owned();
        return Err(("CAMERA_ID", lens.to_string(), expected));
    }
    if fields.0.is_empty() {
        return Err((
            "NAME",
            "missing".to_owned(),
            "the picture's name".to_owned(),
        ));
    }
    if fields.0.contains(char::is_control) {
        let found = shown(fields.0.escape_debug());
        return Err((
            "NAME",
            found,
            "a name without control characters".to_owned(),
        ));
    }
    let posed = Posed {
        lens,
        world_to_camera: DAffine3::from_rotation_translation(turn.normalize(), shift),
        picture: PathBuf::from(fields.0),
    };
    Ok((image, posed))
}

/// Whether a line holds points, with X, Y and POINT3D_ID each, or is empty.
fn are_points(line: &[u8]) -> bool {
    let Ok(text) = std::str::from_utf8(line) else {
        return false;
    };
    let is_number = |text: &str| text.parse::<f64>().is_ok_and(f64::is_finite);
    let is_id = |text: &str| text == "-1" || text.parse::<u64>().is_ok();
    let values: Vec<&str> = text.split_ascii_whitespace().collect();
    let points = values.chunks(3);
    points.into_iter().all(|point| match point {
        [x, y, id] => is_number(x) && is_number(y) && is_id(id),
        _ => false,
    })
}

/// The error for a line that could be an image or points.
fn either() -> Wrong {
    let expected = "an image or points; this line could be both: put a line of points, or an empty \
                    one, behind every image, as COLMAP does, or name pictures by more than numbers";
    ("line", "ambiguous".to_owned(), expected.to_owned())
}
