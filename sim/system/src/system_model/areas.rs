//! Areas of the accelerator's blocks at the system's node: cells without wires, and memories.

use potamoi_formats::config::Config;
use potamoi_synth::fit::Fit;
use potamoi_synth::{
    MemoryReport, MemoryTable, SYSTEM, Shape, SynthReport, Synthesised, UnitKind, scaling,
};
use schemars::JsonSchema;
use serde::Serialize;

use super::logic::{Logic, NODE_NM};
use super::system::System;
use super::unit_source::{Known, UnitSource};

/// Memories of one kind in the blocks of one kind.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct BlockMemory {
    /// Its name.
    pub memory: String,
    /// Number of such memories.
    pub count: u64,
    /// Words of one.
    pub words: u64,
    /// Width of a word in bits.
    pub bits: u64,
    /// Area of all of them by CACTI, in square millimetres.
    pub mm2: f64,
}

impl BlockMemory {
    fn of(own: &MemoryReport, factors: &scaling::Factors) -> Self {
        Self {
            memory: own.memory.clone(),
            count: own.count,
            words: own.shape.words,
            bits: own.shape.bits,
            mm2: own.count as f64 * own.figures.area_um2 * factors.area * 1e-6,
        }
    }

    /// The memories of so many blocks.
    fn times(self, blocks: u64) -> Self {
        Self {
            count: self.count * blocks,
            mm2: self.mm2 * blocks as f64,
            ..self
        }
    }
}

/// Area of the blocks of one kind, in square millimetres.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct BlockArea {
    /// Its name.
    pub block: String,
    /// Number of such blocks.
    pub count: u64,
    /// Cells of all of them, without wires; `None` where they are not known.
    pub logic_mm2: Option<f64>,
    /// Memories of all of them by CACTI; `None` where they are not known.
    pub memories_mm2: Option<f64>,
    /// Each kind of memory; none where they are not known.
    pub memories: Vec<BlockMemory>,
    /// Origin of the figures, or why one is not known.
    pub from: String,
}

impl BlockArea {
    /// Cells and memories, where both are known.
    #[must_use]
    pub fn mm2(&self) -> Option<f64> {
        Some(self.logic_mm2? + self.memories_mm2?)
    }
}

/// Area of the blocks of the accelerator.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Area {
    /// The units, the MAC array and the buffers.
    pub blocks: Vec<BlockArea>,
    /// Gathering unit, vector unit and splat units with their memories, where all are known.
    pub units_mm2: Option<f64>,
    /// All blocks, where all are known.
    pub total_mm2: Option<f64>,
}

impl Area {
    /// Areas of a configuration's units, from the first of the reports that has one or from formulas; of
    /// the array and the buffers of `around`, whose unit and banks `system` has.
    #[must_use]
    pub fn of(
        config: &Config,
        fit: &Fit,
        reports: &[Synthesised],
        system: &SynthReport,
        around: &System,
    ) -> Self {
        let known = Known {
            fit,
            reports,
            estimated: &[],
        };
        let mut units = vec![
            unit(config, &known, UnitKind::Gathering, 1),
            unit(config, &known, UnitKind::Vector, 1),
        ];
        if let Some(su) = &config.su {
            units.push(unit(config, &known, UnitKind::Splat, su.units.into()));
        }
        let sum = |all: &[BlockArea]| all.iter().map(BlockArea::mm2).sum();
        let units_mm2 = sum(&units);
        let mut blocks = units;
        blocks.push(array(system, around));
        blocks.extend(buffers(system, around));
        Self {
            units_mm2,
            total_mm2: sum(&blocks),
            blocks,
        }
    }
}

/// Cells of a unit of a report at the system's node, in square millimetres.
fn cells_mm2(report: &SynthReport, unit: UnitKind) -> Option<f64> {
    let factors = scaling::logic(report.library.node_nm?, NODE_NM)?;
    Some(report.unit(unit)?.area_um2 * factors.area * 1e-6)
}

/// Memories of a unit of a report, at the system's node; `None` where they were not modelled.
fn memories(report: &SynthReport, unit: UnitKind) -> Option<Vec<BlockMemory>> {
    if report.unit(unit).is_some_and(|own| own.memories.is_empty()) {
        return Some(vec![]);
    }
    let all = report.raw.memories.as_ref()?;
    let factors = scaling::memory(all.origin.node_nm, NODE_NM)?;
    let own = all.macros.iter().filter(|own| own.of == unit.top());
    Some(own.map(|own| BlockMemory::of(own, &factors)).collect())
}

