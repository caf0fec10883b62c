//! Hardware of an effect: what leaving it out saves in area, cycles and energy.

use potamoi_analysis::{Hardware, LeftOut};
use potamoi_base::effects::Effect;
use potamoi_cycles::batch::Batch;
use potamoi_formats::config::{Config, Modes, rules};
use potamoi_scene::Scene;
use potamoi_synth::UnitKind;
use potamoi_system::system_model::{Area, Costs, System};
use schemars::JsonSchema;
use serde::Serialize;

use crate::ExploreError;
use crate::setup::{costs_and_area, module_area};

/// A figure with its origin, or the reason why it is not known.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Figure {
    /// The figure.
    pub value: Option<f64>,
    /// Its origin, or why it is not known.
    pub origin: String,
}

impl Figure {
    fn known(value: f64, origin: impl Into<String>) -> Self {
        Self {
            // A difference of equal figures is no -0.
            value: Some(value + 0.0),
            origin: origin.into(),
        }
    }

    fn unknown(reason: impl Into<String>) -> Self {
        Self {
            value: None,
            origin: reason.into(),
        }
    }
}

/// What leaving out the hardware of effects saves.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct HardwareSaving {
    /// Fields of the configuration that become smaller.
    pub fields: Vec<&'static str>,
    /// Cells of the units in square millimetres at 12 nm, without wires and memories.
    pub area_mm2: Figure,
    /// Cycles of the units in the path's first frame.
    pub cycles: Figure,
    /// Energy of the units' cycles in the path's first frame, in microjoules.
    pub energy_uj: Figure,
}

/// Fields of the configuration that serve an effect alone; empty where a block does other work as well.
const fn fields_of(effect: Effect) -> &'static [&'static str] {
    match effect {
        Effect::Trilinear => &["gu.modes", "gu.vertices"],
        Effect::Segments => &["gu.segments"],
        Effect::Exponential => &["vu.ops", "vector_unit", "su"],
        _ => &[],
    }
}

/// Why no block of the accelerator is an effect's own.
const fn elsewhere(effect: Effect) -> &'static str {
    match effect {
        Effect::ViewMlp => "the MAC array, which other layers need as well",
        Effect::EarlyTermination => "a comparison, which is no block of its own",
        Effect::HashLevels | Effect::RandomDram => "the memory",
        Effect::RemoteLink => "the link",
        _ => "the GPU",
    }
}

/// Prices of a configuration and of smaller ones, for the work of a frame.
pub(super) struct Savings<'a> {
    scene: &'a Scene,
    whole: &'a Config,
    hardware: &'a Hardware,
    done: &'a Batch,
    array_units: u64,
    costs: Costs,
    area: Area,
}

impl<'a> Savings<'a> {
    /// `done` is the work of a frame on the units.
    pub(super) fn new(
        scene: &'a Scene,
        whole: &'a Config,
        hardware: &'a Hardware,
        done: &'a Batch,
    ) -> Result<Self, ExploreError> {
        let (costs, area) = costs_and_area(scene, whole)?;
        Ok(Self {
            scene,
            whole,
            hardware,
            done,
            array_units: System::default().array().units(),
            costs,
            area,
        })
    }

    /// What leaving out an effect that is not called for saves.
    pub(super) fn of(&self, effect: Effect) -> Result<HardwareSaving, ExploreError> {
        let own = fields_of(effect);
        if own.is_empty() {
            let reason = format!("done by {}", elsewhere(effect));
            return Ok(HardwareSaving {
                fields: vec![],
                area_mm2: Figure::unknown(reason.clone()),
                cycles: no_cycles(),
                energy_uj: Figure::unknown(reason),
            });
        }
        let is_own = |part: &&LeftOut| own.contains(&part.field);
        self.without(self.hardware.left_out.iter().filter(is_own).collect())
    }

    /// What leaving out all that is not called for saves.
    pub(super) fn of_all(&self) -> Result<HardwareSaving, ExploreError> {
        self.without(self.hardware.left_out.iter().collect())
    }

