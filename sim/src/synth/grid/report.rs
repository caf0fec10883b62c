//! The file of what synthesis made of the grid.

use potamoi_formats::config::Config;
use potamoi_hdl::ir::{Header, verilog};
use serde::{Deserialize, Serialize};

use super::design::{Family, Point};
use crate::synth::report::{LibraryOrigin, ToolsOrigin};
use crate::synth::{Library, Power, SynthError, Tools, UnitKind, UnitReport};

/// Version of the file.
const FORMAT_VERSION: u32 = 1;

/// Configurations that went through synthesis.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Grid {
    format_version: u32,
    /// Where cells come from.
    pub library: LibraryOrigin,
    pub(super) tools: ToolsOrigin,
    /// One for each of the design, in its order.
    pub points: Vec<GridPoint>,
}

/// One of them.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GridPoint {
    /// Which units it is one of.
    pub family: Family,
    /// What it has in place of the defaults, as TOML.
    pub config: String,
    /// Of its Verilog, 16 hexadecimal digits.
    pub verilog: String,
    /// Picoseconds of the longest path before wires.
    pub period_ps: f64,
    /// Where that begins and ends.
    pub path: [String; 2],
    /// What moved it, where its power was estimated.
    pub activity: Option<GridActivity>,
    /// Its modules, the top one first.
    pub modules: Vec<GridModule>,
}

/// What moved a unit.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GridActivity {
    /// The scene.
    pub scene: String,
    /// Cycles.
    pub cycles: u64,
    /// Of those, cycles in which the unit issued.
    pub busy: u64,
    /// Channels of a sample; 0 of the vector unit.
    pub channels: u64,
}

/// All modules of a kind.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GridModule {
    /// Its name.
    pub module: String,
    /// How many there are.
    pub count: u64,
    /// Square micrometres of one.
    pub area_um2: f64,
    /// Of all of them, where it was estimated.
    pub energy: Option<GridEnergy>,
}

/// Energy of all modules of a kind.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GridEnergy {
    /// Picojoules a cycle, each net changing at most once a cycle.
    pub zero_delay_pj: f64,
    /// The same with glitches.
    pub with_glitches_pj: f64,
    /// Nanowatts at rest, the clock standing still.
    pub leakage_nw: f64,
}

impl Grid {
    /// Of points that were made so.
    #[must_use]
    pub fn new(
        library: &Library,
        node_nm: Option<u32>,
        tools: &Tools,
        points: Vec<GridPoint>,
    ) -> Self {
        Self {
            format_version: FORMAT_VERSION,
            library: LibraryOrigin::new(library, node_nm),
            tools: ToolsOrigin::new(tools),
            points,
        }
    }
}

impl GridPoint {
    /// A point of the design, of what synthesis made of it.
    ///
    /// # Errors
    /// No power was estimated where there should be; the netlist's own checks.
    pub fn new(point: &Point, config: &Config, unit: &UnitReport) -> Result<Self, SynthError> {
        let power = match (point.has_power, &unit.power) {
            (false, _) => None,
            (true, Some(Power::Estimated(power))) => Some(power),
            (true, other) => {
                let why = match other {
                    Some(Power::Absent { absent }) => format!("no power: {absent}"),
                    _ => "its power was not asked for".to_owned(),
                };
                let point = point.text.replace('\n', "; ");
                return Err(SynthError::Grid { point, why });
            }
        };
        let modules = unit.modules.iter().map(|own| {
            let found = power.and_then(|p| p.modules.iter().find(|m| m.module == own.module));
            GridModule {
                module: own.module.clone(),
                count: own.count,
                area_um2: own.area_um2,
                energy: found.map(|found| GridEnergy {
                    zero_delay_pj: found.zero_delay_pj_a_cycle,
                    with_glitches_pj: found.with_glitches_pj_a_cycle,
                    leakage_nw: found.leakage_nw,
                }),
            }
        });
        Ok(Self {
            family: point.family,
            config: point.text.clone(),
            verilog: digest(config, point.family.unit())?,
            period_ps: unit.period_ps,
            path: unit.path.clone(),
            activity: power.map(|power| GridActivity {
                scene: power.activity.scene.clone(),
                cycles: power.activity.cycles,
                busy: power.activity.busy,
                channels: power.activity.channels,
            }),
            modules: modules.collect(),
        })
    }
}

/// Of the Verilog of a unit, 16 hexadecimal digits.
fn digest(config: &Config, unit: UnitKind) -> Result<String, SynthError> {
    let header = Header {
        origin: String::new(),
        command: String::new(),
    };
    let mut hasher = blake3::Hasher::new();
    for (name, text) in verilog(&unit.module(config)?, &header) {
        for part in [name, text] {
            hasher.update(&(part.len() as u64).to_le_bytes());
            hasher.update(part.as_bytes());
        }
    }
    Ok(hasher.finalize().to_hex()[..16].to_owned())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::synth::SynthReport;
    use std::path::Path;

    /// The paper's gathering unit as it was synthesised, as a point.
    fn paper(has_power: bool, change: fn(&mut UnitReport)) -> Result<GridPoint, SynthError> {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../synth/paper-asap7.json");
        let mut unit = SynthReport::read(&path).unwrap().raw.units.remove(0);
        change(&mut unit);
        let point = Point {
            family: Family::Gathering,
            text: "gu.banks = 32\n".to_owned(),
            has_power,
        };
        GridPoint::new(&point, &point.config().unwrap(), &unit)
    }

    #[test]
    fn a_point_has_what_synthesis_found_of_each_module() {
        let found = paper(true, |_| {}).unwrap();
        let activity = found.activity.unwrap();
        assert_eq!((&*activity.scene, activity.channels), ("lantern", 13));
        assert!(activity.busy <= activity.cycles);
        let reducers = found
            .modules
            .iter()
            .find(|m| m.module == "reducer")
            .unwrap();
        assert_eq!(reducers.count, 64);
        let energy = reducers.energy.unwrap();
        assert!(energy.with_glitches_pj > energy.zero_delay_pj && energy.leakage_nw > 0.0);
        assert_eq!(
            found.verilog,
            digest(&Config::paper(), UnitKind::Gathering).unwrap()
        );
        let other = Config::from_toml("gu.banks = 16\n", "test").unwrap();
        assert_ne!(found.verilog, digest(&other, UnitKind::Gathering).unwrap());
    }

    #[test]
    fn power_that_is_missing_is_named_where_it_should_be() {
        let error = |change| paper(true, change).unwrap_err().to_string();
        let none = error(|unit| unit.power = None);
        assert!(
            none.contains("gu.banks = 32; ") && none.contains("not asked for"),
            "{none}"
        );
        let absent = error(|unit| {
            let absent = "no delays".to_owned();
            unit.power = Some(Power::Absent { absent });
        });
        assert!(absent.contains("no power: no delays"), "{absent}");
        let without = paper(false, |unit| unit.power = None).unwrap();
        assert!(without.activity.is_none() && without.modules.iter().all(|m| m.energy.is_none()));
    }
}
