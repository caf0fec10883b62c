//! Voxel grids: density and colours are stored at vertices, not computed.

mod bound;
mod coded;
mod densities;
mod field;
mod formats;
mod grid;
mod head;
mod ranges;
#[cfg(test)]
mod tests;

pub use bound::{error_bounds, opacity_off};
pub use field::{ALGORITHM, STEP, STOP_BELOW, StoredField};
pub use formats::Formats;
pub use grid::{Grid, Layout, MAX_POINTS, MAX_VALUES};
