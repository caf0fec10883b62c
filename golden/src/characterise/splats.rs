//! Accesses of splats.

use super::{Accesses, interleave};
use crate::camera::Camera;
use crate::splats::{Cloud, Profile, RenderError, View};

/// Reads of a frame: every Gaussian of every 16 x 16 tile in depth order, a tile
/// a lane, as a rasteriser fetches them; tiles that end early are not cut
/// short. Vectors are the Gaussians as they lie in the model, all of their
/// parameters in 32-bit floats.
///
/// # Errors
/// A camera that is not sensible.
pub fn splat_accesses(
    cloud: &Cloud,
    camera: &Camera,
    profile: Profile,
    lanes: usize,
) -> Result<Accesses, RenderError> {
    let view = View::new(cloud, camera, profile)?;
    let mut lists = vec![vec![]; view.tile_count()];
    for (rank, splat) in view.splats().iter().enumerate() {
        for tile in view.tiles_of(rank) {
            lists[*tile as usize].push(splat.index as u32);
        }
    }
    // Mean, scales, rotation, opacity and three colours a coefficient.
    let coefficients = (cloud.degree() as u32 + 1).pow(2);
    let bytes = 4 * (3 + 3 + 4 + 1 + 3 * coefficients);
    Ok(interleave(&lists, lanes, cloud.len() as u64, bytes))
}
