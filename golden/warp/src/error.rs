//! Errors of warping.

use thiserror::Error;

/// A path that cannot be warped.
#[derive(Debug, Error)]
pub enum WarpError {
    /// An option is out of range.
    #[error("option `{field}` is {value}: expected {expected}")]
    Option {
        /// The option.
        field: &'static str,
        /// Its value.
        value: String,
        /// Allowed values.
        expected: String,
    },
    /// The renderer failed.
    #[error(transparent)]
    Renderer(Box<dyn std::error::Error + Send + Sync>),
    /// A frame has the wrong size.
    #[error("{what} has {} x {} pixels: expected {} x {}, the size of its camera's picture", .found[0], .found[1], .expected[0], .expected[1])]
    Size {
        /// The frame.
        what: &'static str,
        /// Its width and height, or its number of values.
        found: [usize; 2],
        /// Size of the camera's picture.
        expected: [usize; 2],
    },
    /// The image sequence does not have this camera.
    #[error(
        "scene {sequence}: no image was taken from this camera; image sequences are warped from \
         their own frames: choose --reference centre or first"
    )]
    NotTaken {
        /// The sequence.
        sequence: String,
    },
}
