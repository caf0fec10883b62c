//! Built-in scenes and their representations.

use glam::DVec3;

use super::built_models::BUILT;
use super::ready_models::Representation;
use super::{Model, Scene, SceneError, garden};
use potamoi_analytic::{Analytic, lantern};
use potamoi_base::file_keys::told;

/// Default side of a picture in pixels.
pub(super) const SIDE: u32 = 400;

/// Names of the built-in scenes: splats, voxels, and the fields of [`Analytic`].
pub const BUILTIN: [&str; 10] = [
    "garden", "lantern", "cairn", "vase", "lattice", "mist", "moons", "chrome", "gallery", "city",
];

impl Scene {
    /// A built-in scene by name. The name of an analytic scene may be followed by a colon and a
    /// [`Representation`]. `None` for any other name.
    pub(super) fn builtin(name: &str) -> Option<Result<Self, SceneError>> {
        let (scene, representation) = match name.split_once(':') {
            Some((scene, representation)) => (scene, Some(representation)),
            None => (name, None),
        };
        let known = BUILTIN.contains(&scene);
        known.then(|| Self::represented(name, scene, representation))
    }

    /// A built-in scene by the names of scene and representation.
    pub(super) fn represented(
        name: &str,
        scene: &str,
        representation: Option<&str>,
    ) -> Result<Self, SceneError> {
        let Some(analytic) = Analytic::named(scene) else {
            if let Some(found) = representation {
                return Err(SceneError::Value {
                    scene: told(name),
                    field: "representation",
                    value: told(found),
                    expected: format!("none: {} has its own", told(scene)),
                });
            }
            return Self::drawn(scene);
        };
        let wanted = representation.unwrap_or(Representation::ALL[0].name());
        let all = Representation::of(analytic);
        let found = all.iter().copied().find(|r| r.name() == wanted);
        let found = found.ok_or_else(|| SceneError::Value {
            scene: told(name),
            field: "representation",
            value: told(wanted),
            expected: all.iter().map(|r| r.name()).collect::<Vec<_>>().join(", "),
        })?;
        let camera = analytic.camera(0.0, SIDE, SIDE);
        let build = || found.model(analytic);
        let model = match found.is_full_size() {
            true => build()?.into(),
            false => BUILT.get(&format!("{scene}:{}", found.name()), build)?,
        };
        let background = analytic.background();
        Ok(Self {
            truth: Some(analytic),
            ..Self::of(name, model, camera, DVec3::Z, background)
        })
    }

    /// A built-in scene that has no analytic field.
    fn drawn(name: &str) -> Result<Self, SceneError> {
        Ok(match name {
            "garden" => {
                let camera = garden::camera().resized(SIDE, SIDE);
                let model = BUILT.get(name, || Ok(Model::Splats(garden::cloud())))?;
                Self::of(name, model, camera, DVec3::Y, garden::BACKGROUND)
            }
            "lantern" => {
                let camera = lantern::camera(SIDE, SIDE);
                let model = BUILT.get(name, || Ok(Model::Field(lantern::lantern()?.into())))?;
                Self::of(name, model, camera, DVec3::Z, lantern::BACKGROUND)
            }
            _ => return Err(Self::unknown(name)),
        })
    }
}
