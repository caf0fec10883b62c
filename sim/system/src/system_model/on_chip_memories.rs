//! Memories of units and buffers at the system's node: as their synthesis has them, else by their shape.

use potamoi_formats::config::{Config, ExtraPorts, Organisation};
use potamoi_synth::{MemoryReport, MemoryTable, SYSTEM, Shape, SynthReport, UnitKind, scaling};
use serde::Serialize;

use super::logic::NODE_NM;
use super::on_chip_sizes::OnChipSizes;
use super::unit_source::{Known, UnitSource};

/// Energy of a memory, in picojoules an access.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Port {
    /// Read.
    pub read_pj: f64,
    /// Write.
    pub write_pj: f64,
}

impl Port {
    pub(super) const fn of(own: &MemoryReport) -> Self {
        Self {
            read_pj: own.figures.read_pj,
            write_pj: own.figures.write_pj,
        }
    }
}

/// Leakage of memories, in milliwatts.
pub(super) fn leakage_mw(all: &[MemoryReport]) -> f64 {
    // A sum of none is -0.0.
    (all.iter()
        .map(|own| own.figures.leakage_mw * own.count as f64))
    .sum::<f64>()
        + 0.0
}

/// Memories of a unit that are not among its cells.
///
/// # Errors
/// Why they are not known.
pub(super) fn of_unit(
    config: &Config,
    known: &Known<'_>,
    unit: UnitKind,
) -> Result<Vec<MemoryReport>, String> {
    // Vector units have none: their FIFO is flip-flops.
    if unit == UnitKind::Vector {
        return Ok(vec![]);
    }
    let reported = match known.source(config, unit) {
        UnitSource::Synthesised(own) => own.report.raw.memories.as_ref(),
        _ => None,
    };
    if let Some(all) = reported {
        let own = all.macros.iter().filter(|own| own.of == unit.top());
        return own.map(|own| scaled(own, all.origin.node_nm)).collect();
    }
    let table = MemoryTable::checked_in().map_err(|error| error.to_string())?;
    let own = table.of_unit(config, unit)?;
    (own.iter())
        .map(|own| scaled(own, table.origin.node_nm))
        .collect()
}

/// The banks of the global feature buffer.
///
/// # Errors
/// Why they are not known.
pub(super) fn feature_banks(
    system: &SynthReport,
    sizes: &OnChipSizes,
) -> Result<MemoryReport, String> {
    let banks = u64::from(sizes.feature_banks);
    let bytes = sizes.feature_buffer_bytes / banks.max(1);
    of_buffer(system, FEATURE_BUFFER, bytes, banks)
}

/// The weight buffer.
///
/// # Errors
/// Why it is not known.
pub(super) fn weight_buffer(
    system: &SynthReport,
    sizes: &OnChipSizes,
) -> Result<MemoryReport, String> {
    of_buffer(system, WEIGHT_BUFFER, sizes.weight_buffer_bytes, 1)
}

/// Names of the buffers among the memories of the system.
pub(super) const FEATURE_BUFFER: &str = "global_feature_buffer";
pub(super) const WEIGHT_BUFFER: &str = "weight_buffer";

/// Banks of a buffer, whose words are as wide as those of the paper's: as in the parameters, or by shape.
fn of_buffer(
    system: &SynthReport,
    buffer: &str,
    bytes: u64,
    count: u64,
) -> Result<MemoryReport, String> {
    let (own, _) = (system.memory(SYSTEM, buffer)).ok_or("the parameters lack this memory")?;
    let node_nm = (system.raw.memories.as_ref()).map_or(0, |all| all.origin.node_nm);
    let shape = Shape {
        words: bytes * 8 / own.shape.bits,
        ..own.shape
    };
    let own = MemoryReport {
        count,
        ..own.clone()
    };
    if shape == own.shape {
        return scaled(&own, node_nm);
    }
    let table = MemoryTable::checked_in().map_err(|error| error.to_string())?;
    let figures = table.figures(&shape).ok_or_else(|| {
        let known: Vec<String> = (table.words(&own.shape).iter())
            .map(|words| (words * own.shape.bits / 8).to_string())
            .collect();
        format!(
            "CACTI did not model a bank of {bytes} bytes; it modelled {} bytes",
            known.join(", ")
        )
    })?;
    let own = MemoryReport {
        shape,
        figures: *figures,
        ..own
    };
    scaled(&own, table.origin.node_nm)
}

/// A memory at the system's node.
fn scaled(own: &MemoryReport, from_nm: u32) -> Result<MemoryReport, String> {
    let factors = scaling::memory(from_nm, NODE_NM)
        .ok_or_else(|| format!("no factors for memories from {from_nm} nm"))?;
    Ok(MemoryReport {
        figures: own.figures.scaled(&factors),
        ..own.clone()
    })
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

    /// Banks of a size that CACTI modelled are known, others name those sizes.
    #[test]
    fn buffers_are_known_by_size() {
        let reports = Synthesised::checked_in().unwrap();
        let system = &reports[0].report;
        let weights = |bytes| {
            let sizes = OnChipSizes {
                weight_buffer_bytes: bytes,
                ..OnChipSizes::default()
            };
            weight_buffer(system, &sizes)
        };
        let [half, whole] = [49_152, 98_304].map(|bytes| weights(bytes).unwrap().figures);
        assert!(half.area_um2 < whole.area_um2 && half.read_pj < whole.read_pj);
        assert!(half.write_pj < whole.write_pj && half.leakage_mw < whole.leakage_mw);
        let error = weights(50_000).unwrap_err();
        assert!(error.contains("it modelled 24576, 49152, 98304"), "{error}");
        // Half the banks of the same size leak half as much.
        let sizes = OnChipSizes::default();
        let fewer = OnChipSizes {
            feature_buffer_bytes: sizes.feature_buffer_bytes / 2,
            feature_banks: sizes.feature_banks / 2,
            ..sizes
        };
        let [all, fewer] = [sizes, fewer].map(|sizes| feature_banks(system, &sizes).unwrap());
        assert_eq!((all.figures, all.count), (fewer.figures, 2 * fewer.count));
        assert!((leakage_mw(&[all]) - 2.0 * leakage_mw(&[fewer])).abs() < 1e-12);
    }
}
