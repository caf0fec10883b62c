//! What can go wrong between a cloud and its picture.

use thiserror::Error;

use potamoi_reference::UnitError;

/// A view that cannot be rendered.
#[derive(Debug, Error)]
pub enum RenderError {
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
    /// The Gaussians cover too many tiles for memory.
    #[error(
        "{entries} (tile, Gaussian) pairs, more than {limit}: use a smaller picture, \
         or a scene with fewer Gaussians that fill the frame"
    )]
    TooManyEntries {
        /// Pairs counted before giving up.
        entries: u64,
        /// Pairs that are held at most.
        limit: u64,
    },
    /// A ray group has more tiles than a single-id RIT entry can tell apart.
    #[error(
        "a ray group of {tiles} tiles: an unstructured RIT entry tells 65536 tiles apart; \
         use smaller ray groups"
    )]
    Slots {
        /// Tiles of the group.
        tiles: usize,
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
