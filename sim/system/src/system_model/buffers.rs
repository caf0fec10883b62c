//! Bytes of jobs in the on-chip buffers, and the time of the buffers' ports.
//!
//! The global feature buffer has banks of one port each, by default 32 KB of words of 16 bytes. The
//! words of a block are interleaved over the banks of a group. Streams that run beside one another
//! thus conflict once, and are a bank apart from then on: a group serves a word of each bank a
//! clock, whoever asks.

use super::job_scheduler::{Share, Shared};
use super::memory_costs::{FEATURE_WORD, RECORD_BYTES, WEIGHT_WORD};
use super::system::System;
use super::variant::Gathering;
use potamoi_cycles::batch::Batch;

/// Bytes of the buffers that a job reads and writes.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Buffered {
    /// Index among all blocks; blocks take turns in the groups of banks.
    pub(super) block: u64,
    /// Bytes of the feature buffer.
    pub(super) features: f64,
    /// Bytes of the weight buffer.
    pub(super) weights: f64,
}

impl Buffered {
    /// The gathering unit writes features.
    pub(super) const fn gathered(block: u64, step: &Batch) -> Self {
        Self {
            block,
            features: step.feature_bytes as f64,
            weights: 0.0,
        }
    }

    /// The array reads inputs and weights, and writes outputs. Partial sums of products deeper than
    /// its rows are written and read again. Features that the GPU gathered are written first.
    pub(super) const fn computed(block: u64, step: &Batch, gathering: Gathering) -> Self {
        let loaded = match gathering {
            Gathering::PixelOrder | Gathering::Streamed => step.feature_bytes,
            Gathering::Unit => 0,
        };
        let moved = loaded + step.input_bytes + step.output_bytes + 2 * step.partial_bytes;
        Self {
            block,
            features: moved as f64,
            weights: step.weight_bytes as f64,
        }
    }

    /// The vector unit reads operands and writes results; splat units read records, and keep the pixels.
    pub(super) const fn composited(block: u64, step: &Batch) -> Self {
        let records = step.splat_records * RECORD_BYTES;
        let moved = step.operand_bytes + step.result_bytes + records;
        Self {
            block,
            features: moved as f64,
            weights: 0.0,
        }
    }

    /// The same job with weights loaded beside.
    pub(super) fn loading(self, weights: f64) -> Self {
        Self {
            weights: self.weights + weights,
            ..self
        }
    }

    /// Its shares of the buffers' ports, where the accelerator's clock is `clock_ghz`.
    pub(super) fn shares(&self, system: &System, clock_ghz: f64) -> impl Iterator<Item = Share> {
        let group = self.block % u64::from(system.feature_banks / system.feature_block_banks);
        let features = group_bytes_a_clock(system) * clock_ghz;
        let shares = [
            (Shared::Features(group as u32), self.features / features),
            (Shared::Weights, self.weights / (WEIGHT_WORD * clock_ghz)),
        ];
        (shares.into_iter())
            .filter(|(_, ns)| *ns > 0.0)
            .map(|(of, ns)| Share { of, ns })
    }
}

/// Bytes a clock from the banks of a group.
fn group_bytes_a_clock(system: &System) -> f64 {
    f64::from(system.feature_block_banks) * FEATURE_WORD
}

/// Bytes a nanosecond of both buffers, with all banks at work.
pub(super) fn bytes_a_ns(system: &System, clock_ghz: f64) -> [f64; 2] {
    [f64::from(system.feature_banks) * FEATURE_WORD, WEIGHT_WORD].map(|bytes| bytes * clock_ghz)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Blocks take turns in groups, and a group is as fast as its banks together.
    #[test]
    fn blocks_take_turns_in_groups_of_banks() {
        let step = Batch {
            feature_bytes: 96,
            input_bytes: 192,
            output_bytes: 48,
            partial_bytes: 12,
            weight_bytes: 480,
            ..Batch::default()
        };
        let system = System {
            feature_banks: 6,
            feature_block_banks: 3,
            ..System::default()
        };
        let shares = |own: Buffered| own.shares(&system, 2.0).collect::<Vec<_>>();
        // 48 bytes a clock of half a nanosecond.
        let features = |group, ns| Share {
            of: Shared::Features(group),
            ns,
        };
        assert_eq!(shares(Buffered::gathered(4, &step)), [features(0, 1.0)]);
        assert_eq!(shares(Buffered::gathered(5, &step)), [features(1, 1.0)]);
        let weights = |ns| Share {
            of: Shared::Weights,
            ns,
        };
        let by_unit = Buffered::computed(1, &step, Gathering::Unit);
        assert_eq!(shares(by_unit), [features(1, 2.75), weights(5.0)]);
        let by_gpu = Buffered::computed(1, &step, Gathering::Streamed).loading(96.0);
        assert_eq!(shares(by_gpu), [features(1, 3.75), weights(6.0)]);
    }
}