/// All units of a kind with their memories.
fn unit(config: &Config, known: &Known<'_>, unit: UnitKind, count: u64) -> BlockArea {
    // A sum of none is -0.0.
    let times = |of: f64| count as f64 * of + 0.0;
    let (logic, memories) = match known.source(config, unit) {
        UnitSource::Synthesised(own) => {
            let report = &own.report;
            let from = format!("synthesis in {}", report.library.name);
            let logic = cells_mm2(report, unit).ok_or_else(|| from.clone());
            let memories = memories(report, unit);
            (
                logic.map(|mm2| (mm2, from)),
                memories.ok_or_else(|| "synthesise with CACTI (tools/setup memories)".to_owned()),
            )
        }
        _ => {
            let node = known.fit.grid().library.node_nm;
            let factors = node.and_then(|nm| scaling::logic(nm, NODE_NM));
            let logic = factors
                .ok_or_else(|| "the formulas are of a node without factors".to_owned())
                .and_then(|factors| Logic::of(known, config, unit, &factors));
            (
                logic.map(|(own, from)| (own.area_um2 * 1e-6, from.to_owned())),
                memories_by_shape(config, unit),
            )
        }
    };
    let lacks = match &memories {
        Ok(_) => String::new(),
        Err(why) => format!("; memories not known: {why}"),
    };
    let memories = memories.ok();
    let sum = |all: &Vec<BlockMemory>| times(all.iter().map(|own| own.mm2).sum());
    BlockArea {
        block: unit.top().to_owned(),
        count,
        logic_mm2: logic.as_ref().ok().map(|(mm2, _)| times(*mm2)),
        memories_mm2: memories.as_ref().map(sum),
        memories: (memories.into_iter().flatten())
            .map(|own| own.times(count))
            .collect(),
        from: match logic {
            Ok((_, from)) => format!("{from}{lacks}"),
            Err(why) => why,
        },
    }
}

/// Memories of a unit that was not synthesised, at the system's node.
fn memories_by_shape(config: &Config, unit: UnitKind) -> Result<Vec<BlockMemory>, String> {
    // Vector units have none: their FIFO is flip-flops.
    if unit == UnitKind::Vector {
        return Ok(vec![]);
    }
    let table = MemoryTable::checked_in().map_err(|error| error.to_string())?;
    let factors = scaling::memory(table.origin.node_nm, NODE_NM)
        .ok_or_else(|| format!("no factors from {} nm", table.origin.node_nm))?;
    let all = table.of_unit(config, unit)?;
    Ok(all
        .iter()
        .map(|own| BlockMemory::of(own, &factors))
        .collect())
}

fn array(system: &SynthReport, around: &System) -> BlockArea {
    let (unit, macs) = (UnitKind::ArrayMac, around.array().units());
    let logic_mm2 = cells_mm2(system, unit)
        .filter(|_| !around.array_double_buffered)
        .map(|of| macs as f64 * of);
    BlockArea {
        block: unit.top().to_owned(),
        count: macs,
        logic_mm2,
        memories_mm2: Some(0.0),
        memories: vec![],
        from: match (logic_mm2, around.array_double_buffered) {
            (Some(_), _) => format!("synthesis of one in {}", system.library.name),
            (None, true) => "its unit was synthesised with one register of weights, and \
                 system.array_double_buffered asks for two"
                .to_owned(),
            (None, false) => "the parameters lack its unit: potamoi synth --unit mac".to_owned(),
        },
    }
}

/// The buffers around the units, whose words are as wide as those of the paper's.
fn buffers(system: &SynthReport, around: &System) -> Vec<BlockArea> {
    let wanted = [
        (
            "global_feature_buffer",
            around.feature_buffer_bytes,
            u64::from(around.feature_banks),
        ),
        ("weight_buffer", around.weight_buffer_bytes, 1),
    ];
    let of = |(block, bytes, count): (&str, u64, u64)| {
        let bank = bank(system, block, bytes / count.max(1)).map(|own| own.times(count));
        BlockArea {
            block: block.to_owned(),
            count,
            logic_mm2: Some(0.0),
            memories_mm2: bank.as_ref().ok().map(|own| own.mm2),
            from: match &bank {
                Ok(_) => "CACTI".to_owned(),
                Err(why) => why.clone(),
            },
            memories: bank.into_iter().collect(),
        }
    };
    wanted.into_iter().map(of).collect()
}

