//! File of synthesised parameters.

use potamoi_formats::config::Config;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::fanout::{FAN_OUT, LOAD};
use super::scaling::{self, Factors};
use super::{Figures, Library, Memories, Power, Tools, UnitKind, UnitReport};

/// Version of the file.
pub const FORMAT_VERSION: u32 = 5;
pub(super) const COMMAND: &str = "synth";

/// Parameters of a configuration's units, with their sources.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SynthReport {
    pub(super) format_version: u32,
    pub(super) command: String,
    /// Hash of the configuration, 12 hexadecimal digits.
    pub(super) configuration: String,
    /// The configuration itself as TOML, by which a search knows what units the figures are of; files of
    /// earlier programs have none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) configuration_toml: Option<String>,
    /// Source of the cells.
    pub library: LibraryOrigin,
    tools: ToolsOrigin,
    flow: Flow,
    /// Effects that the figures leave out.
    without: Vec<String>,
    /// Figures at the nodes of their models.
    pub raw: Raw,
    /// Figures scaled to another node by published factors.
    pub scaled: Option<Scaled>,
}

/// A cell library.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct LibraryOrigin {
    /// Its own name.
    pub name: String,
    /// SHA-256 of the Liberty text.
    pub sha256: String,
    /// Node in nanometres, if stated by the user: no Liberty file states it.
    pub node_nm: Option<u32>,
    /// Nominal supply voltage in volts.
    pub volts: Option<f64>,
}

/// Versions of the programs.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct ToolsOrigin {
    /// Yosys, as it reports it.
    pub yosys: String,
    /// OpenSTA.
    pub opensta: String,
}

impl LibraryOrigin {
    /// Origin of a library; `node_nm` is stated by the user.
    pub(super) fn new(library: &Library, node_nm: Option<u32>) -> Self {
        Self {
            name: library.name.clone(),
            sha256: library.sha256.clone(),
            node_nm,
            volts: library.volts,
        }
    }
}

impl ToolsOrigin {
    pub(super) fn new(tools: &Tools) -> Self {
        Self {
            yosys: tools.yosys.clone(),
            opensta: tools.opensta.clone(),
        }
    }
}

/// Limits of nets between modules.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
struct Flow {
    /// Fan-out.
    fan_out: usize,
    /// Load as a share of `max_capacitance`.
    load: f64,
}

/// Figures at the nodes of their models.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Raw {
    /// The units, at the library's node.
    pub units: Vec<UnitReport>,
    /// Their memories and the system's, where CACTI is installed.
    pub memories: Option<Memories>,
}

/// Figures at another node.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Scaled {
    /// Node in nanometres.
    pub node_nm: u32,
    /// Units, where the library's node is known and in the table.
    pub logic: Option<ScaledLogic>,
    /// Memories.
    pub memories: Option<ScaledMemories>,
}

/// Units at another node.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ScaledLogic {
    /// Scaling factors.
    pub factors: Factors,
    /// Scaled units, in the order of the raw ones.
    pub units: Vec<ScaledUnit>,
}

/// A unit at another node, without its memories.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ScaledUnit {
    /// Its top module.
    pub unit: String,
    /// Area in square micrometres.
    pub area_um2: f64,
    /// Longest path in picoseconds.
    pub period_ps: f64,
    /// Clock in gigahertz for that period.
    pub clock_ghz: f64,
    /// Longest path with the memories' access times in picoseconds, where known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub with_memories_ps: Option<f64>,
    /// Energy, where power was estimated.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub energy: Option<ScaledEnergy>,
}

/// Energy of a unit at another node, for the activity in [`Power`].
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ScaledEnergy {
    /// Picojoules a cycle with zero delays.
    pub zero_delay_pj_a_cycle: f64,
    /// Picojoules a cycle with glitches.
    pub with_glitches_pj_a_cycle: f64,
    /// Picojoules a sample or an exponential with zero delays.
    pub zero_delay_pj_an_item: f64,
    /// Picojoules a sample or an exponential with glitches.
    pub with_glitches_pj_an_item: f64,
}

impl ScaledEnergy {
    /// Scaled energy of a unit, if its power was estimated.
    pub(super) fn of(unit: &UnitReport, factors: &Factors) -> Option<Self> {
        let Some(Power::Estimated(power)) = &unit.power else {
            return None;
        };
        let (zero, glitches) = (&power.zero_delay, &power.with_glitches);
        Some(Self {
            zero_delay_pj_a_cycle: zero.pj_a_cycle * factors.energy,
            with_glitches_pj_a_cycle: glitches.pj_a_cycle * factors.energy,
            zero_delay_pj_an_item: zero.pj_an_item * factors.energy,
            with_glitches_pj_an_item: glitches.pj_an_item * factors.energy,
        })
    }
}

