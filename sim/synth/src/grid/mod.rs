//! A grid of configurations, synthesised: how area, period and energy go with banks,
//! ports, widths, lanes and iterations; and exponentials of other structure, each by itself.

mod data_set;
mod design;

pub use data_set::{Grid, GridActivity, GridEnergy, GridModule, GridPoint};
pub(crate) use design::is_same_unit;
pub use design::{Differences, Family, Point, design, forms};
