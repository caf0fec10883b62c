//! What can go wrong between a voxel grid and its picture.

use thiserror::Error;

use potamoi_reference::UnitError;

/// A grid, a view or an option that cannot be rendered.
#[derive(Debug, Error)]
pub enum MarchError {
    /// A grid that is no grid.
    #[error("voxel grid: {field} is {value}: expected {expected}")]
    Grid {
        /// The field.
        field: &'static str,
        /// Its value.
        value: String,
        /// What would be right.
        expected: String,
    },
    /// A camera that sees nothing, or nothing sensible.
    #[error("camera: {field} is {value}: expected {expected}")]
    Camera {
        /// The field.
        field: &'static str,
        /// Its value.
        value: String,
        /// What would be right.
        expected: &'static str,
    },
    /// An option is outside its range.
    #[error("option `{field}` is {value}: expected {expected}")]
    Option {
        /// The option.
        field: &'static str,
        /// Its value.
        value: String,
        /// What would be right.
        expected: &'static str,
    },
    /// The hardware of this configuration cannot render voxels.
    #[error("configuration: `{field}` is {value}: voxels need {expected}")]
    Config {
        /// The field.
        field: &'static str,
        /// Its value.
        value: String,
        /// What would be right.
        expected: String,
    },
    /// A unit refused its input or failed.
    #[error("a unit failed: {0}")]
    Unit(UnitError),
    /// The gathering unit returned another number of features than entries.
    #[error("the gathering unit returned {found} feature channels, expected {expected}")]
    Features {
        /// Channels returned.
        found: usize,
        /// Channels of all entries.
        expected: usize,
    },
}