    fn without(&self, parts: Vec<&LeftOut>) -> Result<HardwareSaving, ExploreError> {
        let gone: Vec<&LeftOut> = parts
            .iter()
            .copied()
            .filter(|p| p.asked != p.left)
            .collect();
        let fields = gone.iter().map(|part| part.field).collect();
        if gone.is_empty() {
            let reason = match parts.first() {
                Some(stays) => format!("{} stays: {}", stays.field, stays.reason),
                None => "the configuration has no part for it alone".to_owned(),
            };
            return Ok(HardwareSaving {
                fields,
                area_mm2: Figure::known(0.0, reason.clone()),
                cycles: no_cycles(),
                energy_uj: Figure::known(0.0, reason),
            });
        }
        let config = self.reduced(&gone);
        let (area_mm2, energy_uj) = match rules::check(&config).is_empty() {
            false => {
                let reason = "no rule allows a configuration without this part alone";
                (Figure::unknown(reason), Figure::unknown(reason))
            }
            true => {
                let (costs, area) = costs_and_area(self.scene, &config)?;
                let unused = |unit| gone.iter().any(|part| part.field == unit);
                let is_gone = |block: &str| {
                    unused("vector_unit") && block == "vector_unit"
                        || unused("gathering_unit") && block == "gathering_unit"
                };
                let area = match self.area(&area, is_gone) {
                    Figure {
                        value: None,
                        origin,
                    } => self.reducers(&gone, origin),
                    known => known,
                };
                (area, self.energy(&costs))
            }
        };
        Ok(HardwareSaving {
            fields,
            area_mm2,
            cycles: no_cycles(),
            energy_uj,
        })
    }

    /// The configuration with the fields of some parts as the scene needs them.
    fn reduced(&self, gone: &[&LeftOut]) -> Config {
        let (mut own, left) = (self.whole.clone(), &self.hardware.config);
        for part in gone {
            match part.field {
                "gu.modes" => own.gu.modes = left.gu.modes,
                "gu.vertices" => own.gu.vertices.clone_from(&left.gu.vertices),
                "gu.segments" => own.gu.segments = left.gu.segments,
                "gu.records_a_row" => own.gu.records_a_row = left.gu.records_a_row,
                "vu.ops" => own.vu.ops.clone_from(&left.vu.ops),
                "su" => own.su.clone_from(&left.su),
                // A unit that is left out as a whole changes no field.
                _ => {}
            }
        }
        own.gu.organisation = left.gu.organisation;
        own
    }

    /// Cells of the blocks of the whole configuration less those of a smaller one.
    fn area(&self, small: &Area, is_gone: impl Fn(&str) -> bool) -> Figure {
        let (mut saved, mut from) = (0.0, vec![]);
        for block in &self.area.blocks {
            let other = small.blocks.iter().find(|own| own.block == block.block);
            let left = match other {
                _ if is_gone(&block.block) => Some(0.0),
                None => Some(0.0),
                Some(own) => own.logic_mm2,
            };
            match (block.logic_mm2, left) {
                (Some(all), Some(left)) if all != left => {
                    saved += all - left;
                    let of = other.filter(|_| !is_gone(&block.block));
                    let less = of.map_or_else(String::new, |own| format!(" less {}", own.from));
                    from.push(format!("{}: {}{less}", block.block, block.from));
                }
                (Some(_), Some(_)) => {}
                (None, _) => return Figure::unknown(format!("{}: {}", block.block, block.from)),
                (_, None) => {
                    let reason = other.map_or("", |own| &own.from);
                    return Figure::unknown(format!("{} without it: {reason}", block.block));
                }
            }
        }
        match from.is_empty() {
            true => Figure::known(0.0, "the cells are the same"),
            false => Figure::known(saved, from.join("; ")),
        }
    }

    /// Cells of the reducers alone, which a unit of single ids does not have, where more is not known.
    fn reducers(&self, gone: &[&LeftOut], otherwise: String) -> Figure {
        let single = self.hardware.config.gu.modes == Modes::Unstructured;
        let are_gone = single && gone.iter().any(|part| part.field == "gu.modes");
        let own = are_gone.then(|| module_area(self.whole, UnitKind::Gathering, "reducer"));
        match own.flatten() {
            Some((mm2, count)) => Figure::known(
                mm2,
                format!(
                    "the {count} reducers of the synthesised gathering unit alone, scaled to 12 nm"
                ),
            ),
            None => Figure::unknown(otherwise),
        }
    }

    /// Energy of a frame's work on the whole configuration less that on a smaller one.
    fn energy(&self, small: &Costs) -> Figure {
        let of = |costs: &Costs| {
            let own = costs.of(self.done, true, self.array_units);
            let logic = [own.gathering_pj, own.vector_pj, own.splat_pj];
            let logic = logic.into_iter().sum::<Option<f64>>()?;
            Some((logic + own.gathering_memories_pj?) * 1e-6)
        };
        match (of(&self.costs), of(small)) {
            (Some(all), Some(left)) => Figure::known(
                all - left,
                "synthesised energies or formulas, times the frame's cycles of both units",
            ),
            _ => Figure::unknown(
                "no synthesis and no formula covers the units; potamoi synth --json measures them",
            ),
        }
    }
}

/// No unit spends a cycle on what is not called for: `--force` shows that it stays so.
fn no_cycles() -> Figure {
    Figure::known(0.0, "cycle models: no work arises, forced or not")
}
