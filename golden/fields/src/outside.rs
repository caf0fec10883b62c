//! Work that no unit with verified RTL does, in words for reports.

/// Sums and stops of the renderers of fields and splats.
pub const COMPOSITING: &str =
    "sums of weighted colours and where rays stop: exact integers in Rust";
/// Indexing of fields.
pub const INDEXING: &str =
    "sample positions, their cells and weights: floating point, as on the GPU, rounded once";
/// Written for the gathering unit.
pub const RIT: &str =
    "the ray index table and the order of its MVoxels: written in Rust, as by the GPU";
/// In 16 bits.
pub const PERCEPTRONS: &str = "perceptrons: the MAC array's formats by their twin, no RTL";
/// Products of planes and lines.
pub const MATRIX: &str = "the products' sums and the matrix behind them: the MAC array's formats by \
                      their twin, no RTL";
/// Of the viewing direction.
pub const WAVES: &str = "sines and cosines of the viewing direction: floating point, rounded once";
/// Of features.
pub const FEATURE_WAVES: &str = "sines and cosines of features: a table in Rust, no RTL";
/// Of the viewing direction.
pub const HARMONICS: &str =
    "spherical harmonics of the viewing direction: floating point, rounded once";
/// Of hashed levels.
pub const HASHES: &str = "indices of hashed levels: Rust, as on the GPU";
/// What is known to be empty.
pub const MASK: &str = "the mask of empty space: Rust, as on the GPU";
/// The same, as a grid of occupied cells.
pub const OCCUPANCY: &str = "the occupancy grid: Rust, as on the GPU";
/// The same, as a tree.
pub const NODES: &str = "nodes of the tree's coarse cells: Rust, as on the GPU";
/// Colours from spherical harmonics.
pub const COEFFICIENTS: &str =
    "sums of harmonics times coefficients: exact integers in Rust, no RTL";
/// Of MVoxels that share vertices or samples.
pub const PARTS: &str = "sums of samples that several MVoxels share: the reducers' arithmetic in Rust, except \
                     where the unit has exact sums";
