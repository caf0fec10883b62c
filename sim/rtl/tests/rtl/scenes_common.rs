//! Both built-in scenes through units, small.

use potamoi_analytic::lantern;
use potamoi_fields::voxels::StoredField;
use potamoi_fields::{FixedField, FixedOptions};
use potamoi_formats::config::Config;
use potamoi_reference::Units;
use potamoi_rtl::verify::Verifier;
use potamoi_scene::garden;
use potamoi_splats::{self as splats, Profile};

/// Sends work through a verifier, and waits for what it finds.
pub(crate) fn verified(
    verifier: &mut Verifier<'_>,
    work: impl FnOnce(&mut dyn Units) -> Result<(), String>,
) -> Result<(), String> {
    let done = work(verifier);
    let finished = verifier.finish();
    done.and(finished.map_err(|e| e.to_string()))
}

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
    let field = StoredField::from(lantern::lantern().unwrap());
    let made = FixedField::new(&field, config).unwrap();
    made.render(
        &lantern::camera(side, side),
        &FixedOptions::default(),
        units,
    )
    .map(|_| ())
    .map_err(|e| e.to_string())
}
