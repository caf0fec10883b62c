//! Errors of splat rendering.

use thiserror::Error;

use potamoi_reference::UnitError;

/// A camera or option that cannot be rendered, or a unit that failed.
#[derive(Debug, Error)]
pub enum RenderError {
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
    /// The Gaussians cover too many tiles for memory.
    #[error(
        "{entries} (tile, Gaussian) pairs, more than {limit}: use a smaller picture, \
         or a scene with fewer Gaussians that fill the frame"
    )]
    TooManyEntries {
        /// Number of pairs at which counting stopped.
        entries: u64,
        /// Maximum number of pairs.
        limit: u64,
    },
    /// A ray group has more tiles than a single-id RIT entry can distinguish.
    #[error(
        "a ray group of {tiles} tiles: expected at most 65536, which an unstructured RIT entry \
         distinguishes; use smaller ray groups"
    )]
    Slots {
        /// Number of tiles in the group.
        tiles: usize,
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
    /// The splat unit returned a wrong number of pixels.
    #[error("the splat unit returned {found} pixels, expected {expected}")]
    Pixels {
        /// Pixels that it returned.
        found: usize,
        /// Pixels of all tiles of the job.
        expected: usize,
    },
}
