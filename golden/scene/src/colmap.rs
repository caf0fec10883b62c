//! Poses of a COLMAP reconstruction in text form: a folder with `cameras.txt`
//! and `images.txt` (COLMAP's document "Output Format").
//!
//! COLMAP's cameras look along +z with y down, poses map the world to the
//! camera, and the centre of the upper left pixel is at (0.5, 0.5): all of it
//! is this project's convention too, so that no number is converted.

use std::collections::{BTreeMap, HashSet};
use std::fmt::Display;
use std::fs::File;
use std::io::{BufRead as _, BufReader};
use std::path::{Path, PathBuf};
use std::str::FromStr;

use glam::{DAffine3, DQuat, DVec2, DVec3};
use thiserror::Error;

use super::transforms::PathFrame;
use potamoi_base::camera::Camera;
use potamoi_base::record::Fate::{Honoured, Listed, Refused};
use potamoi_base::record::{Fate, Format, Key, Notes, Record};

/// The longest line, in bytes: one of `images.txt` holds every point of an image.
const MAX_LINE: u64 = 1 << 26;
/// Characters of a wrong value that are told.
const TOLD: usize = 60;
/// The most cameras and the most images.
const MAX_ENTRIES: usize = 1 << 20;
/// The longest picture side.
const MAX_SIDE: f64 = 32768.0;
/// How far a quaternion's length may be from 1: files may hold few digits.
const UNIT_TOLERANCE: f64 = 1e-2;

const fn key(name: &'static str, fate: Fate, about: &'static str) -> Key {
    Key { name, fate, about }
}

const UNDISTORT: &str = "only pinholes are rendered; colmap image_undistorter makes such pictures";

/// The folder, by its files.
pub(super) static FOLDER: Format = Format {
    name: "COLMAP's folder",
    files: "`[camera] kind = \"colmap\"`: a reconstruction as text. Of other files of the folder \
            nothing is said.",
    keys: &[
        key(
            "cameras.txt",
            Honoured,
            "intrinsics; a mark before the text does no harm",
        ),
        key(
            "images.txt",
            Honoured,
            "poses and names, one image a line, and behind it a line of points, which may be empty; \
             or images alone, if no line of the file could be one of points",
        ),
        key("cameras.bin", Listed, "the text is read"),
        key("images.bin", Listed, "the text is read"),
        key("points3D.*", Listed, "no camera"),
        key("rigs.*", Listed, "images say their own poses"),
        key("frames.*", Listed, "images say their own poses"),
    ],
    others: Listed,
};

/// Lines of `cameras.txt`: models and their parameters.
pub(super) static INTRINSICS: Format = Format {
    name: "COLMAP's cameras.txt",
    files: "Models, and the parameters of theirs.",
    keys: &[
        key("SIMPLE_PINHOLE", Honoured, "f, cx, cy"),
        key("PINHOLE", Honoured, "fx, fy, cx, cy"),
        key("SIMPLE_RADIAL", Honoured, "if k is 0"),
        key("RADIAL", Honoured, "if k1 and k2 are 0"),
        key("OPENCV", Honoured, "if k1, k2, p1 and p2 are 0"),
        key("FULL_OPENCV", Refused, UNDISTORT),
        key("*FISHEYE", Refused, UNDISTORT),
        key("FOV", Refused, UNDISTORT),
        key("DIVISION", Refused, UNDISTORT),
    ],
    others: Refused,
};

/// Lines of `images.txt`.
pub(super) static POSES: Format = Format {
    name: "COLMAP's images.txt",
    files: "Fields of an image.",
    keys: &[
        key("IMAGE_ID", Honoured, "each once"),
        key(
            "QW, QX, QY, QZ",
            Honoured,
            "the rotation from world to camera; of length 1",
        ),
        key("TX, TY, TZ", Honoured, "the translation"),
        key("CAMERA_ID", Honoured, "a camera of cameras.txt"),
        key("NAME", Honoured, "the picture; images are sorted by it"),
        key("POINTS2D[]", Listed, "no camera"),
    ],
    others: Refused,
};

/// Poses that cannot be used.
#[derive(Debug, Error)]
pub enum ColmapError {
    /// The file system refused.
    #[error(
        "cannot read poses {path}: {source}; name a folder with COLMAP's cameras.txt and \
         images.txt (colmap model_converter --output_type TXT writes them)"
    )]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// A file that is no such text as a whole.
    #[error("poses {path}: {found}: expected {expected}")]
    File {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        found: String,
        /// What would be right.
        expected: String,
    },
    /// A line that says something else.
    #[error("poses {path}, line {line}: {field} is {value}: expected {expected}")]
    Line {
        /// The file.
        path: PathBuf,
        /// Its line, from 1.
        line: usize,
        /// The field, as COLMAP names it.
        field: &'static str,
        /// Its value.
        value: String,
        /// What would be right.
        expected: String,
    },
}

