//! Radiance fields that are sampled along rays, in the paper's three stages: *Indexing* locates a
//! sample in the tables of the field, *Gathering* interpolates the vertices of its cells, *Feature
//! computation* turns the gathered features into density and colour.
//!
//! A field defines its tables and its first and last stage. Gathering is the same for all fields,
//! and is the work of the gathering unit.
//!
//! # Example
//!
//! A white ball in a grid of 16 vertices along each axis, on a black background. Pixels in the
//! middle show it, pixels in the corners do not.
//!
//! ```
//! use glam::DVec3;
//! use potamoi_base::camera::Camera;
//! use potamoi_fields::render_float;
//! use potamoi_fields::voxels::{Grid, Layout, StoredField};
//!
//! let (corner, edge) = (DVec3::splat(-1.0), 2.0 / 15.0);
//! let ball = Grid::bake([16; 3], corner, edge, Layout::Constant, |at, vertex| {
//!     // Density, then linear RGB.
//!     vertex[0] = if at.length() < 0.5 { 50.0 } else { 0.0 };
//!     vertex[1..].fill(1.0);
//! })?;
//! let eye = DVec3::new(0.0, 0.0, -4.0);
//! let camera = Camera::look_at(eye, DVec3::ZERO, DVec3::Y, 0.5, 9, 9);
//! let frame = render_float(&StoredField::from(ball), &camera, [0.0; 3])?;
//! let [middle, corner] = [4 * 9 + 4, 0].map(|pixel| frame.picture.rgb[pixel][0]);
//! assert!(middle > 0.99 && corner == 0.0);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod algorithm;
pub mod algorithms;
mod batches;
mod bound;
mod calibrate;
mod colour_queue;
mod coordinate_frame;
mod density;
mod directions;
mod early_termination;
mod error;
mod file;
mod fixed;
mod float;
pub mod gather_plan;
mod hash;
mod hashed_colour;
mod layer_sums;
pub mod mac;
mod mlp;
mod opacity;
mod pixel;
mod quantisation;
mod quantised_field;
mod ray_lengths;
mod ray_stages;
mod ray_tile;
mod samples;
mod shape;
mod snapshot_error;
mod stored_density;
mod table;
#[cfg(test)]
mod test_checkpoints;
mod two_level_grid;
pub mod unverified_work;
pub mod volume;
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
pub use algorithms::voxels;
pub use batches::{BatchSize, SampleBatches};
pub use bound::{Bounds, ErrorInterval, error_bounds};
pub use coordinate_frame::{CoordinateFrame, Local};
pub use density::Density;
pub use directions::Directions;
pub use early_termination::WithEarlyTermination;
pub use error::FieldError;
pub use file::{FieldFile, FileOptions, LoadedField};
pub use fixed::FixedField;
pub use float::{FieldFrame, FloatOptions, render_float, render_masked};
pub use hash::HashUnit;
pub use hashed_colour::{FixedColour, HashedColour};
pub use mlp::{Layer, Mlp};
pub use quantised_field::{QuantisedField, Storage};
pub use ray_lengths::RayLengths;
pub use ray_stages::RayStages;
pub use shape::TableShape;
pub use snapshot_error::SnapshotError;
pub use stored_density::{Densities, StoredDensity};
pub use table::Table;
pub use two_level_grid::Nodes;
pub use volume::CodedVolume;
pub use work::{FieldWork, FixedOptions};

/// A radiance field in floating point, with an optional fixed-point form.
pub trait Field: Sync {
    /// The description that all models of its algorithm share.
    fn algorithm(&self) -> &'static Algorithm;

    /// The tables to gather from. The features of a sample are in the same order.
    fn tables(&self) -> &[Table];

    /// Indexing: the position of a world point in each table, in vertices from the table's first
    /// vertex. `places` has one element a table.
    fn place(&self, at: DVec3, places: &mut [DVec3]);

    /// Whether the field may be non-empty at a world point; `false` only where it is known to be
    /// empty.
    fn holds(&self, at: DVec3) -> bool;

    /// Both [`Field::holds`] and [`Field::place`]. If it returns `false`, `places` are not set.
    fn index(&self, at: DVec3, places: &mut [DVec3]) -> bool {
        let holds = self.holds(at);
        if holds {
            self.place(at, places);
        }
        holds
    }

    /// The length along a unit direction from a world point on which the field is known to be empty,
    /// or `None` where it may be non-empty. The length may be too short, down to 0.
    fn empty_for(&self, at: DVec3, _direction: DVec3) -> Option<f64> {
        (!self.holds(at)).then_some(0.0)
    }

    /// Feature computation for every sample: the optical depth of one step, at least 0.
    fn depth(&self, features: &[f64]) -> f64;

    /// Feature computation for visible samples: linear RGB seen along a unit direction. `scratch`
    /// is a buffer that is reused from sample to sample.
    fn colour(&self, features: &[f64], direction: DVec3, scratch: &mut Vec<f64>) -> DVec3;

    /// Number of values a sample from which colours are computed.
    fn kept(&self) -> usize {
        self.channels()
    }

    /// [`Field::depth`] of many samples: replaces `depths` by them, and `kept` by the values from
    /// which colours are computed. `features` has [`Field::channels`] values a sample.
    fn depths(&self, features: &[f64], depths: &mut Vec<f64>, kept: &mut Vec<f64>) {
        let samples = features.chunks_exact(self.channels().max(1));
        depths.clear();
        depths.extend(samples.map(|features| self.depth(features)));
        kept.clear();
        kept.extend_from_slice(features);
    }

