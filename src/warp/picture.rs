//! Pictures of frames and of their pixels' origins.

use std::path::Path;

use potamoi_base::picture::Picture;
use potamoi_warp::{Class, Frame};

use crate::failure::Failure;

/// Writes `frame.NNNN.png` and `origin.NNNN.png`: warped pixels in grey by their
/// brightness, void ones black, those rendered as they were disoccluded red, by their
/// angle blue, at edges yellow, with the whole frame green.
pub(super) fn write(folder: &Path, frame: &Frame) -> Result<(), Failure> {
    let picture = &frame.target.shaded.picture;
    let number = frame.number;
    picture.write_png(&folder.join(format!("frame.{number:04}.png")))?;
    let pixels = picture.rgb.iter().zip(&frame.target.classes);
    let origin = Picture {
        rgb: pixels.map(|(rgb, class)| colour(*rgb, *class)).collect(),
        ..*picture
    };
    origin.write_png(&folder.join(format!("origin.{number:04}.png")))?;
    Ok(())
}

fn colour(rgb: [f32; 3], class: Class) -> [f32; 3] {
    let grey = 0.15 + 0.55 * rgb.iter().sum::<f32>() / 3.0;
    match class {
        Class::Warped => [grey; 3],
        Class::Void => [0.0; 3],
        Class::Disoccluded => [0.9, 0.25, 0.15],
        Class::Angle => [0.2, 0.45, 0.95],
        Class::Edge => [0.95, 0.8, 0.2],
        Class::Full => [0.3 * grey, 0.3 + 0.5 * grey, 0.3 * grey],
    }
}
