//! Stimulus: readiness of sources and sink, independent of any model.
//!
//! A plan depends on its seed and probabilities alone, never on a unit's behaviour, so that one
//! plan can drive a model and hardware. [`Source`] turns readiness into AXI4-Stream behaviour: once
//! valid, a beat stays until it is accepted.

use std::iter::Peekable;

use rand::{RngCore, SeedableRng};
use rand_pcg::Pcg32;

use super::work::WorkError;

/// Random stalls of one stream.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct StreamStalls {
    /// Probability in 1/1000 that a stall begins in a cycle without one; 0 to 999.
    pub per_mille: u16,
    /// Length of a stall in cycles, at least 1.
    pub burst: u16,
}

impl StreamStalls {
    /// Always willing.
    pub const NONE: Self = Self {
        per_mille: 0,
        burst: 1,
    };
}

/// Random stalls of a unit's streams. The vector unit has no MFT stream.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Stalls {
    /// Stalls of the RIT source, or of the operands' source.
    pub rit: StreamStalls,
    /// Stalls of the MFT source.
    pub mft: StreamStalls,
    /// Back-pressure of the sink.
    pub sink: StreamStalls,
}

impl Stalls {
    /// Sources and sink always ready.
    pub const NONE: Self = Self {
        rit: StreamStalls::NONE,
        mft: StreamStalls::NONE,
        sink: StreamStalls::NONE,
    };
}

/// Readiness of sources and sink in one cycle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Willing {
    /// The RIT source may offer a new beat.
    pub rit: bool,
    /// The MFT source may offer a new row.
    pub mft: bool,
    /// The sink is ready.
    pub sink: bool,
}

#[derive(Debug, Clone)]
struct Stream {
    stalls: StreamStalls,
    left: u16,
    rng: Pcg32,
}

impl Stream {
    fn new(stalls: StreamStalls, seed: u64, number: u64) -> Result<Self, WorkError> {
        let StreamStalls { per_mille, burst } = stalls;
        if per_mille > 999 || burst == 0 {
            return Err(WorkError::Stalls { per_mille, burst });
        }
        // A generator a stream: the stalls of one leave those of others alone.
        let rng = Pcg32::seed_from_u64(seed.wrapping_mul(3).wrapping_add(number));
        Ok(Self {
            stalls,
            left: 0,
            rng,
        })
    }

    fn willing(&mut self) -> bool {
        if self.left > 0 {
            self.left -= 1;
            return false;
        }
        let draw = (u64::from(self.rng.next_u32()) * 1000) >> 32;
        let stalled = draw < u64::from(self.stalls.per_mille);
        if stalled {
            self.left = self.stalls.burst - 1;
        }
        !stalled
    }
}

/// Endless sequence of readiness, cycle by cycle.
#[derive(Debug, Clone)]
pub struct Plan {
    rit: Stream,
    mft: Stream,
    sink: Stream,
}

impl Plan {
    /// The plan of a seed.
    ///
    /// # Errors
    /// A stream that would never move.
    pub fn new(seed: u64, stalls: &Stalls) -> Result<Self, WorkError> {
        Ok(Self {
            rit: Stream::new(stalls.rit, seed, 0)?,
            mft: Stream::new(stalls.mft, seed, 1)?,
            sink: Stream::new(stalls.sink, seed, 2)?,
        })
    }

    /// Readiness in the next cycle.
    pub fn step(&mut self) -> Willing {
        Willing {
            rit: self.rit.willing(),
            mft: self.mft.willing(),
            sink: self.sink.willing(),
        }
    }
}

/// A source of beats that follows the AXI4-Stream handshake.
pub struct Source<I: Iterator> {
    beats: Peekable<I>,
    valid: bool,
}

impl<I: Iterator> Source<I> {
    /// A source of these beats.
    pub fn new(beats: I) -> Self {
        Self {
            beats: beats.peekable(),
            valid: false,
        }
    }

    /// The beat on the stream in this cycle: the one still offered, or a new one if the source is
    /// willing.
    pub fn offer(&mut self, willing: bool) -> Option<&I::Item> {
        self.valid |= willing;
        if self.valid { self.beats.peek() } else { None }
    }

    /// Records that the beat was accepted in this cycle.
    pub fn accepted(&mut self) {
        self.beats.next();
        self.valid = false;
    }

    /// Whether all beats were accepted.
    pub fn is_done(&mut self) -> bool {
        self.beats.peek().is_none()
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    const SOME: StreamStalls = StreamStalls {
        per_mille: 300,
        burst: 1,
    };

    #[test]
    fn stalls_come_as_often_and_last_as_long_as_asked() {
        let burst = StreamStalls {
            per_mille: 100,
            burst: 5,
        };
        let mut plan = Plan::new(
            7,
            &Stalls {
                rit: SOME,
                mft: burst,
                sink: StreamStalls::NONE,
            },
        )
        .unwrap();
        let cycles: Vec<_> = (0..100_000).map(|_| plan.step()).collect();
        assert!(cycles.iter().all(|w| w.sink));
        let share = |f: fn(&Willing) -> bool| cycles.iter().filter(|w| !f(w)).count() as f64 / 1e5;
        assert!((share(|w| w.rit) - 0.3).abs() < 0.01);
        // A willing cycle is followed by a burst of 5 one time in ten.
        assert!((share(|w| w.mft) - 0.5 / 1.4).abs() < 0.01);
        let runs = cycles.split(|w| w.mft).map(<[_]>::len);
        let mut runs: Vec<_> = runs.filter(|&n| n > 0).collect();
        runs.pop();
        assert!(runs.iter().all(|n| n % 5 == 0));
    }

    #[test]
    fn a_plan_is_its_seeds_and_streams_do_not_mix() {
        let all = Stalls {
            rit: SOME,
            mft: SOME,
            sink: SOME,
        };
        let bits = |seed, stalls: &Stalls| {
            let mut plan = Plan::new(seed, stalls).unwrap();
            (0..200).map(|_| plan.step()).collect::<Vec<_>>()
        };
        assert_eq!(bits(1, &all), bits(1, &all));
        assert_ne!(bits(1, &all), bits(2, &all));
        let calm = Stalls {
            rit: StreamStalls::NONE,
            ..all
        };
        for (a, b) in bits(1, &all).iter().zip(bits(1, &calm)) {
            assert_eq!((a.mft, a.sink), (b.mft, b.sink));
        }
        assert!(bits(1, &all).iter().any(|w| w.rit != w.mft));
    }

    #[test]
    fn a_stream_that_never_moves_is_refused() {
        for (per_mille, burst) in [(1000, 1), (10, 0)] {
            let sink = StreamStalls { per_mille, burst };
            let stalls = Stalls {
                sink,
                ..Stalls::NONE
            };
            assert_eq!(
                Plan::new(0, &stalls).err(),
                Some(WorkError::Stalls { per_mille, burst })
            );
        }
    }

    #[test]
    fn an_offered_beat_stays() {
        let mut source = Source::new([4, 5].into_iter());
        assert_eq!(source.offer(false), None);
        assert_eq!(source.offer(true), Some(&4));
        assert_eq!(source.offer(false), Some(&4));
        source.accepted();
        assert_eq!(source.offer(false), None);
        assert_eq!(source.offer(true), Some(&5));
        source.accepted();
        assert!(source.is_done());
        assert_eq!(source.offer(true), None);
    }
}