/// A bank of a buffer: as in the parameters, or of the table of memories.
fn bank(system: &SynthReport, block: &str, bytes: u64) -> Result<BlockMemory, String> {
    let own = (system.memory(SYSTEM, block)).ok_or("the parameters lack this memory")?;
    let own = own.0;
    let node_nm = (system.raw.memories.as_ref()).map_or(0, |all| all.origin.node_nm);
    let shape = Shape {
        words: bytes * 8 / own.shape.bits,
        ..own.shape
    };
    let table = MemoryTable::checked_in().map_err(|error| error.to_string())?;
    let (figures, node_nm) = match shape == own.shape {
        true => (Some(&own.figures), node_nm),
        false => (table.figures(&shape), table.origin.node_nm),
    };
    let figures = figures.ok_or_else(|| {
        let table: Vec<String> = (table.words(&own.shape).iter())
            .map(|words| (words * own.shape.bits / 8).to_string())
            .collect();
        format!(
            "CACTI did not model a bank of {bytes} bytes; it modelled {} bytes",
            table.join(", ")
        )
    })?;
    let factors = scaling::memory(node_nm, NODE_NM).ok_or("no factors for the memory's node")?;
    let own = MemoryReport {
        count: 1,
        shape,
        figures: *figures,
        ..own.clone()
    };
    Ok(BlockMemory::of(&own, &factors))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn area(text: &str) -> Area {
        let config = Config::from_toml(text, "test").unwrap();
        let reports = Synthesised::checked_in().unwrap();
        let fit = Fit::checked_in().unwrap();
        Area::of(
            &config,
            &fit,
            &reports,
            &reports[0].report,
            &System::default(),
        )
    }

    fn block<'a>(area: &'a Area, name: &str) -> &'a BlockArea {
        area.blocks.iter().find(|own| own.block == name).unwrap()
    }

    #[test]
    fn every_block_of_the_paper_is_known_and_they_sum_up() {
        let all = area("");
        let each = all.blocks.iter().map(|own| own.mm2().unwrap());
        assert!((each.sum::<f64>() - all.total_mm2.unwrap()).abs() < 1e-12);
        assert!(all.units_mm2 < all.total_mm2);
        assert_eq!(block(&all, "array_mac").count, 576);
        assert!(block(&all, "gathering_unit").memories_mm2.unwrap() > 0.0);
        assert_eq!(block(&all, "vector_unit").memories_mm2, Some(0.0));
    }

    #[test]
    fn units_side_by_side_count_each() {
        let text = include_str!("../../../../configs/lean-splats.toml");
        let (eight, one) = (area(text), area(&text.replace("units = 8", "units = 1")));
        let [eight, one] = [&eight, &one].map(|all| block(all, "splat_unit"));
        assert_eq!((eight.count, one.count), (8, 1));
        assert!((eight.mm2().unwrap() - 8.0 * one.mm2().unwrap()).abs() < 1e-12);
    }

    /// An area that is not known leaves the rest known, and says why.
    #[test]
    fn what_was_not_synthesised_is_named() {
        let all = area("[vu.exp]\npipelined = true\n[su]\nlanes = 3\ntiles = 64\n");
        let splat = block(&all, "splat_unit");
        assert_eq!((splat.logic_mm2, splat.memories_mm2), (None, None));
        assert!(
            splat.from.contains("no formulas for this splat_unit"),
            "{}",
            splat.from
        );
        assert_eq!((all.units_mm2, all.total_mm2), (None, None));
        assert!(block(&all, "gathering_unit").mm2().is_some());
        // Two registers of weights a unit are more than the one that was synthesised.
        let doubled = System {
            array_double_buffered: true,
            ..System::default()
        };
        let reports = Synthesised::checked_in().unwrap();
        let own = array(&reports[0].report, &doubled);
        assert!(
            own.logic_mm2.is_none() && own.from.contains("asks for two"),
            "{own:?}"
        );
        // Memories are known by shape, of units that were not synthesised too.
        let wide = area("[gu]\nbanks = 24\n");
        assert!(block(&wide, "gathering_unit").mm2().is_some());
        // A buffer of another size is of the table too; one that CACTI was not asked about names those.
        let of = |bytes| Ok::<f64, String>(bank(&reports[0].report, "weight_buffer", bytes)?.mm2);
        assert!(of(49_152).unwrap() < of(98_304).unwrap());
        let error = of(50_000).unwrap_err();
        assert!(error.contains("it modelled 24576, 49152, 98304"), "{error}");
    }
}
