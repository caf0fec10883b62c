//! A grid of configurations, synthesised: how area, period and energy go with banks,
//! ports, widths, lanes and iterations.

mod design;
mod report;

pub use design::{Differences, Family, Point, design};
pub use report::{Grid, GridActivity, GridEnergy, GridModule, GridPoint};