    /// Number of values of an encoded direction.
    fn encoded(&self) -> usize {
        3
    }

    /// Appends what colours take from a viewing direction, which is computed once a ray.
    fn encode(&self, direction: DVec3, out: &mut Vec<f64>) {
        out.extend(direction.to_array());
    }

    /// [`Field::colour`] of many samples: replaces `out` by the colours. `kept` has [`Field::kept`] values a
    /// sample, those of [`Field::depths`], and `directions` has [`Field::encoded`].
    fn colours(&self, kept: &[f64], directions: &[f64], out: &mut Vec<DVec3>) {
        let mut scratch = vec![];
        out.clear();
        let samples = kept.chunks_exact(self.channels().max(1));
        for (features, direction) in samples.zip(directions.as_chunks::<3>().0) {
            out.push(self.colour(features, DVec3::from(*direction), &mut scratch));
        }
    }

    /// Positions of the samples, and thresholds.
    fn sampling(&self) -> Sampling;

    /// The field in the formats of the hardware, with its fixed-point feature computation.
    ///
    /// # Errors
    /// The field is rendered only in floating point, the configuration's units lack an operation
    /// or format, or a value fits no format.
    fn coded(&self, _: &Config) -> Result<QuantisedField<'_>, FieldError> {
        Err(FieldError::FloatOnly)
    }

    /// Error bounds of opacities and colours in these formats, for a camera; `None` if they are
    /// not derived.
    ///
    /// # Errors
    /// Those of [`Field::coded`].
    fn bounds(
        &self,
        _: &Config,
        _: &VectorBounds,
        _: &Camera,
    ) -> Result<Option<Box<dyn Bounds + '_>>, FieldError> {
        Ok(None)
    }

    /// All perceptrons of the feature computation.
    fn perceptrons(&self) -> Vec<&Mlp> {
        vec![]
    }

    /// The view dependence of colours.
    fn directions(&self) -> Directions<'_> {
        Directions::None
    }

    /// Empty cells and all cells of the grid that marks empty space; `None` if there is no such
    /// grid.
    fn void(&self) -> Option<[u64; 2]> {
        None
    }

    /// The field with a step in voxel edges, if it has one.
    fn stepped(&self) -> Option<&dyn Stepped> {
        None
    }

    /// The field as one whose densities are stored, if they are.
    fn stored(&self) -> Option<&dyn StoredDensity> {
        None
    }

    /// The field in units of its own, in which rays are followed in floating point, with the camera
    /// checked; `None` for world coordinates.
    ///
    /// # Errors
    /// The camera or the step is out of range.
    fn local(&self, _: &Camera) -> Result<Option<Local<'_>>, FieldError> {
        Ok(None)
    }

    /// The density at a world point, an optical depth per unit of length. A stored density is that
    /// before its ReLU, and may be below 0.
    fn density(&self, at: DVec3, sample: &mut Density) -> f64 {
        if !self.holds(at) {
            return 0.0;
        }
        self.depth(sample.gather(self, at)) / self.sampling().step
    }

    /// The value assumed for something that the file does not state.
    fn assumed(&self) -> Option<String> {
        None
    }

    /// Number of features of a sample: the sum of the tables' channels.
    fn channels(&self) -> usize {
        self.tables().iter().map(Table::channels).sum()
    }
}

/// A field whose step is measured in voxel edges.
pub trait Stepped {
    /// The same field with a step of `step` voxel edges.
    fn with_step(&self, step: f64) -> AnyField;
}

/// A field whose numbers can be hashed.
trait Hashed: Field + Send {
    fn content(&self) -> blake3::Hash;
}

impl<T: Field + Send + Serialize> Hashed for T {
    fn content(&self) -> blake3::Hash {
        potamoi_base::content_hash::hash_of(self)
    }
}

/// A field of any kind. Clones share it. Two fields are equal if their algorithms and numbers are.
#[derive(Clone)]
pub struct AnyField {
    field: Arc<dyn Hashed + Send>,
}

impl Serialize for AnyField {
    /// Writes the algorithm and a hash of the numbers.
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        (self.algorithm().name, self.field.content().as_bytes()).serialize(to)
    }
}

impl AnyField {
    /// Wraps a field.
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

/// Positions of samples along a ray, and thresholds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sampling {
    /// Corners of the box that contains the field, in world coordinates.
    pub bounds: [DVec3; 2],
    /// Distance between samples, in world units.
    pub step: f64,
    /// Distance of the nearest and the farthest sample; the latter may be infinite.
    pub range: [f64; 2],
    /// The direction along which `range` is measured.
    pub along: Along,
    /// Alpha threshold: samples of at most this opacity are skipped.
    pub least_opacity: f64,
    /// Weight threshold: the colour of samples of at most this weight is not computed.
    pub least_weight: f64,
    /// Early-termination threshold (transmittance).
    pub stop: f64,
}

/// The direction along which a distance from the camera is measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Along {
    /// Along the camera's axis: depth.
    Axis,
    /// Along each ray.
    Ray,
}

/// `ln(1 + e^x)` without overflow or cancellation.
fn softplus(x: f64) -> f64 {
    x.max(0.0) + (-x.abs()).exp().ln_1p()
}

/// `1 / (1 + e^-x)`.
fn sigmoid(x: f64) -> f64 {
    1.0 / (1.0 + (-x).exp())
}
