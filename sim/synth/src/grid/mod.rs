//! Grid of synthesised configurations: area, period and energy over banks, ports, widths, lanes and
//! iterations; and exponentials of other structure, each on its own.

mod data_set;
mod design;

pub use data_set::{Grid, GridActivity, GridEnergy, GridModule, GridPoint};
pub use design::is_same_unit;
pub use design::{Differences, Family, Point, design, forms};
pub(crate) use design::{differing, is_exponential};
