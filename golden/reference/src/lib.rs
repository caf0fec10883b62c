//! The arithmetic that the renderers compute with: the [`Units`] trait, and bit-exact Rust models
//! ("twins") of the hardware units.
//!
//! ```
//! use potamoi_formats::config::Config;
//! use potamoi_formats::rit::{RitEntry, Vertices};
//! use potamoi_reference::{GatherTask, Twins, Units, weights};
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
//! Twins::new(&config).gather(&[task], &mut features).unwrap();
//! assert_eq!(features, [40]);
//! ```

mod altered;
pub mod bounds;
pub mod exact_exponential;
pub mod exp;
#[cfg(test)]
mod exp_tests;
pub mod gather;
mod logarithms;
pub mod logistic;
pub mod observer;
pub mod one_minus;
pub mod reference_units;
pub mod streams;
pub mod trace_recorder;
pub mod vu;
pub mod weights;
pub mod widths;

use potamoi_formats::rit::{RitEntry, Vertices};
use potamoi_formats::units::VectorOp;

pub use altered::Altered;
pub use reference_units::{Twins, UnitCounts};

/// What the gathering unit does for one MVoxel: the rows that are loaded and
/// the entries that read them.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct GatherTask {
    /// Vertices an entry.
    pub vertices: Vertices,
    /// Channels of a feature, `C`. More than `B` of them take several segments.
    pub channels: usize,
    /// Features, `rows.len() / channels` rows of `channels` codes each.
    pub rows: Vec<i16>,
    /// Entries, in issue order. At least one.
    pub entries: Vec<RitEntry>,
}

/// A product of an M x K matrix of inputs with a K x N matrix of weights: work of the MAC
/// array. Inner products of vectors of which each is used once have one column.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Product {
    /// M: rows of inputs, one a sample or pixel.
    pub rows: u64,
    /// K: what is summed over.
    pub depth: u64,
    /// N: columns of weights, one a neuron.
    pub columns: u64,
}

impl Product {
    /// Multiplications that it asks for.
    #[must_use]
    pub const fn operations(&self) -> u64 {
        self.rows * self.depth * self.columns
    }
}

/// A unit refused its input or failed.
pub type UnitError = Box<dyn std::error::Error + Send + Sync>;

/// Units that gather features and compute element by element. The twins are
/// one implementation, the Verilated hardware another.
///
/// No call has a default body: units around other units that forgot one would drop
/// or miscount its work without a word.
pub trait Units {
    /// Gathers MVoxel after MVoxel. Appends, for every task and every entry in
    /// order, `channels` feature codes to `features`.
    ///
    /// # Errors
    /// The unit refused a task or failed.
    fn gather(&mut self, tasks: &[GatherTask], features: &mut Vec<i16>) -> Result<(), UnitError>;

    /// Gathers as [`Units::gather`] but appends unrounded sums, in units of 2^-W:
    /// those of the entries of a sample that lies in several MVoxels add up.
    ///
    /// # Errors
    /// As [`Units::gather`]; units of another configuration than
    /// `gu.sums = "exact"` have none.
    fn sums(&mut self, tasks: &[GatherTask], sums: &mut Vec<i32>) -> Result<(), UnitError>;

    /// Computes `out[i] = op(a[i], b[i])`. All slices have one length.
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

    /// Tells of a product that the MAC array computes, whose results the renderer finds
    /// itself.
    fn multiplied(&mut self, product: Product);
}
