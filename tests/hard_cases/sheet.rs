//! The pictures of all cases on one sheet.

use potamoi_base::picture::Picture;

use super::{pictures, sampled};
use potamoi_analysis::hard_cases::pictures::SIZE;

/// Pixels of a sheet a pixel, and between pictures.
const SCALE: u32 = 5;
const GAP: u32 = 6;
/// Columns side by side.
const ACROSS: u32 = 8;

/// A column a scene: the obvious form, what is no number in magenta, ours, and 64-bit floats.
pub(crate) fn sheet() -> Picture {
    let mut columns = pictures::columns();
    let others = sampled::all().iter().cloned();
    columns.extend(others.map(|s| [s.naive, s.ours, s.float]));
    let [wide, high] = SIZE.map(|pixels| pixels * SCALE + GAP);
    let bands = (columns.len() as u32).div_ceil(ACROSS);
    // Between bands twice as much.
    let band = 3 * high + GAP;
    let mut sheet = Picture::filled(ACROSS * wide + GAP, bands * band, [1.0; 3]);
    for (i, pictures) in (0..).zip(columns) {
        for (row, picture) in (0..).zip(pictures) {
            let corner = [
                i % ACROSS * wide + GAP,
                i / ACROSS * band + row * high + GAP,
            ];
            paste(&mut sheet, corner, &picture);
        }
    }
    sheet
}

fn paste(sheet: &mut Picture, [left, top]: [u32; 2], picture: &Picture) {
    let [width, height] = SIZE;
    for y in 0..height * SCALE {
        for x in 0..width * SCALE {
            let own = picture.rgb[(y / SCALE * width + x / SCALE) as usize];
            let is_number = own.iter().all(|v| v.is_finite());
            let to = (top + y) * sheet.width + left + x;
            sheet.rgb[to as usize] = if is_number { own } else { [1.0, 0.0, 1.0] };
        }
    }
}
