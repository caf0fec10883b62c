//! How long what is rendered takes.

use potamoi_warp::Counts;

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

/// Times in proportion to what is rendered.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PixelClock {
    /// Of a frame in full.
    pub frame: Nanos,
    /// Of a frame in full, on the server.
    pub served: Nanos,
    /// Of warping a reference to a target.
    pub warp: Nanos,
}

impl Clock for PixelClock {
    fn reference(&self, _: usize) -> Nanos {
        self.frame
    }

    fn served(&self, _: usize) -> Nanos {
        self.served
    }

    fn target(&self, _: usize, counts: &Counts) -> Nanos {
        if counts.full > 0 {
            return self.warp;
        }
        let rendered = u128::from(self.frame) * u128::from(counts.rendered());
        let share = rendered / u128::from(counts.total().max(1));
        // At most the frame's, since no more pixels are rendered than there are.
        self.warp.saturating_add(share as Nanos)
    }

    fn full(&self, _: usize) -> Nanos {
        self.frame
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_target_takes_its_share_of_a_frame() {
        let clock = PixelClock {
            frame: 1000,
            served: 10,
            warp: 7,
        };
        let counts = Counts {
            warped: 60,
            disoccluded: 15,
            edge: 5,
            void: 20,
            ..Counts::default()
        };
        assert_eq!(clock.target(0, &counts), 7 + 200);
        let full = Counts {
            full: 100,
            ..Counts::default()
        };
        assert_eq!(clock.target(0, &full), 7);
        assert_eq!(clock.target(0, &Counts::default()), 7);
        let long = PixelClock {
            frame: Nanos::MAX,
            ..clock
        };
        assert_eq!(long.target(0, &counts), 7 + Nanos::MAX / 5);
    }
}
