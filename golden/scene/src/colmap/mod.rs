//! Poses of a COLMAP reconstruction in text form: a folder with `cameras.txt`
//! and `images.txt` (COLMAP's document "Output Format").
//!
//! COLMAP's cameras look along +z with y down, poses map the world to the camera, and the centre
//! of the upper left pixel is at (0.5, 0.5). This project has the same convention, so no number is
//! converted.

mod cameras;
mod error;
mod images;
mod keys;
#[cfg(test)]
mod tests;
mod text;

use std::path::Path;

use potamoi_base::camera::Camera;
use potamoi_base::file_keys::{FileKeys, Notes};

use super::transforms::PathFrame;
use cameras::{Lens, cameras};
pub use error::ColmapError;
pub(super) use keys::{FOLDER, INTRINSICS, POSES};
use text::{Text, shown};

/// Reads all images of a folder, at least one, sorted by name. Unused parts are added to `notes`.
///
/// # Errors
/// A file cannot be read or is invalid, or its numbers do not describe undistorted cameras.
pub fn read(folder: &Path, notes: &mut Notes) -> Result<Vec<PathFrame>, ColmapError> {
    files(folder, notes);
    let mut listed = Text::open(folder.join("cameras.txt"))?;
    let cameras = cameras(&mut listed)?;
    let mut images = Text::open(folder.join("images.txt"))?;
    let posed = self::images::images(&mut images, &cameras, notes)?;
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
            notes.list(format!("cameras.txt: camera {id}, which no image uses"));
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
    let mut record = FileKeys::new(&FOLDER, known.into_iter().map(|name| (name, ())));
    record.take("cameras.txt");
    record.take("images.txt");
    // No row of the table is refused.
    let _ = record.finish(notes);
}
