//! What can go wrong in warping.

use thiserror::Error;

/// A path that cannot be warped.
#[derive(Debug, Error)]
pub enum WarpError {
    /// An option outside its range.
    #[error("option `{field}` is {value}: expected {expected}")]
    Option {
        /// The option.
        field: &'static str,
        /// Its value.
        value: String,
        /// What would be right.
        expected: String,
    },
    /// The renderer failed.
    #[error(transparent)]
    Renderer(Box<dyn std::error::Error + Send + Sync>),
    /// A frame is not of the size that it has to be.
    #[error("{what} is {found:?} pixels: expected {expected:?}, as its camera has")]
    Size {
        /// The frame.
        what: &'static str,
        /// Its pixels a row, and rows, or values.
        found: [usize; 2],
        /// The camera's.
        expected: [usize; 2],
    },
    /// A camera that an image sequence does not have.
    #[error(
        "scene {sequence}: no image was taken from this camera; image sequences are warped from \
         their own frames: choose --reference centre or first"
    )]
    NotTaken {
        /// The sequence.
        sequence: String,
    },
}
