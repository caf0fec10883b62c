//! Lenses from `cameras.txt`.

use std::collections::BTreeMap;

use glam::{DAffine3, DVec2};
use potamoi_base::camera::Camera;

use super::error::{ColmapError, Wrong};
use super::text::{Fields, MAX_ENTRIES, Text, shown};

/// The longest picture side.
const MAX_SIDE: f64 = 32768.0;

/// The lens of a camera in `cameras.txt`.
pub(super) enum Lens {
    /// A pinhole without a pose.
    Pinhole(Camera),
    /// Another lens, with its line. Images that use it are refused; without images it is listed.
    Strange { line: usize, wrong: Wrong },
}

/// Lenses by `CAMERA_ID`.
pub(super) fn cameras(text: &mut Text) -> Result<BTreeMap<u32, Lens>, ColmapError> {
    let mut cameras = BTreeMap::new();
    while text.advance_to_text()? {
        let (id, lens) = Fields::of(text.line())
            .and_then(|fields| intrinsics(fields, text.number))
            .map_err(|wrong| text.at(wrong))?;
        if cameras.insert(id, lens).is_some() {
            let wrong = ("CAMERA_ID", id.to_string(), "each camera once".to_owned());
            return Err(text.at(wrong));
        }
        if cameras.len() > MAX_ENTRIES {
            let expected = format!("at most {MAX_ENTRIES} cameras");
            return Err(text.wrong("more".to_owned(), &expected));
        }
    }
    Ok(cameras)
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
