//! Energy and leakage of the memories of the gathering unit, and of the buffers.

use potamoi_cycles::batch::Batch;
use potamoi_formats::config::{Config, ExtraPorts, Organisation};
use potamoi_formats::record::RECORD_CHANNELS;
use potamoi_synth::{MemoryReport, SynthReport, UnitKind};

use super::on_chip_memories::{
    Port, TABLE_QUEUE, feature_banks, leakage_mw, of_unit, unbuilt_queue, weight_buffer,
};
use super::on_chip_sizes::OnChipSizes;
use super::unit_source::Known;

/// Bytes of a word of the global feature buffer; weights in a word of the weight buffer.
pub(super) const FEATURE_WORD: f64 = 16.0;
pub(super) const WEIGHT_WORD: f64 = 48.0;
/// Bytes of a record.
pub(super) const RECORD_BYTES: u64 = 2 * RECORD_CHANNELS as u64;

/// Energies of on-chip memories but for those of splat units. What is not known is `None`.
#[derive(Debug, Clone)]
pub(super) struct MemoryCosts {
    gathering: Option<GatheringMemories>,
    /// A bank of the global feature buffer.
    pub(super) features: Option<Port>,
    /// The weight buffer.
    pub(super) weights: Option<Port>,
    /// Leakage of all of them, in milliwatts.
    pub(super) leakage_mw: Option<f64>,
    /// Bytes of a word of the RIT buffer, which is a beat of its stream.
    rit_word: f64,
}

impl MemoryCosts {
    /// Memories of a configuration, and the buffers of `sizes` whose banks `system` has; `note` is told what is
    /// not known, and why.
    pub(super) fn new(
        config: &Config,
        known: &Known<'_>,
        (system, sizes): (&SynthReport, &OnChipSizes),
        note: &mut dyn FnMut(&str, String),
    ) -> Self {
        let gathering = GatheringMemories::new(config, known)
            .map_err(|why| note("memories of the gathering unit", why))
            .ok();
        let mut buffer =
            |name, own: Result<MemoryReport, String>| own.map_err(|why| note(name, why)).ok();
        let features = buffer("feature buffer", feature_banks(system, sizes));
        let weights = buffer("weight buffer", weight_buffer(system, sizes));
        let queue = unbuilt_queue(config);
        if let Some(why) = queue {
            note(TABLE_QUEUE, why.to_owned());
        }
        let all = || {
            let buffers = [features.clone()?, weights.clone()?];
            Some(gathering?.leakage_mw + leakage_mw(&buffers))
        };
        Self {
            leakage_mw: all().filter(|_| queue.is_none()),
            gathering,
            features: features.as_ref().map(Port::of),
            weights: weights.as_ref().map(Port::of),
            rit_word: f64::from(config.rit_stream_bits()) / 8.0,
        }
    }

    /// Picojoules of the gathering unit's memories for a batch.
    pub(super) fn gathering_pj(&self, done: &Batch) -> Option<f64> {
        let own = self.gathering?;
        let rit_words = done.rit_read_bytes as f64 / self.rit_word;
        Some(
            done.codes_read as f64 * own.mft.read_pj
                + done.row_bytes as f64 / 2.0 * own.mft.write_pj
                + rit_words * (own.rit.read_pj + own.rit.write_pj),
        )
    }

    /// Picojoules of the buffers for a batch.
    pub(super) fn buffers_pj(&self, done: &Batch) -> Option<f64> {
        let (features, weights) = self.features.zip(self.weights)?;
        let records = done.splat_records * RECORD_BYTES;
        // Whoever gathers, features are written to the buffer that the array reads.
        let read = done.input_bytes + done.partial_bytes + done.operand_bytes + records;
        let written =
            done.feature_bytes + done.output_bytes + done.partial_bytes + done.result_bytes;
        Some(
            read as f64 / FEATURE_WORD * features.read_pj
                + written as f64 / FEATURE_WORD * features.write_pj
                + done.weight_bytes as f64 / WEIGHT_WORD * weights.read_pj,
        )
    }

