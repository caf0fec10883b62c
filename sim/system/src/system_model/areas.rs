//! Areas of the accelerator's blocks at the system's node: cells without wires, and memories.

use potamoi_formats::config::Config;
use potamoi_synth::fit::Fit;
use potamoi_synth::{MemoryReport, SynthReport, Synthesised, UnitKind, scaling};
use schemars::JsonSchema;
use serde::Serialize;

use super::logic::{Logic, NODE_NM};
use super::on_chip_memories::{
    self, FEATURE_BUFFER, TABLE_QUEUE, WEIGHT_BUFFER, feature_banks, weight_buffer,
};
use super::on_chip_sizes::OnChipSizes;
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
    fn of(own: &MemoryReport) -> Self {
        Self {
            memory: own.memory.clone(),
            count: own.count,
            words: own.shape.words,
            bits: own.shape.bits,
            mm2: own.count as f64 * own.figures.area_um2 * 1e-6,
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
    /// the array and the buffers of `sizes`, whose unit and banks `system` has.
    #[must_use]
    pub fn of(
        config: &Config,
        fit: &Fit,
        reports: &[Synthesised],
        system: &SynthReport,
        sizes: &OnChipSizes,
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
        blocks.push(array(system, sizes));
        blocks.extend(on_chip_memories::unbuilt_queue(config).map(unbuilt));
        blocks.extend(buffers(system, sizes));
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

/// All units of a kind with their memories.
fn unit(config: &Config, known: &Known<'_>, unit: UnitKind, count: u64) -> BlockArea {
    // A sum of none is -0.0.
    let times = |of: f64| count as f64 * of + 0.0;
    let logic = match known.source(config, unit) {
        UnitSource::Synthesised(own) => {
            let from = format!("synthesis in {}", own.report.library.name);
            let logic = cells_mm2(&own.report, unit).ok_or_else(|| from.clone());
            logic.map(|mm2| (mm2, from))
        }
        _ => {
            let node = known.fit.grid().library.node_nm;
            let factors = node.and_then(|nm| scaling::logic(nm, NODE_NM));
            factors
                .ok_or_else(|| "the formulas are of a node without factors".to_owned())
                .and_then(|factors| Logic::of(known, config, unit, &factors))
                .map(|(own, from)| (own.area_um2 * 1e-6, from.to_owned()))
        }
    };
    let memories = on_chip_memories::of_unit(config, known, unit);
    let lacks = match &memories {
        Ok(_) => String::new(),
        Err(why) => format!("; memories not known: {why}"),
    };
    let memories = (memories.ok()).map(|all| all.iter().map(BlockMemory::of).collect());
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

fn array(system: &SynthReport, sizes: &OnChipSizes) -> BlockArea {
    let (unit, macs) = (UnitKind::ArrayMac, sizes.array.units());
    let cells = match sizes.unbuilt_array() {
        Some(why) => Err(why),
        None => {
            cells_mm2(system, unit).ok_or("the parameters lack its unit: potamoi synth --unit mac")
        }
    };
    BlockArea {
        block: unit.top().to_owned(),
        count: macs,
        logic_mm2: cells.ok().map(|of| macs as f64 * of),
        memories_mm2: Some(0.0),
        memories: vec![],
        from: cells.map_or_else(str::to_owned, |_| {
            format!("synthesis of one in {}", system.library.name)
        }),
    }
}

/// The queue of a table that takes no way through memory.
fn unbuilt(why: &str) -> BlockArea {
    BlockArea {
        block: TABLE_QUEUE.to_owned(),
        count: 1,
        logic_mm2: None,
        memories_mm2: None,
        memories: vec![],
        from: why.to_owned(),
    }
}

/// The buffers around the units.
fn buffers(system: &SynthReport, sizes: &OnChipSizes) -> [BlockArea; 2] {
    let of = |block: &str, banks: Result<MemoryReport, String>| {
        let own = banks.as_ref().ok().map(BlockMemory::of);
        BlockArea {
            block: block.to_owned(),
            count: own.as_ref().map_or(0, |own| own.count),
            logic_mm2: Some(0.0),
            memories_mm2: own.as_ref().map(|own| own.mm2),
            from: banks.map_or_else(|why| why, |_| "CACTI".to_owned()),
            memories: own.into_iter().collect(),
        }
    };
    [
        of(FEATURE_BUFFER, feature_banks(system, sizes)),
        of(WEIGHT_BUFFER, weight_buffer(system, sizes)),
    ]
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
            &OnChipSizes::default(),
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
        let doubled = OnChipSizes {
            array_double_buffered: true,
            ..OnChipSizes::default()
        };
        let reports = Synthesised::checked_in().unwrap();
        let own = array(&reports[0].report, &doubled);
        assert!(
            own.logic_mm2.is_none() && own.from.contains("asks for two"),
            "{own:?}"
        );
        // What no unit has is not free.
        let direct = area("rit.path = \"direct\"");
        assert!(direct.total_mm2.is_none() && direct.units_mm2.is_some());
        let queue = block(&direct, TABLE_QUEUE);
        assert!(queue.from.contains("not built"), "{}", queue.from);
        // Memories are known by shape, of units that were not synthesised too.
        let wide = area("[gu]\nbanks = 24\n");
        assert!(block(&wide, "gathering_unit").mm2().is_some());
    }
}
