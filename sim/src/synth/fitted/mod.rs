//! Area, period and energy of units that were not synthesised, from some that were.

mod design;
mod grid;

pub use design::{Family, Point, design};
pub use grid::{Grid, GridActivity, GridEnergy, GridModule, GridPoint, digest};
