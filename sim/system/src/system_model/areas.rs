//! Areas of the accelerator's blocks at the system's node: cells without wires, and memories.

use potamoi_formats::config::Config;
use potamoi_synth::fit::Fit;
use potamoi_synth::{MemoryTable, SYSTEM, Shape, SynthReport, Synthesised, UnitKind, scaling};
use schemars::JsonSchema;
use serde::Serialize;

use super::logic::{Logic, NODE_NM};
use super::system::System;
use super::unit_source::{Known, UnitSource};

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
        blocks.push(array(system, around.array().units()));
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

/// Memories of an owner, at the system's node: names, number and square millimetres of each kind;
/// `None` where they were not modelled.
fn memories(report: &SynthReport, owner: &str) -> Option<Vec<(String, u64, f64)>> {
    let all = report.raw.memories.as_ref()?;
    let factors = scaling::memory(all.origin.node_nm, NODE_NM)?;
    let own = all.macros.iter().filter(|own| own.of == owner);
    Some(
        own.map(|own| {
            let each = own.figures.area_um2 * factors.area * 1e-6;
            (own.memory.clone(), own.count, own.count as f64 * each)
        })
        .collect(),
    )
}

/// All units of a kind with their memories.
fn unit(config: &Config, known: &Known<'_>, unit: UnitKind, count: u64) -> BlockArea {
    let block = unit.top().to_owned();
    // A sum of none is -0.0.
    let times = |of: f64| count as f64 * of + 0.0;
    if let UnitSource::Synthesised(own) = known.source(config, unit) {
        let report = &own.report;
        let memories = memories(report, unit.top());
        let sum = |all: Vec<(String, u64, f64)>| all.iter().map(|(.., mm2)| mm2).sum();
        let has_none = report.unit(unit).is_some_and(|own| own.memories.is_empty());
        let memories_mm2 = memories.map(sum).or(has_none.then_some(0.0)).map(times);
        let lacks = match memories_mm2 {
            Some(_) => "",
            None => "; memories not known: synthesise with CACTI (tools/setup memories)",
        };
        return BlockArea {
            block,
            count,
            logic_mm2: cells_mm2(report, unit).map(times),
            memories_mm2,
            from: format!("synthesis in {}{lacks}", report.library.name),
        };
    }
    let factors = (known.fit.grid().library.node_nm).and_then(|nm| scaling::logic(nm, NODE_NM));
    let logic = factors
        .ok_or_else(|| "the formulas are of a node without factors".to_owned())
        .and_then(|factors| Logic::of(known, config, unit, &factors));
    let memories = memories_by_shape(config, unit);
    let lacks = match &memories {
        Ok(_) => String::new(),
        Err(why) => format!("; memories not known: {why}"),
    };
    let memories_mm2 = memories.ok().map(times);
    let (logic_mm2, from) = match logic {
        Ok((own, from)) => (Some(times(own.area_um2 * 1e-6)), format!("{from}{lacks}")),
        Err(why) => (None, why),
    };
    BlockArea {
        block,
        count,
        logic_mm2,
        memories_mm2,
        from,
    }
}

/// Memories of a unit that was not synthesised, in square millimetres at the system's node.
fn memories_by_shape(config: &Config, unit: UnitKind) -> Result<f64, String> {
    // Vector units have none: their FIFO is flip-flops.
    if unit == UnitKind::Vector {
        return Ok(0.0);
    }
    let table = MemoryTable::checked_in().map_err(|error| error.to_string())?;
    let factors = scaling::memory(table.origin.node_nm, NODE_NM)
        .ok_or_else(|| format!("no factors from {} nm", table.origin.node_nm))?;
    Ok(table.area_um2(config, unit)? * factors.area * 1e-6)
}

fn array(system: &SynthReport, macs: u64) -> BlockArea {
    let unit = UnitKind::ArrayMac;
    let logic_mm2 = cells_mm2(system, unit).map(|of| macs as f64 * of);
    BlockArea {
        block: unit.top().to_owned(),
        count: macs,
        logic_mm2,
        memories_mm2: Some(0.0),
        from: match logic_mm2 {
            Some(_) => format!("synthesis of one in {}", system.library.name),
            None => "the parameters lack its unit: potamoi synth --unit mac".to_owned(),
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
        let each = bank_mm2(system, block, bytes / count.max(1));
        BlockArea {
            block: block.to_owned(),
            count,
            logic_mm2: Some(0.0),
            memories_mm2: each.as_ref().ok().map(|mm2| count as f64 * mm2),
            from: each.err().unwrap_or_else(|| "CACTI".to_owned()),
        }
    };
    wanted.into_iter().map(of).collect()
}

/// A bank of a buffer in square millimetres: as in the parameters, or of the table of memories.
fn bank_mm2(system: &SynthReport, block: &str, bytes: u64) -> Result<f64, String> {
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
    Ok(figures.area_um2 * factors.area * 1e-6)
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
        // Memories are known by shape, of units that were not synthesised too.
        let wide = area("[gu]\nbanks = 24\n");
        assert!(block(&wide, "gathering_unit").mm2().is_some());
        // A buffer of another size is of the table too; one that CACTI was not asked about names those.
        let reports = Synthesised::checked_in().unwrap();
        let of = |bytes| bank_mm2(&reports[0].report, "weight_buffer", bytes);
        assert!(of(49_152).unwrap() < of(98_304).unwrap());
        let error = of(50_000).unwrap_err();
        assert!(error.contains("it modelled 24576, 49152, 98304"), "{error}");
    }
}
