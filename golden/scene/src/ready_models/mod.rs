//! Ready-made models of the analytic scenes, one a representation: grids from samples, factors by
//! least squares, stored hash grids fitted to points, splats placed on surfaces and in fog, and
//! stored coded splats with a fitted colour field.

mod efficient;
mod full_size;
mod grids;
mod shade;
mod surfels;
#[cfg(test)]
mod tests;

use crate::compact_3dgs::Compact;
use crate::{Model, SceneError};
use grids::{dvgo, tensorf};
use potamoi_analytic::Analytic;
use potamoi_fields::algorithms::ngp::Ngp;
use potamoi_fields::{AnyField, FieldError};
use potamoi_gaussians::files::FileError;
pub use surfels::cloud;

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
    /// DirectVoxGO of the original's size.
    DvgoFull,
    /// TensoRF of the original's size.
    TensorfFull,
    /// Instant-NGP of the original's size.
    NgpFull,
    /// About 300,000 Gaussians, as of trained objects.
    Splats300k,
    /// About three million, as of trained photographs of places.
    Splats3m,
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

    /// With the originals' sizes: models for counts, whose pictures are not better.
    pub const FULL_SIZE: [Self; 5] = [
        Self::DvgoFull,
        Self::TensorfFull,
        Self::NgpFull,
        Self::Splats300k,
        Self::Splats3m,
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
            Self::DvgoFull => "dvgo-full",
            Self::TensorfFull => "tensorf-full",
            Self::NgpFull => "ngp-full",
            Self::Splats300k => "splats-300k",
            Self::Splats3m => "splats-3m",
        }
    }

    /// Whether it has the original's size.
    pub(super) fn is_full_size(self) -> bool {
        Self::FULL_SIZE.contains(&self)
    }

    /// The representations of a scene.
    pub(super) fn of(analytic: Analytic) -> Vec<Self> {
        let mut all = Self::ALL.to_vec();
        if analytic == HASHED_BY_MVOXEL {
            all.push(Self::NgpMVoxel);
        }
        all.extend(Self::FULL_SIZE);
        all
    }

    /// The model of a scene.
    pub(super) fn model(self, analytic: Analytic) -> Result<Model, SceneError> {
        Ok(match self {
            Self::Voxels => Model::Field(analytic.bake()?.into()),
            Self::Dvgo => Model::Field(AnyField::new(dvgo(&analytic.bake()?)?)),
            Self::Tensorf => Model::Field(AnyField::new(tensorf(&analytic.bake()?)?)),
            Self::Ngp => Model::Field(AnyField::new(ngp(analytic)?)),
            Self::Splats => Model::Splats(cloud(analytic, DISCS)?),
            Self::EfficientNerf => {
                Model::Field(AnyField::new(efficient::tree(analytic.sampler())?))
            }
            Self::Compact => Model::Compact(Box::new(compact(analytic)?)),
            Self::NgpMVoxel => Model::Field(AnyField::new(ngp_mvoxel()?)),
            Self::DvgoFull => Model::Field(AnyField::new(full_size::dvgo(analytic)?)),
            Self::TensorfFull => Model::Field(AnyField::new(full_size::tensorf(analytic)?)),
            Self::NgpFull => Model::Field(AnyField::new(ngp(analytic)?.full_size()?)),
            Self::Splats300k | Self::Splats3m => {
                let count = match self {
                    Self::Splats300k => 300_000,
                    _ => 3_000_000,
                };
                Model::Splats(full_size::replicated(&cloud(analytic, DISCS)?, count)?)
            }
        })
    }
}

/// Approximate maximum number of discs in a scene's splats.
pub(super) const DISCS: u32 = 90_000;

/// The stored Instant-NGP snapshot of a scene.
fn snapshot(scene: Analytic) -> &'static [u8] {
    match scene {
        Analytic::Cairn => include_bytes!("../../../models/cairn.ingp"),
        Analytic::Vase => include_bytes!("../../../models/vase.ingp"),
        Analytic::Lattice => include_bytes!("../../../models/lattice.ingp"),
        Analytic::Mist => include_bytes!("../../../models/mist.ingp"),
        Analytic::Moons => include_bytes!("../../../models/moons.ingp"),
        Analytic::Chrome => include_bytes!("../../../models/chrome.ingp"),
        Analytic::Gallery => include_bytes!("../../../models/gallery.ingp"),
        Analytic::City => include_bytes!("../../../models/city.ingp"),
    }
}

/// The fitted hash grid of a scene.
pub(super) fn ngp(scene: Analytic) -> Result<Ngp, FieldError> {
    Ngp::from_bytes(&format!("{}.ingp", scene.name()), snapshot(scene))
}

/// The scene that also has a hash grid fitted by MVoxel.
pub(super) const HASHED_BY_MVOXEL: Analytic = Analytic::Cairn;

/// The fitted hash grid of [`HASHED_BY_MVOXEL`] whose entries are MVoxels.
pub(super) fn ngp_mvoxel() -> Result<Ngp, FieldError> {
    let stored = include_bytes!("../../../models/cairn-mvoxel.ingp");
    Ngp::from_bytes("cairn-mvoxel.ingp", stored)
}

/// The stored Compact-3DGS model of a scene.
fn coded(scene: Analytic) -> &'static [u8] {
    match scene {
        Analytic::Cairn => include_bytes!("../../../models/cairn.npz"),
        Analytic::Vase => include_bytes!("../../../models/vase.npz"),
        Analytic::Lattice => include_bytes!("../../../models/lattice.npz"),
        Analytic::Mist => include_bytes!("../../../models/mist.npz"),
        Analytic::Moons => include_bytes!("../../../models/moons.npz"),
        Analytic::Chrome => include_bytes!("../../../models/chrome.npz"),
        Analytic::Gallery => include_bytes!("../../../models/gallery.npz"),
        Analytic::City => include_bytes!("../../../models/city.npz"),
    }
}

/// The coded splats of a scene.
pub(super) fn compact(scene: Analytic) -> Result<Compact, FileError> {
    Compact::parse(coded(scene), &format!("{}.npz", scene.name()), None).map(|(model, _)| model)
}
