//! How long what is rendered takes.

use potamoi_golden::warp::Counts;

use super::RuntimeError;

/// Nanoseconds.
pub type Nanos = u64;

/// Tells how long each task takes, in nanoseconds. The same question has to have
/// the same answer whenever it is asked.
pub trait Clock {
    /// Of a reference, on the full renderer here.
    fn reference(&self, reference: usize) -> Nanos;

    /// Of a reference, on the server, without the link.
    fn served(&self, reference: usize) -> Nanos;

    /// Of a target: warping, and rendering of those pixels that `counts` says
    /// are disoccluded or seen from too different an angle. Of one that falls
    /// back to full rendering (`counts.full` is not 0) warping alone, which
    /// finds that out.
    fn target(&self, frame: usize, counts: &Counts) -> Nanos;

    /// Of a target that is rendered in full.
    fn full(&self, frame: usize) -> Nanos;
}

/// The same time for every task of a kind.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FixedClock {
    /// Of a reference, here.
    pub reference: Nanos,
    /// Of a reference, on the server.
    pub served: Nanos,
    /// Of a target.
    pub target: Nanos,
    /// Of a target that is rendered in full.
    pub full: Nanos,
}

impl Clock for FixedClock {
    fn reference(&self, _: usize) -> Nanos {
        self.reference
    }

    fn served(&self, _: usize) -> Nanos {
        self.served
    }

    fn target(&self, _: usize, _: &Counts) -> Nanos {
        self.target
    }

    fn full(&self, _: usize) -> Nanos {
        self.full
    }
}

/// Sum of two times, or what it would have been the time of.
pub(super) fn later(
    time: Nanos,
    by: Nanos,
    what: impl FnOnce() -> String,
) -> Result<Nanos, RuntimeError> {
    time.checked_add(by).ok_or_else(|| RuntimeError::Overflow {
        what: what(),
        unit: "ns",
    })
}
