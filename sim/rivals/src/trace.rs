//! The counted work of a frame.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Class of algorithms, by which a rival says what it renders.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Class {
    /// Gaussians, projected and composited.
    Splats,
    /// Tables of several levels, hashed or not, read at samples along rays (Instant-NGP).
    HashGrid,
    /// Stored voxels, planes or another table that is read at samples along rays.
    Grid,
}

impl Class {
    /// Its name in tables.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Splats => "splats",
            Self::HashGrid => "hash grids",
            Self::Grid => "other fields",
        }
    }
}

/// A count of a trace.
#[derive(Debug, Clone, Copy)]
pub struct Count {
    /// Name in files.
    pub name: &'static str,
    /// What is counted, in a frame.
    pub meaning: &'static str,
}

const fn count(name: &'static str, meaning: &'static str) -> Count {
    Count { name, meaning }
}

/// All counts. A trace has those of its class.
pub const COUNTS: [Count; 17] = [
    count("pixels", "pixels of the picture"),
    count("gaussians", "Gaussians of the model"),
    count("visible", "Gaussians that touch a tile"),
    count("pairs", "pairs of a Gaussian and a tile of 16 x 16 pixels"),
    count(
        "tile-pixels",
        "pairs of a Gaussian and a pixel that is not yet opaque, in the Gaussian's tiles",
    ),
    count(
        "subtile-pixels",
        "tile-pixels in the subtiles of 8 x 8 pixels that the box of three standard deviations along the Gaussian's axes meets",
    ),
    count(
        "drawn-pixels",
        "pairs of a Gaussian and a pixel that it draws on",
    ),
    count("samples", "samples whose features are gathered"),
    count("looks", "places along rays that are looked at"),
    count("sample-levels", "samples times the tables that each reads"),
    count(
        "vertices",
        "vectors read at samples, in pixel-centric order",
    ),
    count(
        "entry-vertices",
        "vectors read at samples in memory-centric order, once for each MVoxel of a sample",
    ),
    count(
        "streamed-bytes",
        "bytes of MVoxels and RIT entries, read in memory order",
    ),
    count("table-bytes", "bytes of all tables of the model"),
    count(
        "array-cycles-24",
        "cycles of one weight-stationary array of 24 x 24",
    ),
    count(
        "array-cycles-32",
        "cycles of one weight-stationary array of 32 x 32",
    ),
    count(
        "array-cycles-64",
        "cycles of one weight-stationary array of 64 x 64",
    ),
];

/// The counted work of a frame.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Trace {
    /// What is rendered, for messages.
    pub scene: String,
    /// Class of its algorithm.
    pub class: Class,
    /// Counts by name, see [`COUNTS`].
    pub counts: BTreeMap<String, f64>,
}

impl Trace {
    /// A digest of class and counts, in hexadecimal. The name takes no part.
    #[must_use]
    pub fn digest(&self) -> String {
        let mut text = format!("{}\n", self.class.name());
        for (name, value) in &self.counts {
            // Writing to a string does not fail.
            let _ = writeln!(text, "{name} {value:e}");
        }
        blake3::hash(text.as_bytes()).to_hex()[..32].to_owned()
    }
}
