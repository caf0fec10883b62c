//! Both built-in scenes through units, small.

use potamoi_formats::config::Config;
use potamoi_golden::scene::{garden, lantern};
use potamoi_golden::splats::{self, Profile};
use potamoi_golden::units::Units;
use potamoi_golden::voxels::{self, MVoxels};

/// The splats of `garden`.
pub(crate) fn garden_through(units: &mut dyn Units, side: u32) -> Result<(), String> {
    let camera = garden::camera().resized(side, side);
    let options = splats::FixedOptions::default();
    splats::render_fixed(&garden::cloud(), &camera, Profile::Inria, &options, units)
        .map(|_| ())
        .map_err(|e| e.to_string())
}

/// The voxels of `lantern`.
pub(crate) fn lantern_through(
    units: &mut dyn Units,
    config: &Config,
    side: u32,
) -> Result<(), String> {
    let grid = lantern::lantern().unwrap();
    let mvoxels = MVoxels::new(&grid, config).unwrap();
    let options = voxels::FixedOptions::default();
    let camera = lantern::camera(side, side);
    voxels::render_fixed(&grid, &mvoxels, &camera, &options, units)
        .map(|_| ())
        .map_err(|e| e.to_string())
}
