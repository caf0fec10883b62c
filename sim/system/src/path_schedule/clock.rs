//! Rendering times of references and targets.

use potamoi_warp::Counts;

use super::ScheduleError;

/// Nanoseconds.
pub type Nanos = u64;

/// Time of each task in nanoseconds. The same call must always return the same time.
pub trait Clock {
    /// Time of a reference on the local full renderer.
    fn reference(&self, reference: usize) -> Nanos;

    /// Time of a reference on the server, without the link.
    fn served(&self, reference: usize) -> Nanos;

    /// Time of a target: warping it and rendering the pixels that `counts` lists as disoccluded or
    /// seen from too different an angle. For a target that falls back to full rendering
    /// (`counts.full` is not 0), the time of warping alone, which detects the fallback.
    fn target(&self, frame: usize, counts: &Counts) -> Nanos;

    /// Time of a target that is rendered in full.
    fn full(&self, frame: usize) -> Nanos;
}

/// Constant times, one for each kind of task.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FixedClock {
    /// Reference, rendered locally.
    pub reference: Nanos,
    /// Reference, rendered by the server.
    pub served: Nanos,
    /// Target.
    pub target: Nanos,
    /// Target rendered in full.
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

/// Times in proportion to the pixels rendered.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PixelClock {
    /// Full frame, rendered locally.
    pub frame: Nanos,
    /// Full frame, rendered by the server.
    pub served: Nanos,
    /// Warping a reference to a target.
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

/// Sum of two times; `what` names the time in the error on overflow.
pub(super) fn later(
    time: Nanos,
    by: Nanos,
    what: impl FnOnce() -> String,
) -> Result<Nanos, ScheduleError> {
    time.checked_add(by).ok_or_else(|| ScheduleError::Overflow {
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