/// Longest path of a unit with its memories, at another node.
pub(super) fn with_memories_ps(unit: &UnitReport, factors: &Factors) -> Option<f64> {
    let own = unit.with_memories.as_ref()?;
    Some(own.period_ps * factors.delay)
}

/// Memories at another node.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ScaledMemories {
    /// Scaling factors.
    pub factors: Factors,
    /// Scaled memories, in the order of the raw ones.
    pub macros: Vec<ScaledMemory>,
}

/// A memory at another node.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ScaledMemory {
    /// Its name.
    pub memory: String,
    /// Top module of its unit, or the system.
    pub of: String,
    /// Figures of one.
    #[serde(flatten)]
    pub figures: Figures,
}

impl Scaled {
    /// Scales raw figures to `to_nm`; `from_nm` is the library's node, if known.
    #[must_use]
    pub fn new(raw: &Raw, from_nm: Option<u32>, to_nm: u32) -> Self {
        let logic = from_nm.and_then(|from| scaling::logic(from, to_nm));
        let memories = raw.memories.as_ref().and_then(|memories| {
            let factors = scaling::memory(memories.origin.node_nm, to_nm)?;
            let macros = memories.macros.iter().map(|own| ScaledMemory {
                memory: own.memory.clone(),
                of: own.of.clone(),
                figures: own.figures.scaled(&factors),
            });
            let macros = macros.collect();
            Some(ScaledMemories { factors, macros })
        });
        let units = |factors: &Factors| {
            let units = raw.units.iter().map(|unit| ScaledUnit {
                unit: unit.unit.clone(),
                area_um2: unit.area_um2 * factors.area,
                period_ps: unit.period_ps * factors.delay,
                clock_ghz: 1e3 / (unit.period_ps * factors.delay),
                with_memories_ps: with_memories_ps(unit, factors),
                energy: ScaledEnergy::of(unit, factors),
            });
            units.collect()
        };
        Self {
            node_nm: to_nm,
            logic: logic.map(|factors| ScaledLogic {
                units: units(&factors),
                factors,
            }),
            memories,
        }
    }
}

impl SynthReport {
    /// A report of these figures; `node_nm` is the library's node, `to_nm` the target of scaling.
    #[must_use]
    pub fn new(
        config: &Config,
        library: &Library,
        tools: &Tools,
        raw: Raw,
        node_nm: Option<u32>,
        to_nm: u32,
    ) -> Self {
        let mut without = vec![
            "wires and the clock tree: areas are of cells, periods before placement",
            "paths that begin or end in a memory, but for with_memories; what joins memories to the units",
        ];
        if raw.units.iter().any(|unit| unit.power.is_none()) {
            without.push("power: not asked for (--activity none)");
        }
        if raw.memories.is_none() {
            without.push("memories: CACTI is not installed (tools/setup memories)");
        }
        Self {
            format_version: FORMAT_VERSION,
            command: COMMAND.to_owned(),
            configuration: config.hash(),
            configuration_toml: config.to_toml().ok(),
            library: LibraryOrigin::new(library, node_nm),
            tools: ToolsOrigin::new(tools),
            flow: Flow {
                fan_out: FAN_OUT,
                load: LOAD,
            },
            without: without.into_iter().map(str::to_owned).collect(),
            scaled: Some(Scaled::new(&raw, node_nm, to_nm)),
            raw,
        }
    }
}

impl SynthReport {
    /// Removes units that are not in `units`, and their memories. Returns the top modules of the
    /// units present before.
    pub fn keep(&mut self, units: &[UnitKind]) -> Vec<String> {
        let is_kept = |top: &str| units.iter().any(|unit| unit.top() == top);
        let all = self.raw.units.iter().map(|u| u.unit.clone());
        let left_out: Vec<String> = all.filter(|top| !is_kept(top)).collect();
        let stays = |top: &String| !left_out.contains(top);
        self.raw.units.retain(|u| stays(&u.unit));
        if let Some(memories) = &mut self.raw.memories {
            memories.macros.retain(|m| stays(&m.of));
        }
        if let Some(scaled) = &mut self.scaled {
            if let Some(logic) = &mut scaled.logic {
                logic.units.retain(|u| stays(&u.unit));
            }
            if let Some(memories) = &mut scaled.memories {
                memories.macros.retain(|m| stays(&m.of));
            }
        }
        left_out
    }
}

