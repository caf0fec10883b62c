//! Radiance fields that are sampled along rays, in the paper's three stages:
//! *Indexing* says where a sample lies in the tables of the field, *Gathering*
//! interpolates their vertices, *Feature computation* makes density and colour
//! of what was gathered.
//!
//! A field brings its tables, the first and the last stage; gathering is the
//! same for all of them, and is what the gathering unit does.
//!
//! # Example
//!
//! A white ball in a grid of 16 vertices along each axis, before black: where rays meet it they see
//! it, elsewhere nothing.
//!
//! ```
//! use glam::DVec3;
//! use potamoi_base::camera::Camera;
//! use potamoi_fields::voxels::{FloatOptions, Grid, Layout, render_float};
//!
//! let (corner, edge) = (DVec3::splat(-1.0), 2.0 / 15.0);
//! let ball = Grid::bake([16; 3], corner, edge, Layout::Constant, |at, vertex| {
//!     // Density, then linear RGB.
//!     vertex[0] = if at.length() < 0.5 { 50.0 } else { 0.0 };
//!     vertex[1..].fill(1.0);
//! })?;
//! let eye = DVec3::new(0.0, 0.0, -4.0);
//! let camera = Camera::look_at(eye, DVec3::ZERO, DVec3::Y, 0.5, 9, 9);
//! let frame = render_float(&ball, &camera, &FloatOptions::default())?;
//! let [middle, corner] = [4 * 9 + 4, 0].map(|pixel| frame.picture.rgb[pixel][0]);
//! assert!(middle > 0.99 && corner == 0.0);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod algorithm;
pub mod algorithms;
mod batches;
mod bound;
mod calibrate;
mod coded;
mod codes;
mod directions;
mod early_termination;
mod error;
mod everywhere;
mod file;
mod fixed;
pub mod gather_plan;
mod hash;
mod hashed_colour;
pub mod mac;
#[cfg(test)]
mod made;
mod march;
mod mlp;
mod opacity;
pub mod outside;
mod ray_lengths;
mod ray_stages;
mod shape;
mod snapshot_error;
mod table;
mod two_level_grid;
pub mod voxels;
mod work;

use std::fmt;
use std::ops::Deref;
use std::sync::Arc;

use glam::DVec3;
use potamoi_formats::config::Config;
use serde::{Serialize, Serializer};

use potamoi_base::camera::Camera;
use potamoi_reference::bounds::VectorBounds;

pub use algorithm::{Algorithm, Size};
pub use batches::{BatchSize, SampleBatches};
pub use bound::{Bounds, Off, error_bounds};
pub use coded::{Coded, CodedVolume, Storage};
pub use directions::Directions;
pub use early_termination::Stopping;
pub use error::FieldError;
pub use file::{FieldFile, FileOptions, LoadedField};
pub use fixed::FixedField;
pub use hash::HashUnit;
pub use hashed_colour::{FixedColour, HashedColour};
pub use march::{FieldFrame, render_float, render_masked};
pub use mlp::{Layer, Mlp};
pub use ray_lengths::Stops;
pub use ray_stages::RayStages;
pub use shape::TableShape;
pub use snapshot_error::SnapshotError;
pub use table::Table;
pub use two_level_grid::Nodes;
pub use work::{FieldWork, FixedOptions};

/// A radiance field.
pub trait Field: Sync {
    /// What is said of all models of its algorithm.
    fn algorithm(&self) -> &'static Algorithm;

    /// What is gathered from, in the order in which features follow one
    /// another.
    fn tables(&self) -> &[Table];

    /// Indexing: where a point of the world lies in each table, in vertices
    /// from its first one, one place a table.
    fn place(&self, at: DVec3, places: &mut [DVec3]);

    /// Whether the field may be anything at a point of the world; it is known
    /// to be empty elsewhere.
    fn holds(&self, at: DVec3) -> bool;

    /// Both: `false` where the field is known to be empty; the places are then
    /// not set.
    fn index(&self, at: DVec3, places: &mut [DVec3]) -> bool {
        let holds = self.holds(at);
        if holds {
            self.place(at, places);
        }
        holds
    }

    /// Feature computation, of every sample: the optical depth of one step, 0
    /// and up.
    fn depth(&self, features: &[f64]) -> f64;

