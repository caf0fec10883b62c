//! What can go wrong in the runtime.

use potamoi_warp::WarpError;
use thiserror::Error;

/// A plan that cannot be scheduled, or rendered.
#[derive(Debug, Error)]
pub enum RuntimeError {
    /// An option outside its range.
    #[error("option `{field}` is {value}: expected {expected}")]
    Option {
        /// The option.
        field: &'static str,
        /// Its value.
        value: String,
        /// What would be right.
        expected: &'static str,
    },
    /// A plan whose parts do not fit together.
    #[error("plan: {part} {number}: {field} is {value}: expected {expected}")]
    Plan {
        /// `target` or `reference`.
        part: &'static str,
        /// Its number.
        number: usize,
        /// Its field.
        field: &'static str,
        /// What the field has.
        value: usize,
        /// What would be right.
        expected: String,
    },
    /// Lists of which one is as long as the plan has frames, the other not.
    #[error("{what}: {found} entries: expected {expected}, one a frame of the plan")]
    Length {
        /// The list.
        what: &'static str,
        /// How long it is.
        found: usize,
        /// Frames of the plan.
        expected: usize,
    },
    /// A sum that 64 bits do not hold; as times, they are 584 years.
    #[error("{what} is beyond 2^64 - 1 {unit}: choose shorter times, or fewer frames")]
    Overflow {
        /// What was to be computed.
        what: String,
        /// Its unit.
        unit: &'static str,
    },
    /// A frame that was never finished, as the dispatcher was left before.
    #[error("frame {frame} was not shown: the schedule ends before it")]
    Unfinished {
        /// The frame.
        frame: usize,
    },
    /// Rendering failed.
    #[error(transparent)]
    Warp(#[from] WarpError),
}
