//! Values that a unit must not use.

use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64Mcg;

/// A source of values for bytes that are not kept.
pub(super) struct Garbage(Pcg64Mcg);

impl Garbage {
    pub(super) fn new(seed: u64) -> Self {
        Self(Pcg64Mcg::seed_from_u64(seed))
    }

    /// So many of the lanes, in order.
    pub(super) fn lanes(&mut self, count: usize, lanes: usize) -> Vec<usize> {
        let mut chosen = rand::seq::index::sample(&mut self.0, lanes, count.min(lanes)).into_vec();
        chosen.sort_unstable();
        chosen
    }

    /// Replaces the bits of `data` whose bit of `keep` is 0; a bit of `keep` is for `bits` bits.
    pub(super) fn fill(&mut self, data: &mut [u32], keep: &[u32], bits: usize) {
        for (i, word) in data.iter_mut().enumerate() {
            let drawn: u32 = self.0.random();
            for bit in 0..32 {
                let lane = (32 * i + bit) / bits;
                let kept = keep
                    .get(lane / 32)
                    .is_some_and(|k| k >> (lane % 32) & 1 == 1);
                if !kept {
                    *word = *word & !(1 << bit) | drawn & 1 << bit;
                }
            }
        }
    }
}
