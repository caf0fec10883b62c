//! Accesses of splats.

use super::Accesses;
use super::accesses::{Lanes, Vectors, count, firsts};
use super::fields::Colours;
use crate::compact_3dgs::Compact;
use potamoi_base::mask::Mask;
use potamoi_fields::FieldError;
use potamoi_fields::Size;
use potamoi_gaussians::Cloud;
use potamoi_splats::View;

/// Lanes with one tile each: Gaussians in depth order, numbered after the vectors of other tables.
struct Tiles {
    lists: Vec<Vec<u32>>,
}

impl Lanes for Tiles {
    fn count(&self) -> usize {
        self.lists.len()
    }

    fn reads(&self, lane: usize) -> usize {
        self.lists[lane].len()
    }

    fn list(&self, lane: usize, out: &mut Vec<u32>) {
        out.extend_from_slice(&self.lists[lane]);
    }
}

/// Reads of a frame through a buffer of `capacity` bytes: every Gaussian of every 16 x 16 tile in
/// depth order, one lane a tile, as a rasteriser fetches them. Tiles that terminate early are not
/// cut short. Vectors are the Gaussians, with all parameters in 32-bit floats.
///
/// With `colour`, the colour of every Gaussian is computed first, one lane a Gaussian, whether it
/// is visible or not. Its vectors are the rows of the field's tables, with two bytes a channel,
/// and precede the Gaussians. With `full`, hashed tables have other numbers of entries; with
/// `only`, only tiles that have a pixel of a mask count.
///
/// # Errors
/// There are 2^32 vectors or more.
pub fn splat_accesses(
    cloud: &Cloud,
    colour: Option<&Compact>,
    full: Option<Size>,
    view: &View,
    only: Option<&Mask>,
    capacity: u32,
) -> Result<Accesses, FieldError> {
    let entries = full.and_then(|size| match size {
        Size::Entries(entries) => Some(entries),
        Size::Points(_) | Size::Cells { .. } => None,
    });
    let centres = colour.map(Compact::asked_at).unwrap_or_default();
    let colours = colour.map(|model| Colours::new(model.colour(), &centres, entries));
    let (colours, vectors) = colours.transpose()?.unzip();
    let mut vectors = vectors.unwrap_or_default();
    // Mean, scales, rotation, opacity and three colours a coefficient.
    let coefficients = (cloud.degree() as u32 + 1).pow(2);
    vectors.push(Vectors {
        count: cloud.len() as u32,
        bytes: 4 * (3 + 3 + 4 + 1 + 3 * coefficients),
    });
    let first = firsts(&vectors)?[vectors.len() - 1];
    let mut lists = vec![vec![]; view.tile_count()];
    let wanted: Vec<bool> = (0..view.tile_count())
        .map(|tile| only.is_none_or(|mask| view.shows(tile, mask)))
        .collect();
    for (rank, splat) in view.splats().iter().enumerate() {
        for tile in view.tiles_of(rank).iter().filter(|t| wanted[**t as usize]) {
            lists[*tile as usize].push(first + splat.index as u32);
        }
    }
    let tiles = Tiles { lists };
    let mut phases: Vec<&dyn Lanes> = vec![];
    phases.extend(colours.as_ref().map(|colours| colours as &dyn Lanes));
    phases.push(&tiles);
    count(vectors, &phases, capacity)
}
