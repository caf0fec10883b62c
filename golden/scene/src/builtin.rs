//! Built-in scenes and their representations.

use glam::DVec3;

use super::{Model, Scene, SceneError, garden, lantern, ready_models as ready};
use potamoi_analytic::Analytic;
use potamoi_base::file_keys::told;
use potamoi_fields::AnyField;

/// Default side of a picture in pixels.
pub(super) const SIDE: u32 = 400;

/// Names of the built-in scenes: splats, voxels, and the fields of [`Analytic`].
pub const BUILTIN: [&str; 10] = [
    "garden", "lantern", "cairn", "vase", "lattice", "mist", "moons", "chrome", "gallery", "city",
];

/// The kind of model that represents an analytic scene.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Representation {
    /// A grid of densities and colours, sampled.
    Voxels,
    /// DirectVoxGO, sampled.
    Dvgo,
    /// TensoRF, with factors fitted to samples.
    Tensorf,
    /// Instant-NGP, fitted and stored in the program.
    Ngp,
    /// 3D Gaussians, placed on surfaces and in fog.
    Splats,
    /// A two-level tree of EfficientNeRF, sampled.
    EfficientNerf,
    /// Compact-3DGS: 3D Gaussians placed in the same way, coded, fitted and stored.
    Compact,
    /// Instant-NGP hashed by MVoxel, only of `cairn`.
    NgpMVoxel,
}

impl Representation {
    /// The representations of every scene; the first is the default.
    pub const ALL: [Self; 7] = [
        Self::Voxels,
        Self::Dvgo,
        Self::Tensorf,
        Self::Ngp,
        Self::Splats,
        Self::EfficientNerf,
        Self::Compact,
    ];

    /// Its name after a scene's name and a colon.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Voxels => "voxels",
            Self::Dvgo => "dvgo",
            Self::Tensorf => "tensorf",
            Self::Ngp => "ngp",
            Self::Splats => "splats",
            Self::EfficientNerf => "efficientnerf",
            Self::Compact => "compact",
            Self::NgpMVoxel => "ngp-mvoxel",
        }
    }

    /// The representations of a scene.
    fn of(analytic: Analytic) -> Vec<Self> {
        let mut all = Self::ALL.to_vec();
        if analytic == ready::HASHED_BY_MVOXEL {
            all.push(Self::NgpMVoxel);
        }
        all
    }

    fn model(self, analytic: Analytic) -> Result<Model, SceneError> {
        Ok(match self {
            Self::Voxels => Model::Voxels(Box::new(analytic.bake()?)),
            Self::Dvgo => Model::Field(AnyField::new(ready::dvgo(&analytic.bake()?)?)),
            Self::Tensorf => Model::Field(AnyField::new(ready::tensorf(&analytic.bake()?)?)),
            Self::Ngp => Model::Field(AnyField::new(ready::ngp(analytic)?)),
            Self::Splats => Model::Splats(ready::cloud(analytic, ready::DISCS)?),
            Self::EfficientNerf => Model::Field(AnyField::new(analytic.tree()?)),
            Self::Compact => Model::Compact(Box::new(ready::compact(analytic)?)),
            Self::NgpMVoxel => Model::Field(AnyField::new(ready::ngp_mvoxel()?)),
        })
    }
}

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
        let model = found.model(analytic)?;
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
                let model = Model::Splats(garden::cloud());
                Self::of(name, model, camera, DVec3::Y, garden::BACKGROUND)
            }
            "lantern" => {
                let camera = lantern::camera(SIDE, SIDE);
                let model = Model::Voxels(Box::new(lantern::lantern()?));
                Self::of(name, model, camera, DVec3::Z, lantern::BACKGROUND)
            }
            _ => return Err(Self::unknown(name)),
        })
    }
}
