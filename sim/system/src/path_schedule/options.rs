//! Options of a schedule, besides its plan.

use std::collections::BTreeSet;

use serde::Serialize;

use super::{Nanos, ScheduleError};
use crate::frame_scheduler::REFERENCE_SLOTS;
use crate::link;

const SECOND: u128 = 1_000_000_000;

/// Arrival times of the poses of a path.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Poses {
    /// An even rate of `frames` per `seconds`: 30 per 1, or 30000 per 1001. Each time is rounded
    /// down to the nanosecond by itself, so that they do not drift.
    Rate {
        /// Frames; at least 1.
        frames: u32,
        /// Seconds; at least 1.
        seconds: u32,
    },
    /// Each pose arrives when the frame before it is shown: the highest rate at which a viewer
    /// reacts to each frame. The pose of a reference must then be known no later than that of its
    /// first target.
    OnShown,
    /// All at the start: a recorded path.
    AtOnce,
}

impl Poses {
    /// Arrival of a frame's pose in nanoseconds; `None` if it depends on what is shown.
    pub(super) fn at(self, frame: usize) -> Result<Option<Nanos>, ScheduleError> {
        let Self::Rate { frames, seconds } = self else {
            return Ok((self == Self::AtOnce || frame == 0).then_some(0));
        };
        // A frame's number has 64 bits, the seconds 32, the factor 30.
        let time = frame as u128 * u128::from(seconds) * SECOND / u128::from(frames.max(1));
        match Nanos::try_from(time) {
            Ok(time) => Ok(Some(time)),
            Err(_) => Err(ScheduleError::Overflow {
                what: format!("the time at which the pose of frame {frame} arrives"),
                unit: "ns",
            }),
        }
    }
}

/// Options of a schedule.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Options {
    /// Arrival times of the poses.
    pub poses: Poses,
    /// Whether references and targets have a renderer each; otherwise they share one.
    pub concurrent: bool,
    /// Slots of the reference buffer, at least 1; the paper's is double-buffered.
    pub slots: usize,
}

impl Options {
    /// The paper's: two renderers and two slots.
    #[must_use]
    pub const fn new(poses: Poses) -> Self {
        Self {
            poses,
            concurrent: true,
            slots: REFERENCE_SLOTS,
        }
    }

    pub(super) fn check(&self) -> Result<(), ScheduleError> {
        not_zero(self.slots as u64, "slots", "at least 1 reference")?;
        if let Poses::Rate { frames, seconds } = self.poses {
            not_zero(frames.into(), "poses.frames", "at least 1 frame")?;
            not_zero(seconds.into(), "poses.seconds", "at least 1 second")?;
        }
        Ok(())
    }
}

/// A half-duplex link: one end sends at a time.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Link {
    /// Bandwidth in bytes a second; not 0.
    pub bytes_per_second: u64,
    /// Latency in nanoseconds, from the last byte sent until it arrives; the link is free
    /// meanwhile.
    pub latency: Nanos,
    /// Energy of a byte on the local side, in nanojoules.
    pub nanojoules_per_byte: u64,
}

impl Link {
    /// The paper's wireless link: 10 MB/s and 100 nJ/B. The paper gives no latency, so it is 0.
    pub const PAPER: Self = Self {
        bytes_per_second: link::BYTES_PER_SECOND,
        latency: 0,
        nanojoules_per_byte: link::NANOJOULES_PER_BYTE,
    };

    /// Nanoseconds that `bytes` occupy the link, rounded up.
    pub(super) fn time(&self, bytes: u64, what: &str) -> Result<Nanos, ScheduleError> {
        let time = (u128::from(bytes) * SECOND).div_ceil(u128::from(self.bytes_per_second.max(1)));
        Nanos::try_from(time).map_err(|_| ScheduleError::Overflow {
            what: format!("the time of {what} on the link"),
            unit: "ns",
        })
    }
}

/// A server that renders references.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Remote {
    /// The link to and from it.
    pub link: Link,
    /// Bytes of a request for a reference.
    pub request_bytes: u64,
    /// Bytes of a reference as sent.
    pub reference_bytes: u64,
    /// Nanoseconds after the begin of its request at which a reference that has not arrived is
    /// given up.
    pub timeout: Nanos,
    /// References that are sent but never arrive.
    pub lost: BTreeSet<usize>,
}

impl Remote {
    pub(super) fn check(&self) -> Result<(), ScheduleError> {
        not_zero(
            self.link.bytes_per_second,
            "link.bytes_per_second",
            "at least 1 byte a second; without a link render references here",
        )
    }
}

fn not_zero(value: u64, field: &'static str, expected: &'static str) -> Result<(), ScheduleError> {
    if value > 0 {
        return Ok(());
    }
    Err(ScheduleError::Option {
        field,
        value: value.to_string(),
        expected,
    })
}
