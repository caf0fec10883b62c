//! Memories of units and buffers at the system's node: as their synthesis has them, else by their shape.

use potamoi_formats::config::{Config, RitPath};
use potamoi_synth::{MemoryReport, MemoryTable, SYSTEM, Shape, SynthReport, UnitKind, scaling};
use serde::Serialize;

use super::logic::NODE_NM;
use super::on_chip_sizes::OnChipSizes;
use super::unit_source::{Known, UnitSource};

/// Names of the buffers among the memories of the system.
pub(super) const FEATURE_BUFFER: &str = "global_feature_buffer";
pub(super) const WEIGHT_BUFFER: &str = "weight_buffer";

/// Name of what keeps the table where it takes no way through memory.
pub(super) const TABLE_QUEUE: &str = "queue of the ray index table";

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

/// Why the queue of the table is not known: samples come in the order of pixels, and the unit takes them
/// MVoxel by MVoxel.
pub(super) fn unbuilt_queue(config: &Config) -> Option<&'static str> {
    (config.rit.path == RitPath::Direct).then_some(
        "rit.path = \"direct\" needs a memory that keeps entries until their MVoxel is loaded, which is not \
         built; \"dram\" keeps them in memory",
    )
}

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

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use potamoi_synth::Synthesised;

    use super::*;

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
