//! What a schedule depends on besides its plan.

use std::collections::BTreeSet;

use serde::Serialize;

use super::{Nanos, RuntimeError};
use crate::frame_scheduler::REFERENCE_SLOTS;
use crate::link;

const SECOND: u128 = 1_000_000_000;

/// When the poses of the path arrive.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Poses {
    /// So many `frames` in so many `seconds`, evenly; rounded down to the
    /// nanosecond each, so that they do not drift. 30 in 1, or 30000 in 1001.
    Rate {
        /// Frames; not 0.
        frames: u32,
        /// Seconds; not 0.
        seconds: u32,
    },
    /// As fast as possible: each when the frame before it is shown, as to who
    /// looks at what is rendered. A reference then has to be known no later
    /// than with its first target.
    OnShown,
    /// All at the start: a path that was recorded.
    AtOnce,
}

impl Poses {
    /// When a frame's pose arrives, if that does not depend on what is shown.
    pub(super) fn at(self, frame: usize) -> Result<Option<Nanos>, RuntimeError> {
        let Self::Rate { frames, seconds } = self else {
            return Ok((self == Self::AtOnce || frame == 0).then_some(0));
        };
        // A frame's number has 64 bits, the seconds 32, the factor 30.
        let time = frame as u128 * u128::from(seconds) * SECOND / u128::from(frames.max(1));
        match Nanos::try_from(time) {
            Ok(time) => Ok(Some(time)),
            Err(_) => Err(RuntimeError::Overflow {
                what: format!("the time at which the pose of frame {frame} arrives"),
                unit: "ns",
            }),
        }
    }
}

/// How the runtime works.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Options {
    /// When poses arrive.
    pub poses: Poses,
    /// Whether references and targets have a renderer each; if not, they share
    /// one.
    pub concurrent: bool,
    /// References that the buffer holds, at least 1; the paper's is
    /// double-buffered.
    pub slots: usize,
}

impl Options {
    /// Two renderers and two slots, as the paper has them.
    #[must_use]
    pub const fn new(poses: Poses) -> Self {
        Self {
            poses,
            concurrent: true,
            slots: REFERENCE_SLOTS,
        }
    }

    pub(super) fn check(&self) -> Result<(), RuntimeError> {
        not_zero(self.slots as u64, "slots", "at least 1 reference")?;
        if let Poses::Rate { frames, seconds } = self.poses {
            not_zero(frames.into(), "poses.frames", "at least 1 frame")?;
            not_zero(seconds.into(), "poses.seconds", "at least 1 second")?;
        }
        Ok(())
    }
}

/// A link, of which one end sends at a time.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Link {
    /// Bytes a second; not 0.
    pub bytes_per_second: u64,
    /// Nanoseconds from when the last byte is sent until it arrives; the link
    /// is free meanwhile.
    pub latency: Nanos,
    /// Energy of a byte, here.
    pub nanojoules_per_byte: u64,
}

impl Link {
    /// The paper's wireless link: 10 MB/s and 100 nJ/B. Of its latency nothing
    /// is said: none.
    pub const PAPER: Self = Self {
        bytes_per_second: link::BYTES_PER_SECOND,
        latency: 0,
        nanojoules_per_byte: link::NANOJOULES_PER_BYTE,
    };

    /// How long so many bytes occupy it, rounded up.
    pub(super) fn time(&self, bytes: u64, what: &str) -> Result<Nanos, RuntimeError> {
        let time = (u128::from(bytes) * SECOND).div_ceil(u128::from(self.bytes_per_second.max(1)));
        Nanos::try_from(time).map_err(|_| RuntimeError::Overflow {
            what: format!("the time of {what} on the link"),
            unit: "ns",
        })
    }
}

/// A server that renders references.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Remote {
    /// What leads there and back.
    pub link: Link,
    /// Bytes that ask for a reference.
    pub request_bytes: u64,
    /// Bytes of a reference, as it is sent.
    pub reference_bytes: u64,
    /// A reference that is not here so many nanoseconds after its request began
    /// is given up.
    pub timeout: Nanos,
    /// References that are sent but do not arrive.
    pub lost: BTreeSet<usize>,
}

impl Remote {
    pub(super) fn check(&self) -> Result<(), RuntimeError> {
        not_zero(
            self.link.bytes_per_second,
            "link.bytes_per_second",
            "at least 1 byte a second; without a link render references here",
        )
    }
}

fn not_zero(value: u64, field: &'static str, expected: &'static str) -> Result<(), RuntimeError> {
    if value > 0 {
        return Ok(());
    }
    Err(RuntimeError::Option {
        field,
        value: value.to_string(),
        expected,
    })
}
