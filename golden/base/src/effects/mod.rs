//! The effects of rendering, and their overrides.
//!
//! An [`Effect`] is a piece of work that not every scene and camera path needs. Renderers carry
//! out the effects that are needed or forced, except those that are left out ([`Choices`]).
//!
//! Leaving out an effect that is not needed changes no bit of a picture, a trace or a modelled
//! cycle count. Forcing it does not either, but takes longer.

mod choices;

use std::fmt;

pub use choices::{Choices, UnknownEffect};

/// A piece of work that not every scene and camera path needs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Effect {
    /// Weighted sums of several vertices, in the reducers.
    Trilinear,
    /// Exponentials, mainly of opacity, in the vector unit.
    Exponential,
    /// Spherical harmonics of this degree, 1 to 3.
    SphericalHarmonics(u8),
    /// Perceptrons whose colours depend on the direction.
    ViewMlp,
    /// Levels of a hash grid whose vertices share entries.
    HashLevels,
    /// More channels than one pass reads.
    Segments,
    /// Sorting of Gaussians that are not stored in depth order.
    Sorting,
    /// Early ray termination.
    EarlyTermination,
    /// Warping of frames from references.
    Warping,
    /// Rendering of pixels that the reference does not show.
    Disocclusion,
    /// Skipping of empty samples.
    VoidTest,
    /// Merging of splat cells in an MVoxel.
    OctreeMerging,
    /// Rendering of frames on a remote machine.
    RemoteLink,
    /// Random DRAM accesses: rows fetched one by one.
    RandomDram,
}

impl Effect {
    /// All effects.
    pub const ALL: [Self; 16] = [
        Self::Trilinear,
        Self::Exponential,
        Self::SphericalHarmonics(1),
        Self::SphericalHarmonics(2),
        Self::SphericalHarmonics(3),
        Self::ViewMlp,
        Self::HashLevels,
        Self::Segments,
        Self::Sorting,
        Self::EarlyTermination,
        Self::Warping,
        Self::Disocclusion,
        Self::VoidTest,
        Self::OctreeMerging,
        Self::RemoteLink,
        Self::RandomDram,
    ];

    /// Its name; spherical harmonics of all degrees share one.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Trilinear => "trilinear",
            Self::Exponential => "exponential",
            Self::SphericalHarmonics(_) => "spherical_harmonics",
            Self::ViewMlp => "view_mlp",
            Self::HashLevels => "hash_levels",
            Self::Segments => "segments",
            Self::Sorting => "sorting",
            Self::EarlyTermination => "early_termination",
            Self::Warping => "warping",
            Self::Disocclusion => "disocclusion",
            Self::VoidTest => "void_test",
            Self::OctreeMerging => "octree_merging",
            Self::RemoteLink => "remote_link",
            Self::RandomDram => "random_dram",
        }
    }

    /// The degree, for spherical harmonics.
    #[must_use]
    pub const fn degree(self) -> Option<u8> {
        match self {
            Self::SphericalHarmonics(degree) => Some(degree),
            _ => None,
        }
    }

    fn bit(self) -> u32 {
        let at = Self::ALL.iter().position(|effect| *effect == self);
        at.map_or(0, |at| 1 << at)
    }
}

/// The name, with the degree for spherical harmonics.
impl fmt::Display for Effect {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())?;
        match self.degree() {
            Some(degree) => write!(f, ":{degree}"),
            None => Ok(()),
        }
    }
}
