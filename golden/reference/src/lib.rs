//! The arithmetic that the renderers compute with: the [`Units`] trait, and the reference units,
//! bit-exact Rust models of the hardware.
//!
//! ```
//! use potamoi_formats::config::Config;
//! use potamoi_formats::rit::{RitEntry, Vertices};
//! use potamoi_reference::{GatherTask, ReferenceUnits, Units, weights};
//!
//! // Eight vertices with one channel each; a sample in the middle of their cell.
//! let config = Config::paper();
//! let task = GatherTask {
//!     vertices: Vertices::Eight,
//!     channels: 1,
//!     rows: vec![0, 80, 0, 80, 0, 80, 0, 80],
//!     entries: vec![RitEntry {
//!         slot: 0,
//!         rows: [0, 1, 2, 3, 4, 5, 6, 7],
//!         weights: weights::trilinear([1 << 11; 3], config.gu.weight_bits),
//!     }],
//! };
//! let mut features = vec![];
//! ReferenceUnits::new(&config).gather(&[task], &mut features).unwrap();
//! assert_eq!(features, [40]);
//! ```

mod ablation;
pub mod bounds;
pub mod exact_exponential;
mod exp_table;
pub mod exponential;
pub mod gathering_unit;
mod logarithms;
pub mod logistic;
pub mod observer;
pub mod one_minus;
pub mod reference_units;
pub mod splat_unit;
pub mod streams;
pub mod trace_recorder;
pub mod vector_unit;
pub mod weights;
pub mod widths;

use potamoi_formats::rit::{RitEntry, Vertices};
use potamoi_formats::units::VectorOp;

use splat_unit::{Composited, SplatJob};

pub use ablation::AblatedUnits;
pub use reference_units::{ReferenceUnits, UnitCounts};

/// The gathering unit's work for one MVoxel: the loaded rows, and the entries that read them.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct GatherTask {
    /// Vertices of each entry.
    pub vertices: Vertices,
    /// Channels of a feature, `C`. More than the unit's `B` channels take several segments.
    pub channels: usize,
    /// Feature codes: `rows.len() / channels` rows of `channels` codes each.
    pub rows: Vec<i16>,
    /// Entries, in issue order. At least one.
    pub entries: Vec<RitEntry>,
}

/// The dimensions of a product in the MAC array: an M x K matrix of inputs times a K x N matrix of
/// weights. Inner products of vectors that are used once have one column.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Product {
    /// M: rows of inputs, one for each sample or pixel.
    pub rows: u64,
    /// K: the length of each sum.
    pub depth: u64,
    /// N: columns of weights, one for each neuron.
    pub columns: u64,
}

impl Product {
    /// Number of multiplications, M x K x N.
    #[must_use]
    pub const fn operations(&self) -> u64 {
        self.rows * self.depth * self.columns
    }
}

/// A unit refused its input or failed.
pub type UnitError = Box<dyn std::error::Error + Send + Sync>;

/// Units that gather features, compute element by element, and composite splats. The twins are one implementation,
/// the Verilated hardware another.
///
/// No method has a default body: a wrapper that forgot one would silently drop or miscount its
/// work.
pub trait Units {
    /// Gathers MVoxel after MVoxel. Appends `channels` feature codes for every entry of every
    /// task, in order, to `features`.
    ///
    /// # Errors
    /// The unit refused a task or failed.
    fn gather(&mut self, tasks: &[GatherTask], features: &mut Vec<i16>) -> Result<(), UnitError>;

    /// As [`Units::gather`], but appends unrounded sums in units of 2^-W. The sums of a sample's
    /// entries in several MVoxels add up.
    ///
    /// # Errors
    /// Those of [`Units::gather`], or the configuration does not have `gu.sums = "exact"`.
    fn sums(&mut self, tasks: &[GatherTask], sums: &mut Vec<i32>) -> Result<(), UnitError>;

    /// Computes `out[i] = op(a[i], b[i])`. All slices must have the same length.
    ///
    /// # Errors
    /// The unit refused the operation or failed.
    fn vector(
        &mut self,
        op: VectorOp,
        a: &[i32],
        b: &[i32],
        out: &mut [i32],
    ) -> Result<(), UnitError>;

    /// Composites the entries of a ray group on clear tiles.
    ///
    /// # Errors
    /// The configuration has no splat unit, the job has more tiles than the unit holds, or the unit
    /// failed.
    fn splats(&mut self, job: &SplatJob<'_>) -> Result<Composited, UnitError>;

    /// Reports a product of the MAC array. Its results are computed by the renderer itself.
    fn multiplied(&mut self, product: Product);
}
