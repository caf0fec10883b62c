//! Areas of the accelerator's blocks at the system's node: cells without wires, and memories.

use potamoi_formats::config::Config;
use potamoi_synth::fit::Fit;
use potamoi_synth::{SYSTEM, SynthReport, Synthesised, UnitKind, scaling};
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
    // Vector units have no memories: their FIFO is flip-flops.
    let memories_mm2 = (unit == UnitKind::Vector).then_some(0.0);
    let lacks = match memories_mm2 {
        Some(_) => "",
        None => "; memories not known: potamoi synth --json F, then --synth F",
    };
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

/// The buffers around the units. Banks of another size than those that were modelled have no known area.
fn buffers(system: &SynthReport, around: &System) -> Vec<BlockArea> {
    let wanted = [
        (
            "global_feature_buffer",
            around.feature_buffer_bytes,
            u64::from(around.feature_banks),
        ),
        ("weight_buffer", around.weight_buffer_bytes, 1),
    ];
    let all = memories(system, SYSTEM).unwrap_or_default();
    let bytes_of = |name: &str| {
        let shape = &system.memory(SYSTEM, name)?.0.shape;
        Some(shape.words * shape.bits / 8)
    };
    let of = |(block, bytes, count): (&str, u64, u64)| {
        let known = all.iter().find(|(name, ..)| name == block);
        let bank = bytes / count.max(1);
        let same = bytes_of(block).filter(|own| *own == bank);
        let each = known.map(|(_, count, mm2)| mm2 / *count as f64);
        BlockArea {
            block: block.to_owned(),
            count,
            logic_mm2: Some(0.0),
            memories_mm2: each
                .filter(|_| same.is_some())
                .map(|mm2| count as f64 * mm2),
            from: match (same, bytes_of(block)) {
                (Some(_), _) => "CACTI".to_owned(),
                (None, Some(own)) => {
                    format!("a bank of {bank} bytes was not modelled, one of {own} bytes was")
                }
                (None, None) => "the parameters lack this memory".to_owned(),
            },
        }
    };
    wanted.into_iter().map(of).collect()
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
        let wide = area("[gu]\nbanks = 24\n");
        let gathering = block(&wide, "gathering_unit");
        assert!(gathering.logic_mm2.is_some() && gathering.memories_mm2.is_none());
        assert!(
            gathering.from.contains("memories not known"),
            "{}",
            gathering.from
        );
    }
}
