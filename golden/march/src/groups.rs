//! Square ray groups of a picture.

use potamoi_base::mask::Mask;

/// Maximum number of rays in a group: their state, 16 B each, fills half of a 1.5 MB global
/// feature buffer.
pub const GROUP_RAYS: u32 = 49_152;

/// The largest side of a square group of at most [`GROUP_RAYS`].
#[must_use]
pub fn default_group_side() -> u32 {
    GROUP_RAYS.isqrt()
}

/// The pixels of each ray group of a picture of `size` pixels, row after row. Groups are squares
/// of `side` pixels, cut off at the edges.
pub fn groups(
    size: [u32; 2],
    side: u32,
    only: Option<&Mask>,
) -> impl Iterator<Item = Vec<[u32; 2]>> {
    let [width, height] = size;
    let step = side.max(1) as usize;
    let lines = (0..height).step_by(step);
    let corners = lines.flat_map(move |top| (0..width).step_by(step).map(move |left| [left, top]));
    corners.map(move |[left, top]| {
        // Saturating: a side may exceed the picture by any amount.
        let columns = left..left.saturating_add(side).min(width);
        let lines = top..top.saturating_add(side).min(height);
        lines
            .flat_map(|y| columns.clone().map(move |x| [x, y]))
            .filter(|[x, y]| {
                let pixel = *y as usize * width as usize + *x as usize;
                only.is_none_or(|mask| mask.has(pixel))
            })
            .collect()
    })
}
