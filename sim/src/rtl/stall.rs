//! When the streams' other ends are willing: seeded, so that a run repeats.

use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64Mcg;

/// Chances, in percent, that a stream's other end is unwilling in a cycle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Stalls {
    /// Of every input stream, in the order of the unit's ports.
    pub sources: [u8; 2],
    /// Of the output stream.
    pub sink: u8,
    /// Seed of the willingness.
    pub seed: u64,
}

impl Stalls {
    /// Sources that always offer and a sink that always takes.
    #[must_use]
    pub const fn none() -> Self {
        Self {
            sources: [0, 0],
            sink: 0,
            seed: 0,
        }
    }

    pub(super) fn start(self) -> Willing {
        Willing {
            stalls: self,
            random: Pcg64Mcg::seed_from_u64(self.seed),
        }
    }
}

/// Draws willingness cycle by cycle.
pub(super) struct Willing {
    stalls: Stalls,
    random: Pcg64Mcg,
}

impl Willing {
    /// Willingness of both sources and of the sink, this cycle. Three numbers
    /// are drawn whatever the chances, so that streams do not disturb another.
    pub(super) fn next(&mut self) -> [bool; 3] {
        let chances = [
            self.stalls.sources[0],
            self.stalls.sources[1],
            self.stalls.sink,
        ];
        chances.map(|chance| self.random.random_range(0u8..100) >= chance)
    }
}
