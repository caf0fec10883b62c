//! Memories of a configuration, with area, energy and timing.

use potamoi_formats::config::Config;
use potamoi_netlist::{MemoryMacro, Module};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::cacti::{self, Cacti, Figures, Settings, Shape};
use super::{FlopMemory, MemoryArea, SynthError, UnitKind, UnitReport};

/// Owner of memories outside the units.
pub const SYSTEM: &str = "system";

/// A memory of a unit or of the system around it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct MemoryReport {
    /// Its module, or its name in the system.
    pub memory: String,
    /// Top module of its unit, or [`SYSTEM`].
    pub of: String,
    /// Number of instances.
    pub count: u64,
    /// Words and ports of one.
    #[serde(flatten)]
    pub shape: Shape,
    /// Figures of one.
    #[serde(flatten)]
    pub figures: Figures,
}

/// Memories at the node of their model.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Memories {
    /// Settings of the model.
    pub origin: Settings,
    /// Macros, unit by unit, then the system's.
    pub macros: Vec<MemoryReport>,
}

/// Words and ports of a macro.
pub(super) fn shape(own: &MemoryArea) -> Shape {
    Shape {
        words: own.words,
        bits: own.bits,
        read_writes: own.read_writes,
        writes: own.writes,
        reads: own.reads,
    }
}

/// The memories around the units (paper, Sec. "Experimental Setup"): 1.5 MB of
/// features in blocks of 32 KB, and 96 KB of weights. Word widths are assumptions:
/// 128 bits a block, and a weight for each of 24 columns.
#[must_use]
pub fn system() -> [(&'static str, u64, Shape); 2] {
    let one_port = |words, bits| Shape {
        words,
        bits,
        read_writes: 1,
        writes: 0,
        reads: 0,
    };
    [
        ("global_feature_buffer", 48, one_port(2048, 128)),
        ("weight_buffer", 1, one_port(2048, 384)),
    ]
}

/// Splits the memories of a unit into macros of a memory compiler and memories of flip-flops.
pub(super) fn split(module: &Module, unit: UnitKind) -> (Vec<MemoryMacro>, Vec<FlopMemory>) {
    let flops = |own: &MemoryMacro, why: String| FlopMemory {
        memory: own.module.clone(),
        of: unit.top().to_owned(),
        count: own.count.into(),
        words: own.words.into(),
        bits: own.bits.into(),
        why,
    };
    let (mut macros, mut others) = (vec![], vec![]);
    for own in module.memory_macros() {
        match cacti::is_modelled(&shape(&own.clone().into())) {
            Ok(()) => macros.push(own),
            Err(why) => others.push(flops(&own, why)),
        }
    }
    let why = "read without a clock, beside logic";
    others.extend(
        module
            .memories_in_logic()
            .iter()
            .map(|own| flops(own, why.to_owned())),
    );
    (macros, others)
}

/// Memories of a unit that are not among its cells.
///
/// # Errors
/// The netlist's own checks.
pub fn macros(config: &Config, unit: UnitKind) -> Result<Vec<MemoryArea>, SynthError> {
    let (macros, _) = split(&*unit.module(config)?, unit);
    Ok(macros.into_iter().map(MemoryArea::from).collect())
}

/// Models the memories of some units and those of the system.
///
/// # Errors
/// CACTI fails or prints output that is not understood; files cannot be written.
pub fn model(units: &[UnitReport], cacti: &Cacti) -> Result<Memories, SynthError> {
    let mut wanted = vec![];
    for unit in units {
        for own in &unit.memories {
            wanted.push((own.module.clone(), unit.unit.clone(), own.count, shape(own)));
        }
    }
    for (name, count, shape) in system() {
        wanted.push((name.to_owned(), SYSTEM.to_owned(), count, shape));
    }
    let macros = wanted.into_iter().map(|(memory, of, count, shape)| {
        let figures = cacti.model(&memory, &shape)?;
        Ok(MemoryReport {
            memory,
            of,
            count,
            shape,
            figures,
        })
    });
    Ok(Memories {
        origin: cacti.settings(),
        macros: macros.collect::<Result<_, SynthError>>()?,
    })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use potamoi_formats::config::PRESETS;

    fn of(preset: &str, unit: UnitKind) -> (Vec<String>, Vec<(String, String)>) {
        let text = PRESETS
            .into_iter()
            .find(|(name, _)| *name == preset)
            .unwrap()
            .1;
        let module = unit
            .module(&Config::from_toml(text, preset).unwrap())
            .unwrap();
        let (macros, others) = split(&module, unit);
        let macros = macros.iter().map(|m| {
            let ports = (m.read_writes, m.writes, m.reads);
            format!(
                "{} {} of {} x {} {ports:?}",
                m.module, m.count, m.words, m.bits
            )
        });
        let others = others.into_iter().map(|m| {
            (
                format!("{} {} of {} x {}", m.memory, m.count, m.words, m.bits),
                m.why,
            )
        });
        (macros.collect(), others.collect())
    }

    /// Every memory of a unit is either a macro or of flip-flops.
    #[test]
    fn memories_are_macros_or_flip_flops_for_a_reason() {
        let (macros, others) = of("paper", UnitKind::Gathering);
        assert_eq!(
            macros,
            [
                "mft_bank 64 of 512 x 16 (1, 0, 1)",
                "rit_bank 6 of 128 x 128 (0, 1, 1)"
            ]
        );
        assert_eq!(others.len(), 1);
        assert_eq!(others[0].0, "feature_fifo 1 of 4 x 1059");
        assert!(others[0].1.contains("without a clock"));

        let (macros, others) = of("paper", UnitKind::Vector);
        assert!(macros.is_empty());
        assert_eq!(others[0].0, "result_fifo 1 of 3 x 793");

        let (macros, others) = of("feature-major", UnitKind::Gathering);
        assert_eq!(
            macros,
            [
                "mft_bank 32 of 512 x 16 (1, 0, 0)",
                "rit_bank 6 of 128 x 128 (0, 1, 1)"
            ]
        );
        let why = |name: &str| &others.iter().find(|(m, _)| m.starts_with(name)).unwrap().1;
        assert!(why("lane_entries 16 of 16 x 32").contains("16 words of 32 bits: CACTI models"));
        assert!(why("lane_slots 16 of 2 x 16").contains("2 words of 16 bits: CACTI models"));
        assert!(why("feature_fifo").contains("without a clock"));
    }

    #[test]
    fn the_system_has_the_papers_bytes() {
        let [features, weights] = system();
        assert_eq!(features.1 * features.2.words * features.2.bits / 8, 3 << 19);
        assert_eq!(weights.1 * weights.2.words * weights.2.bits / 8, 96 << 10);
        for (_, _, shape) in system() {
            assert_eq!(cacti::is_modelled(&shape), Ok(()));
        }
    }
}