/// Differences of two reports, one line each: path, value here, expected value.
#[must_use]
pub fn differences(here: &Value, expected: &Value) -> Vec<String> {
    let mut found = vec![];
    compare(String::new(), Some(here), Some(expected), &mut found);
    found
}

fn compare(place: String, here: Option<&Value>, expected: Option<&Value>, found: &mut Vec<String>) {
    let inside = |name: &str| match place.is_empty() {
        true => name.to_owned(),
        false => format!("{place}.{name}"),
    };
    match (here, expected) {
        (Some(Value::Object(a)), Some(Value::Object(b))) => {
            let others = b.keys().filter(|name| !a.contains_key(*name));
            for name in a.keys().chain(others) {
                compare(inside(name), a.get(name), b.get(name), found);
            }
        }
        (Some(Value::Array(a)), Some(Value::Array(b))) => {
            for i in 0..a.len().max(b.len()) {
                compare(format!("{place}[{i}]"), a.get(i), b.get(i), found);
            }
        }
        (here, expected) if here != expected => {
            let said = |v: Option<&Value>| v.map_or_else(|| "nothing".to_owned(), Value::to_string);
            found.push(format!(
                "{place}: {}, expected {}",
                said(here),
                said(expected)
            ));
        }
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use serde_json::json;

    /// What remains of the paper's report is that of its gathering unit alone.
    #[test]
    fn units_that_are_left_out_take_their_memories_with_them() {
        let [all, _] = SynthReport::checked_in().unwrap();
        let mut both = all.clone();
        assert_eq!(both.keep(&UnitKind::ALL), Vec::<String>::new());
        assert_eq!(both, all);

        let mut vector = all.clone();
        let vector_alone = vector.keep(&[UnitKind::Vector]);
        assert_eq!(vector_alone, ["gathering_unit", "array_mac"]);
        let names = |memories: &Memories| -> Vec<String> {
            memories.macros.iter().map(|m| m.memory.clone()).collect()
        };
        let system = ["global_feature_buffer", "weight_buffer"];
        assert_eq!(names(&vector.raw.memories.clone().unwrap()), system);
        assert_eq!(vector.raw.units[..], all.raw.units[1..2]);
        let scaled = vector.scaled.clone().unwrap();
        assert_eq!(scaled.logic.unwrap().units.len(), 1);
        assert_eq!(scaled.memories.unwrap().macros.len(), 2);

        let mut gathering = all.clone();
        let gathering_alone = gathering.keep(&[UnitKind::Gathering]);
        assert_eq!(gathering_alone, ["vector_unit", "array_mac"]);
        assert_eq!(gathering.raw.memories, all.raw.memories);
        assert_eq!(gathering.raw.units[..], all.raw.units[..1]);
    }

    /// 1185 ps at 7 nm times 1.26, of a unit with memories alone.
    #[test]
    fn the_period_with_memories_is_scaled_where_it_is_known() {
        let [report, _] = SynthReport::checked_in().unwrap();
        let mut raw = report.raw;
        let scaled = |raw: &Raw| -> Vec<Option<f64>> {
            let scaled = Scaled::new(raw, Some(7), 12).logic.unwrap();
            scaled.units.iter().map(|u| u.with_memories_ps).collect()
        };
        let [Some(gathering), None, None] = scaled(&raw)[..] else {
            unreachable!("the others have no memories")
        };
        assert!((gathering - 1175.657272 * 1.26).abs() < 1e-6, "{gathering}");
        raw.units[0].with_memories = None;
        assert_eq!(scaled(&raw), [None, None, None]);
        assert_eq!(Scaled::new(&raw, None, 12).logic, None);
    }

    #[test]
    fn differences_are_named_by_place() {
        let a = json!({"tools": {"yosys": "0.23"}, "units": [{"cells": 1}, {"cells": 2}]});
        assert_eq!(differences(&a, &a), Vec::<String>::new());
        let b = json!({"tools": {"yosys": "0.70", "sta": "2"}, "units": [{"cells": 1}]});
        assert_eq!(
            differences(&a, &b),
            [
                "tools.yosys: \"0.23\", expected \"0.70\"",
                "tools.sta: nothing, expected \"2\"",
                "units[1]: {\"cells\":2}, expected nothing",
            ]
        );
    }
}