    /// Picojoules of writing weights into their buffer.
    pub(super) fn loaded_weights(&self, bytes: f64) -> Option<f64> {
        Some(bytes / WEIGHT_WORD * self.weights?.write_pj)
    }
}

/// Energies and leakage of the memories of a gathering unit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct GatheringMemories {
    /// A bank of the MFT; copies of a bank are written together.
    pub(super) mft: Port,
    /// A bank of the RIT buffer.
    pub(super) rit: Port,
    /// Leakage of all of them, in milliwatts.
    pub(super) leakage_mw: f64,
}

impl GatheringMemories {
    /// # Errors
    /// Why they are not known.
    pub(super) fn new(config: &Config, known: &Known<'_>) -> Result<Self, String> {
        let all = of_unit(config, known, UnitKind::Gathering)?;
        let bank = |name: &str| {
            let own = all.iter().find(|own| own.memory == name);
            let why = || format!("no memory {name} in its parameters: synth with CACTI");
            own.map(Port::of).ok_or_else(why)
        };
        let (mft, rit) = (bank("mft_bank")?, bank("rit_bank")?);
        Ok(Self {
            mft: Port {
                write_pj: copies(config) * mft.write_pj,
                ..mft
            },
            rit,
            leakage_mw: leakage_mw(&all),
        })
    }
}

/// Copies of a bank of the MFT: each has two ports.
fn copies(config: &Config) -> f64 {
    let feature_major = config.organisation().0 == Organisation::FeatureMajor;
    match config.gu.extra_ports {
        ExtraPorts::Copies if !feature_major => f64::from(config.gu.ports.div_ceil(2)),
        _ => 1.0,
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use potamoi_synth::Synthesised;
    use potamoi_synth::fit::Fit;

    use super::*;

    fn gathering(text: &str) -> Result<GatheringMemories, String> {
        let config = Config::from_toml(text, "test").unwrap();
        let known = Known {
            fit: &Fit::checked_in().unwrap(),
            reports: &Synthesised::checked_in().unwrap(),
            estimated: &[],
        };
        GatheringMemories::new(&config, &known)
    }

    /// An access of a smaller bank takes less, synthesised or not.
    #[test]
    fn energies_of_a_gathering_unit_are_those_of_its_own_banks() {
        let paper = gathering("").unwrap();
        let parity = gathering(include_str!("../../../../configs/parity.toml")).unwrap();
        assert!(parity.mft.read_pj < paper.mft.read_pj / 2.0);
        assert_eq!(parity.rit, paper.rit);
        let small = gathering("mvoxel.rows = 128").unwrap();
        assert!(small.mft.read_pj < paper.mft.read_pj && small.leakage_mw < paper.leakage_mw);
        // Twice the banks: the same energy an access.
        let wide = gathering("gu.banks = 64").unwrap();
        assert_eq!((wide.mft, wide.rit.read_pj), (paper.mft, paper.rit.read_pj));
        assert!(wide.leakage_mw > 1.5 * paper.leakage_mw);
        let error = gathering("mvoxel.rows = 500").unwrap_err();
        assert!(error.contains("mft_bank, 500 words"), "{error}");
    }

    /// A row is written into each copy of a bank: the netlist has as many words.
    #[test]
    fn copies_of_a_bank_are_those_of_the_netlist() {
        for (extra, ports) in [("copies", &[1, 2, 4, 8][..]), ("split", &[4, 8])] {
            for ports in ports {
                let text = format!("[gu]\nports = {ports}\nextra_ports = \"{extra}\"\n");
                let config = Config::from_toml(&text, "test").unwrap();
                let banks = potamoi_synth::macros(&config, UnitKind::Gathering).unwrap();
                let bank = banks.iter().filter(|own| own.module == "mft_bank");
                let words: u64 = bank.map(|own| own.count * own.words).sum();
                let once = f64::from(2 * config.gu.banks * config.mft_rows());
                assert_eq!(words as f64, copies(&config) * once, "{text}");
            }
        }
    }
}
