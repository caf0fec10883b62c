//! Report texts for work that no unit with verified RTL does.

/// Compositing sums and early termination of fields, and of splats without a splat unit.
pub const COMPOSITING: &str =
    "sums of weighted colours and where rays stop: exact integers in Rust";
/// Indexing of fields.
pub const INDEXING: &str =
    "sample positions, their cells and weights: floating point, as on the GPU, rounded once";
/// The ray index table for the gathering unit.
pub const RIT: &str =
    "the ray index table and the order of its MVoxels: written in Rust, as by the GPU";
/// Perceptrons in 16 bits.
pub const PERCEPTRONS: &str = "perceptrons: the MAC array's formats by their twin, no RTL";
/// Products of planes and lines.
pub const MATRIX: &str = "the products' sums and the matrix behind them: the MAC array's formats by \
                      their twin, no RTL";
/// Sines and cosines of the viewing direction.
pub const WAVES: &str = "sines and cosines of the viewing direction: floating point, rounded once";
/// Sines and cosines of features.
pub const FEATURE_WAVES: &str = "sines and cosines of features: a table in Rust, no RTL";
/// Spherical harmonics of the viewing direction.
pub const HARMONICS: &str =
    "spherical harmonics of the viewing direction: floating point, rounded once";
/// Indices of hashed levels.
pub const HASHES: &str = "indices of hashed levels: Rust, as on the GPU";
/// The mask of empty space.
pub const MASK: &str = "the mask of empty space: Rust, as on the GPU";
/// The occupancy grid, another form of the mask.
pub const OCCUPANCY: &str = "the occupancy grid: Rust, as on the GPU";
/// Tree nodes, another form of the mask.
pub const NODES: &str = "nodes of the tree's coarse cells: Rust, as on the GPU";
/// Colours from spherical harmonics.
pub const COEFFICIENTS: &str =
    "sums of harmonics times coefficients: exact integers in Rust, no RTL";
/// Partial sums of samples that several MVoxels share.
pub const PARTS: &str = "sums of samples that several MVoxels share: the reducers' arithmetic in Rust, except \
                     where the unit has exact sums";
