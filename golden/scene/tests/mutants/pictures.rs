//! Small pictures of every scene that is read, all of finite numbers.

use potamoi_base::camera::Camera;
use potamoi_base::precision::Models;
use potamoi_formats::config::{Config, PRESETS};
use potamoi_reference::ReferenceUnits;
use potamoi_scene::Scene;

use crate::frame::{Files, is_thorough};

/// A file alone.
pub(crate) fn single(name: &str, bytes: Vec<u8>) -> Files {
    vec![(name.to_owned(), bytes)]
}

/// Renders 8 x 8 pixels in both arithmetics, of fields 4 x 4 or, unless mutants are many, 2 x 2 in
/// floating point alone. A model that is too much for the formats is refused by name.
pub(crate) fn picture(mut scene: Scene) -> Result<(), String> {
    camera(scene.camera())?;
    let is_field = scene.model().numbers() == Models::Fields;
    let side = match (is_field, is_thorough()) {
        (false, _) => 8,
        (true, true) => 4,
        (true, false) => 2,
    };
    scene
        .set_size(Some(side), Some(side))
        .map_err(|e| e.to_string())?;
    let check =
        |rgb: &[[f32; 3]], what: &str| match rgb.as_flattened().iter().find(|v| !v.is_finite()) {
            Some(value) => Err(format!("a pixel is {value} in {what}")),
            None => Ok(()),
        };
    let float = scene
        .render_float()
        .map_err(|e| format!("it cannot be rendered: {e}"))?;
    check(&float.picture.rgb, "float")?;
    if is_field && !is_thorough() {
        return Ok(());
    }
    let preset = scene.model().preset();
    let (_, text) = PRESETS
        .iter()
        .find(|(name, _)| *name == preset)
        .expect("a preset");
    let config = Config::from_toml(text, preset).expect("a preset");
    match scene.render_fixed(&config, &mut ReferenceUnits::new(&config)) {
        Ok(fixed) => check(&fixed.picture.rgb, "fixed"),
        Err(error) => {
            let error = error.to_string();
            let told = error.contains(scene.name()) && error.len() < crate::frame::TOLD;
            told.then_some(()).ok_or(error)
        }
    }
}

/// Sizes in range, positive focal lengths, finite rays of unit length.
pub(crate) fn camera(camera: &Camera) -> Result<(), String> {
    let sides = 1..=32_768;
    let mut right = sides.contains(&camera.width) && sides.contains(&camera.height);
    right &= camera.focal.is_finite() && camera.focal.min_element() > 0.0;
    for (x, y) in [
        (0, 0),
        (
            camera.width.saturating_sub(1),
            camera.height.saturating_sub(1),
        ),
    ] {
        let (origin, direction) = camera.ray(x, y);
        right &= origin.is_finite() && (direction.length() - 1.0).abs() < 1e-6;
    }
    right
        .then_some(())
        .ok_or_else(|| format!("a camera is {camera:?}"))
}
