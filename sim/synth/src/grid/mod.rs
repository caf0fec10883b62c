//! A grid of configurations, synthesised: how area, period and energy go with banks,
//! ports, widths, lanes and iterations; and exponentials of other structure, each by itself.

mod design;
mod report;

pub(crate) use design::is_same_unit;
pub use design::{Differences, Family, Point, design, forms};
pub use report::{Grid, GridActivity, GridEnergy, GridModule, GridPoint};