    /// Feature computation, of samples that are seen: the colour towards a
    /// unit direction. `scratch` is kept from sample to sample.
    fn colour(&self, features: &[f64], direction: DVec3, scratch: &mut Vec<f64>) -> DVec3;

    /// Where samples lie and which of them count.
    fn sampling(&self) -> Sampling;

    /// Formats and feature computation of the hardware.
    ///
    /// # Errors
    /// A field that is rendered in floating point alone, a configuration whose
    /// units lack what it needs, or values that no format holds.
    fn coded(&self, _: &Config) -> Result<Coded<'_>, FieldError> {
        Err(FieldError::FloatOnly)
    }

    /// What opacities and colours may be off by in those formats, seen by a camera; nothing where
    /// none is derived.
    ///
    /// # Errors
    /// As [`Field::coded`].
    fn bounds(
        &self,
        _: &Config,
        _: &VectorBounds,
        _: &Camera,
    ) -> Result<Option<Box<dyn Bounds + '_>>, FieldError> {
        Ok(None)
    }

    /// All perceptrons that its features go through.
    fn perceptrons(&self) -> Vec<&Mlp> {
        vec![]
    }

    /// How colours depend on the direction.
    fn directions(&self) -> Directions<'_> {
        Directions::None
    }

    /// Cells of a grid that says where nothing is: those where nothing is, and all; none where
    /// there is no such grid.
    fn void(&self) -> Option<[u64; 2]> {
        None
    }

    /// The field as one whose samples are told in voxel edges, where they are.
    fn stepped(&self) -> Option<&dyn Stepped> {
        None
    }

    /// What its file does not say and was taken instead.
    fn assumed(&self) -> Option<String> {
        None
    }

    /// Features of a sample: the sum of the tables' channels.
    fn channels(&self) -> usize {
        self.tables().iter().map(Table::channels).sum()
    }
}

/// A field whose samples are so many voxel edges apart.
pub trait Stepped {
    /// The same field with a sample every `step` voxel edges.
    fn with_step(&self, step: f64) -> AnyField;
}

/// A field of which all numbers can be hashed.
trait Stored: Field + Send {
    fn content(&self) -> blake3::Hash;
}

impl<T: Field + Send + Serialize> Stored for T {
    fn content(&self) -> blake3::Hash {
        potamoi_base::content::hash_of(self)
    }
}

/// A field of any kind. Clones share it, and fields are equal whose algorithms and numbers are.
#[derive(Clone)]
pub struct AnyField {
    field: Arc<dyn Stored + Send>,
}

impl Serialize for AnyField {
    /// Its algorithm, and a hash of its numbers in their place.
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        (self.algorithm().name, self.field.content().as_bytes()).serialize(to)
    }
}

impl AnyField {
    /// Takes a field.
    #[must_use]
    pub fn new(field: impl Field + Send + Serialize + 'static) -> Self {
        Self {
            field: Arc::new(field),
        }
    }
}

impl Deref for AnyField {
    type Target = dyn Field + Send;

    fn deref(&self) -> &Self::Target {
        &*self.field
    }
}

impl PartialEq for AnyField {
    fn eq(&self, other: &Self) -> bool {
        let is_same = || {
            self.algorithm().name == other.algorithm().name
                && self.field.content() == other.field.content()
        };
        Arc::ptr_eq(&self.field, &other.field) || is_same()
    }
}

impl fmt::Debug for AnyField {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{} of {} tables",
            self.algorithm().name,
            self.tables().len()
        )
    }
}

/// Samples along a ray.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sampling {
    /// Corners of the box outside which nothing is, in the world.
    pub bounds: [DVec3; 2],
    /// From sample to sample, in the world.
    pub step: f64,
    /// Nearest and farthest sample; the farthest may be infinite.
    pub range: [f64; 2],
    /// How the range is measured.
    pub along: Along,
    /// Samples whose opacity is at most this are left out.
    pub least_opacity: f64,
    /// Samples whose weight in the pixel is at most this give it no colour.
    pub least_weight: f64,
    /// A ray stops once less than this is left of it.
    pub stop: f64,
}

/// How a distance from the camera is measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Along {
    /// Along the camera's axis: its depth.
    Axis,
    /// Along each ray.
    Ray,
}

/// `ln(1 + e^x)` without overflow or cancellation.
fn softplus(x: f64) -> f64 {
    x.max(0.0) + (-x.abs()).exp().ln_1p()
}
