//! Errors of schedules.

use potamoi_warp::WarpError;
use thiserror::Error;

/// Why a plan cannot be scheduled or rendered.
#[derive(Debug, Error)]
pub enum ScheduleError {
    /// An option is out of range.
    #[error("option `{field}` is {value}: expected {expected}")]
    Option {
        /// Name of the option.
        field: &'static str,
        /// Its value.
        value: String,
        /// The allowed values.
        expected: &'static str,
    },
    /// Parts of a plan contradict each other.
    #[error("plan: {part} {number}: {field} is {value}: expected {expected}")]
    Plan {
        /// `target` or `reference`.
        part: &'static str,
        /// Its number in the plan.
        number: usize,
        /// Name of the field.
        field: &'static str,
        /// Its value.
        value: usize,
        /// The expected value.
        expected: String,
    },
    /// A list is not as long as the plan has frames.
    #[error("{what} has {found} entries: expected {expected}, one for each frame of the plan")]
    Length {
        /// Name of the list.
        what: &'static str,
        /// Its length.
        found: usize,
        /// Frames of the plan.
        expected: usize,
    },
    /// A sum exceeds 64 bits (as nanoseconds, 584 years).
    #[error("{what} is beyond 2^64 - 1 {unit}: choose shorter times, or fewer frames")]
    Overflow {
        /// The quantity computed.
        what: String,
        /// Its unit.
        unit: &'static str,
    },
    /// A frame was never finished, as the run stopped early.
    #[error(
        "frame {frame} was not shown, since the run ended early; run again, or ask for fewer frames"
    )]
    Unfinished {
        /// The frame.
        frame: usize,
    },
    /// Rendering failed.
    #[error(transparent)]
    Warp(#[from] WarpError),
}