/// What is wrong in a line: field, value, what was expected.
type Wrong = (&'static str, String, String);

/// Reads all images of a folder, at least one, sorted by name. `notes` takes what
/// is not used.
///
/// # Errors
/// A file cannot be read, is no such text, or holds numbers that make no
/// undistorted camera.
pub fn read(folder: &Path, notes: &mut Notes) -> Result<Vec<PathFrame>, ColmapError> {
    files(folder, notes);
    let mut listed = Text::open(folder.join("cameras.txt"))?;
    let cameras = listed.cameras()?;
    let mut images = Text::open(folder.join("images.txt"))?;
    let posed = images.images(&cameras, notes)?;
    let mut frames = vec![];
    for image in &posed {
        match &cameras[&image.lens] {
            Lens::Pinhole(camera) => frames.push(PathFrame {
                camera: Camera {
                    world_to_camera: image.world_to_camera,
                    ..*camera
                },
                picture: image.picture.clone(),
            }),
            Lens::Strange { line, wrong } => {
                listed.number = *line;
                return Err(listed.at(wrong.clone()));
            }
        }
    }
    // What is no pinhole got here without an image.
    for (id, lens) in &cameras {
        if matches!(lens, Lens::Strange { .. }) {
            notes.list(format!(
                "cameras.txt: camera {id}, of which there is no image"
            ));
        }
    }
    frames.sort_by(|a, b| a.picture.cmp(&b.picture));
    let twice = frames.windows(2).find(|w| w[0].picture == w[1].picture);
    match (twice, frames.is_empty()) {
        (Some(pair), _) => {
            let found = format!("two images named {}", shown(pair[0].picture.display()));
            Err(images.wrong(found, "each name once"))
        }
        (None, true) => Err(images.wrong("no image".to_owned(), "at least one")),
        (None, false) => Ok(frames),
    }
}

/// Lists files of a reconstruction that are not read.
fn files(folder: &Path, notes: &mut Notes) {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let names = entries.map(|entry| entry.file_name().to_string_lossy().into_owned());
    let mut known: Vec<_> = names.filter(|name| FOLDER.row(name).is_some()).collect();
    known.sort();
    let mut record = Record::new(&FOLDER, known.into_iter().map(|name| (name, ())));
    record.take("cameras.txt");
    record.take("images.txt");
    // No row of the table is refused.
    let _ = record.finish(notes);
}

/// A file, one line of it at a time.
struct Text {
    path: PathBuf,
    file: BufReader<File>,
    /// The line that was read last, and its number, from 1.
    bytes: Vec<u8>,
    number: usize,
}

impl Text {
    fn open(path: PathBuf) -> Result<Self, ColmapError> {
        match potamoi_base::files::open(&path) {
            Ok(file) => Ok(Self {
                path,
                file: BufReader::new(file),
                bytes: vec![],
                number: 0,
            }),
            Err(source) if path.with_extension("bin").exists() => Err(ColmapError::Read {
                source: std::io::Error::other(format!(
                    "{source}; the binary form beside it is not read"
                )),
                path,
            }),
            Err(source) => Err(ColmapError::Read { path, source }),
        }
    }

    fn wrong(&self, found: String, expected: &str) -> ColmapError {
        ColmapError::File {
            path: self.path.clone(),
            found,
            expected: expected.to_owned(),
        }
    }

    /// Something in the line that was read last.
    fn at(&self, (field, value, expected): Wrong) -> ColmapError {
        ColmapError::Line {
            path: self.path.clone(),
            line: self.number,
            field,
            value,
            expected,
        }
    }

    /// Reads a line; `false` behind the last.
    fn advance(&mut self) -> Result<bool, ColmapError> {
        self.bytes.clear();
        self.number += 1;
        let read = self.read_line().map_err(|source| ColmapError::Read {
            path: self.path.clone(),
            source,
        })?;
        if self.bytes.len() as u64 > MAX_LINE {
            let expected = format!("at most {MAX_LINE} bytes a line");
            return Err(self.at(("text", "longer".to_owned(), expected)));
        }
        // The mark that some editors put before UTF-8.
        if self.number == 1 && self.bytes.starts_with(b"\xef\xbb\xbf") {
            self.bytes.drain(..3);
        }
        Ok(read)
    }

    /// Reads up to a line feed, a carriage return, or both; `false` if nothing is left. Of a line
    /// that is too long, a part.
    fn read_line(&mut self) -> std::io::Result<bool> {
        let mut any = false;
        while self.bytes.len() as u64 <= MAX_LINE {
            let there = self.file.fill_buf()?;
            if there.is_empty() {
                break;
            }
            any = true;
            let end = there.iter().position(|byte| matches!(byte, b'\n' | b'\r'));
            let Some(at) = end else {
                let all = there.len();
                self.bytes.extend_from_slice(there);
                self.file.consume(all);
                continue;
            };
            let returned = there[at] == b'\r';
            self.bytes.extend_from_slice(&there[..at]);
            self.file.consume(at + 1);
            if returned && self.file.fill_buf()?.first() == Some(&b'\n') {
                self.file.consume(1);
            }
            break;
        }
        Ok(any)
    }

    /// The line that was read last.
    fn line(&self) -> &[u8] {
        self.bytes.trim_ascii()
    }

    /// Reads up to a line that is neither empty nor a comment; `false` if there
    /// is none.
    fn advance_to_text(&mut self) -> Result<bool, ColmapError> {
        while self.advance()? {
            if !self.line().is_empty() && !self.line().starts_with(b"#") {
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// Lenses by `CAMERA_ID`.
    fn cameras(&mut self) -> Result<BTreeMap<u32, Lens>, ColmapError> {
        let mut cameras = BTreeMap::new();
        while self.advance_to_text()? {
            let (id, lens) = Fields::of(self.line())
                .and_then(|fields| intrinsics(fields, self.number))
                .map_err(|wrong| self.at(wrong))?;
            if cameras.insert(id, lens).is_some() {
                let wrong = ("CAMERA_ID", id.to_string(), "each camera once".to_owned());
                return Err(self.at(wrong));
            }
            if cameras.len() > MAX_ENTRIES {
                let expected = format!("at most {MAX_ENTRIES} cameras");
                return Err(self.wrong("more".to_owned(), &expected));
            }
        }
        Ok(cameras)
    }

    /// Images, with a line of points behind each, which may be empty; or images
    /// alone. A line that could be both is refused, so that no image is taken for
    /// points, whatever its name.
    fn images(
        &mut self,
        cameras: &BTreeMap<u32, Lens>,
        notes: &mut Notes,
    ) -> Result<Vec<Posed>, ColmapError> {
        let read = |line: &[u8]| Fields::of(line).and_then(|fields| image(fields, cameras));
        let mut frames = vec![];
        let mut ids = HashSet::new();
        let mut has_points = None;
        while self.advance_to_text()? {
            loop {
                let (id, frame) = read(self.line()).map_err(|wrong| self.at(wrong))?;
                if has_points == Some(false) && are_points(self.line()) {
                    return Err(self.at(either()));
                }
                if !ids.insert(id) {
                    let wrong = ("IMAGE_ID", id.to_string(), "each image once".to_owned());
                    return Err(self.at(wrong));
                }
                frames.push(frame);
                if frames.len() > MAX_ENTRIES {
                    let expected = format!("at most {MAX_ENTRIES} images");
                    return Err(self.wrong("more".to_owned(), &expected));
                }
                if has_points == Some(false) {
                    break;
                }
                if !self.advance()? {
                    return Ok(frames);
                }
                let (points, next) = (are_points(self.line()), read(self.line()));
                match (points, next) {
                    (true, Ok(_)) => return Err(self.at(either())),
                    (true, Err(_)) => {
                        if !self.line().is_empty() {
                            notes.list("images.txt: POINTS2D[]");
                        }
                        has_points = Some(true);
                        break;
                    }
                    // The second line of the file tells that there are none.
                    (false, Ok(_)) if has_points.is_none() => has_points = Some(false),
                    (false, _) => {
                        let found = format!("\"{}\"", shown(String::from_utf8_lossy(self.line())));
                        let expected = "X, Y and POINT3D_ID of each point, as behind the images \
                                        before, or an empty line";
                        return Err(self.at(("POINTS2D[]", found, expected.to_owned())));
                    }
                }
            }
        }
        Ok(frames)
    }
}

/// What `cameras.txt` says of a camera.
enum Lens {
    /// A pinhole, posed nowhere.
    Pinhole(Camera),
    /// Another lens, by its line; images of it are refused, and it is listed where there are none.
    Strange { line: usize, wrong: Wrong },
}

/// A line of `images.txt`.
struct Posed {
    /// Its `CAMERA_ID`, which `cameras.txt` has.
    lens: u32,
    world_to_camera: DAffine3,
    picture: PathBuf,
}

/// Whether a line is of points: X, Y and POINT3D_ID of each, or nothing at all.
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

/// A line that could be an image and points.
fn either() -> Wrong {
    let expected = "an image or points; this line could be both: put a line of points, or an empty \
                    one, behind every image, as COLMAP does, or name pictures by more than numbers";
    ("line", "ambiguous".to_owned(), expected.to_owned())
}

/// The fields of a line, one after the other.
struct Fields<'a>(&'a str);

impl<'a> Fields<'a> {
    fn of(line: &'a [u8]) -> Result<Self, Wrong> {
        let text = std::str::from_utf8(line);
        let text = text.map_err(|e| {
            let at = e.valid_up_to() + 1;
            (
                "text",
                format!("not UTF-8 at byte {at}"),
                "UTF-8: save it so".to_owned(),
            )
        })?;
        Ok(Self(text))
    }

    /// The next field's text; empty behind the last.
    fn next(&mut self) -> &'a str {
        let (field, rest) = self
            .0
            .split_once(|c: char| c.is_ascii_whitespace())
            .unwrap_or((self.0, ""));
        self.0 = rest.trim_start();
        field
    }

    fn parse<T: FromStr>(&mut self, field: &'static str, expected: &str) -> Result<T, Wrong> {
        let text = self.next();
        let wrong = |_| (field, shown(text), expected.to_owned());
        text.parse().map_err(wrong)
    }

    fn number<R>(&mut self, field: &'static str, range: R, expected: &str) -> Result<f64, Wrong>
    where
        R: std::ops::RangeBounds<f64>,
    {
        let value: f64 = self.parse(field, expected)?;
        // Not a number is in no range.
        if range.contains(&value) {
            Ok(value)
        } else {
            Err((field, shown(value), expected.to_owned()))
        }
    }

    fn id(&mut self, field: &'static str) -> Result<u32, Wrong> {
        let expected = "a whole number from 0 to 4294967295";
        let ids = 0.0..=f64::from(u32::MAX);
        self.whole(field, ids, expected).map(|id| id as u32)
    }

    /// A whole number, however it is written.
    fn whole<R>(&mut self, field: &'static str, range: R, expected: &str) -> Result<f64, Wrong>
    where
        R: std::ops::RangeBounds<f64>,
    {
        let value = self.number(field, range, expected)?;
        match value.fract() == 0.0 {
            true => Ok(value),
            false => Err((field, shown(value), expected.to_owned())),
        }
    }
}

fn shown(value: impl Display) -> String {
    match value.to_string() {
        text if text.is_empty() => "missing".to_owned(),
        text => text.chars().take(TOLD).collect(),
    }
}

/// `CAMERA_ID MODEL WIDTH HEIGHT PARAMS[]`.
fn intrinsics(mut fields: Fields<'_>, line: usize) -> Result<(u32, Lens), Wrong> {
    let id = fields.id("CAMERA_ID")?;
    let model = fields.next();
    let (focals, distortions): (_, &[&'static str]) = match model {
        "SIMPLE_PINHOLE" => (1, &[]),
        "PINHOLE" => (2, &[]),
        "SIMPLE_RADIAL" => (1, &["k"]),
        "RADIAL" => (1, &["k1", "k2"]),
        "OPENCV" => (2, &["k1", "k2", "p1", "p2"]),
        other => {
            let expected = "PINHOLE or SIMPLE_PINHOLE, or SIMPLE_RADIAL, RADIAL or OPENCV without \
                            distortion; colmap image_undistorter makes such pictures";
            let wrong = ("MODEL", shown(other), expected.to_owned());
            return Ok((id, Lens::Strange { line, wrong }));
        }
    };
    let mut side =
        |field| fields.whole(field, 1.0..=MAX_SIDE, "a whole number of 1 to 32768 pixels");
    let [width, height] = [side("WIDTH")?, side("HEIGHT")?];
    let mut focal = |field| fields.number(field, 1e-3..=1e9, "0.001 to 1e9 pixels");
    let focal = match focals {
        1 => DVec2::splat(focal("f")?),
        _ => DVec2::new(focal("fx")?, focal("fy")?),
    };
    let mut centre = |field| fields.number(field, -1e6..=1e6, "-1e6 to 1e6 pixels");
    let centre = DVec2::new(centre("cx")?, centre("cy")?);
    let mut strange = None;
    for field in distortions {
        let expected = "0: distorted pictures are not rendered; colmap image_undistorter makes \
                        others";
        let value: f64 = fields.parse(field, expected)?;
        if value != 0.0 {
            strange.get_or_insert((*field, shown(value), expected.to_owned()));
        }
    }
    if !fields.0.is_empty() {
        let expected = format!("{} of {model}", focals + 2 + distortions.len());
        return Err((
            "PARAMS[]",
            format!("{} too much", shown(fields.0)),
            expected,
        ));
    }
    let camera = Camera {
        width: width as u32,
        height: height as u32,
        focal,
        centre,
        world_to_camera: DAffine3::IDENTITY,
    };
    let lens = match strange {
        None => Lens::Pinhole(camera),
        Some(wrong) => Lens::Strange { line, wrong },
    };
    Ok((id, lens))
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

#[cfg(test)]
#[path = "colmap_tests.rs"]
mod tests;
