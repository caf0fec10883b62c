//! Names of the effects of rendering, and which of them are carried out whatever a scene calls
//! for.
//!
//! An [`Effect`] is a piece of work that not every scene and camera path needs. Renderers carry
//! out what is called for, what is forced, and nothing that is left out ([`Choices`]).
//!
//! Leaving out an effect that is not called for changes no bit of a picture, of a trace or of a
//! modelled cycle count; forcing it changes none either, and takes longer.

mod choices;

use std::fmt;

pub use choices::{Choices, UnknownEffect};

/// A piece of work that not every scene and camera path needs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Effect {
    /// Weighted sums of several vertices: the reducers.
    Trilinear,
    /// Exponentials, of opacity above all: the vector unit.
    Exponential,
    /// Spherical harmonics of this degree, 1 to 3.
    SphericalHarmonics(u8),
    /// Perceptrons whose colours depend on the direction.
    ViewMlp,
    /// Levels of a hash grid whose vertices share entries.
    HashLevels,
    /// More channels than are read in one pass.
    Segments,
    /// Gaussians in another order than they are stored in.
    Sorting,
    /// Rays that end before they have passed everything.
    EarlyTermination,
    /// Frames that are warped from references.
    Warping,
    /// Pixels of warped frames that their reference does not show.
    Disocclusion,
    /// Samples that are left out since nothing is there.
    VoidTest,
    /// Cells of splats that share an MVoxel.
    OctreeMerging,
    /// A renderer elsewhere.
    RemoteLink,
    /// Rows that are fetched one by one.
    RandomDram,
}

impl Effect {
    /// All.
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

    /// Its name; spherical harmonics of all degrees have one.
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

    /// The degree of spherical harmonics.
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

/// The name, of spherical harmonics with their degree.
impl fmt::Display for Effect {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())?;
        match self.degree() {
            Some(degree) => write!(f, ":{degree}"),
            None => Ok(()),
        }
    }
}
