//! Compositing of splats pair by pair, in exact integers: what a unit for it computes, which walks the
//! pixels that a Gaussian reaches one after the other.
//!
//! | step | computes | format |
//! |---|---|---|
//! | p, q | affine forms of the pixel's place ([`Forms`]) | S15.16 |
//! | u | `(p^2 + q^2) / 2`, half up, saturating | the exponential's input, G fraction bits |
//! | cut | pairs with `u` above the limit of the opacity are dropped ([`PowerLimits`]) | |
//! | e | `exp(-u)` | U0.F |
//! | alpha | `o e`, half up; cap; dropped below the threshold | U0.16 |
//! | T' | `T (1 - alpha)`, half up; the pixel stops if the exact product is below the threshold | U1.20 |
//! | colour | exact sum of `(T - T') c` | 32 fraction bits |
//!
//! The cut changes no bit: the comparison after the multiplication remains. With `su.opacity = "in-power"`
//! alpha is `exp(-(u - ln o))`, without a multiplication; `-ln o` is in the records.

mod affine_forms;
mod job;
mod power_limits;
mod reference;
mod spans;
mod tile_state;

pub use affine_forms::Forms;
pub use job::{Composited, SplatEntry, SplatJob, SplatPixel, SplatSettings, SplatUnitCounts};
pub use power_limits::{CoarseLimits, PowerLimits, StoredLimits};
pub use reference::{ReferenceSplatUnit, SplatPairs, SplatPart};
pub use spans::{ROW_MASK, Span, Spans};
pub use tile_state::{Outcome, Thresholds, TileState};

/// Side of a tile in pixels.
pub const TILE: u32 = 16;
/// Pixels of a tile.
pub const TILE_PIXELS: usize = (TILE * TILE) as usize;
