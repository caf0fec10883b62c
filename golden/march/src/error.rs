//! Errors of ray marching.

use thiserror::Error;

use potamoi_reference::UnitError;

/// A grid, camera, option or configuration that cannot be rendered, or a unit that failed.
#[derive(Debug, Error)]
pub enum MarchError {
    /// The grid is invalid.
    #[error("voxel grid: {field} is {value}: expected {expected}")]
    Grid {
        /// The field.
        field: &'static str,
        /// Its value.
        value: String,
        /// Allowed values.
        expected: String,
    },
    /// The camera is invalid.
    #[error("camera: {field} is {value}: expected {expected}")]
    Camera {
        /// The field.
        field: &'static str,
        /// Its value.
        value: String,
        /// Allowed values.
        expected: &'static str,
    },
    /// An option is outside its range.
    #[error("option `{field}` is {value}: expected {expected}")]
    Option {
        /// The option.
        field: &'static str,
        /// Its value.
        value: String,
        /// Allowed values.
        expected: &'static str,
    },
    /// The hardware of this configuration cannot render the field.
    #[error("configuration: `{field}` is {value}: voxels need {expected}")]
    Config {
        /// The field.
        field: &'static str,
        /// Its value.
        value: String,
        /// Allowed values.
        expected: String,
    },
    /// A unit refused its input or failed.
    #[error("a unit failed: {0}")]
    Unit(UnitError),
    /// The gathering unit returned a wrong number of features.
    #[error("the gathering unit returned {found} feature channels, expected {expected}")]
    Features {
        /// Channels that it returned.
        found: usize,
        /// Channels of all entries together.
        expected: usize,
    },
}
