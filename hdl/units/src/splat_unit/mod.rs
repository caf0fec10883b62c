//! The splat unit: composites records of Gaussians into the pixels of tiles.
//!
//! ```text
//! entries -> splat_setup -> splat_rows -> splat_pixels -> splat_powers -> splat_tiles -> pixels
//!            start values   span of a     one pixel a     exponential     transmittance
//!            of the forms   row           clock, cut                      and colour
//! ```
//!
//! A tile's records come in depth order. Pixels of a span are walked one by one, so that a lane of
//! the exponential never waits for a pixel that does not count.

mod drain;
mod entries;
mod formats;
mod forms;
mod inputs;
mod limits;
mod live;
mod masks;
mod near;
mod packing_checks;
mod pixels;
mod powers;
mod product;
mod registers;
mod root;
mod row_tag;
mod rows;
mod setup;
mod start_values;
mod tiles;
mod top;

use std::sync::Arc;

use potamoi_formats::config::{Config, SuConfig};
use potamoi_netlist::{IrErrors, Module};

pub use top::splat_unit;

/// Builds `splat_powers`, the part of a splat unit that packs pairs into the lanes of the exponential.
///
/// # Errors
/// The netlist's own checks; none for a configuration that keeps its rules.
pub fn packer(config: &Config, su: &SuConfig) -> Result<Arc<Module>, IrErrors> {
    powers::powers(config, su, &formats::Widths::of(config, su))
}
