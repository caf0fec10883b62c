//! Energy, area and clock of units and on-chip memories, from synthesised parameters.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex};

use potamoi_formats::config::{Config, Modes};
use potamoi_synth::fit::{Fit, Work};
use potamoi_synth::{SynthError, SynthReport, Synthesised, UnitKind, scaling};
use schemars::JsonSchema;
use serde::Serialize;
use thiserror::Error;

use super::block_periods::Periods;
use super::clock::Clock;
use super::kernels::Program;
use super::logic::{FORMULAS, Logic, NODE_NM, UnitEnergy, power_of};
use super::memory_costs::MemoryCosts;
use super::on_chip_sizes::OnChipSizes;
use super::splat_costs::SplatUnitCosts;
use super::unit_source::Known;
use potamoi_cycles::batch::Batch;

/// Why no parameters can be used at all.
#[derive(Debug, Error)]
pub enum CostError {
    /// The parameters cannot be read.
    #[error(transparent)]
    Synth(#[from] SynthError),
    /// No scaling factors are known for their node.
    #[error("{what} is at {node:?} nm: expected a node with factors to {NODE_NM} nm")]
    Node {
        /// Name of the parameters.
        what: &'static str,
        /// Their node in nanometres, if known.
        node: Option<u32>,
    },
}

/// A block whose energy and area are not known.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct Unknown {
    /// The block.
    pub block: String,
    /// The reason, with what to do.
    pub why: String,
}

/// A unit of the MAC array.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct MacEnergy {
    /// Picojoules of an idle cycle of its clock, without multiplication.
    pub rest_pj: f64,
    /// Picojoules that a multiplication and addition take beyond an idle cycle.
    pub work_pj: f64,
    /// Leakage in milliwatts, without registers.
    pub leakage_mw: f64,
}

/// Source of the gathering unit's energy.
#[derive(Debug)]
enum Gatherer {
    /// Measured on netlists that gathered.
    Measured(UnitEnergy),
    /// Fitted formulas, by banks at work (entries of eight vertices).
    Fitted(Mutex<BTreeMap<u64, UnitEnergy>>),
}

/// Energy of the units at 12 nm. What is not known is `None`, and named in [`Costs::unknown`].
#[derive(Debug, Clone)]
pub struct Costs {
    fit: Arc<Fit>,
    config: Config,
    gatherer: Option<Arc<Gatherer>>,
    vector: Option<UnitEnergy>,
    /// A splat unit, of a configuration with one.
    splat: Option<SplatUnitCosts>,
    /// Scaling factor of logic from the grid's node to 12 nm.
    logic: f64,
    /// A unit of the MAC array; its clock is gated between products.
    pub mac: Option<MacEnergy>,
    /// Memories of the gathering unit and the buffers.
    pub(super) memories: MemoryCosts,
    /// Leakage of the units' memories and logic, in milliwatts, splat units with theirs.
    pub leakage_mw: Option<f64>,
    /// Clock of the accelerator.
    pub clock: Clock,
    /// Cell area of gathering unit, vector unit and splat units at 12 nm, in square millimetres, without
    /// memories.
    pub area_mm2: Option<f64>,
    /// Source of the numbers.
    pub origin: String,
    /// Blocks whose energy and area are not known.
    pub unknown: Vec<Unknown>,
}

/// Parameters that energies, areas and periods come from.
pub struct Parameters<'a> {
    /// The first of `reports`, where the user gave it: its gathering unit counts before formulas.
    pub given: Option<&'a SynthReport>,
    /// Synthesised units, of any configuration; the first that has a unit counts.
    pub reports: &'a [Synthesised],
    /// Units whose own synthesis does not count, so that two configurations of a unit are compared by
    /// one method.
    pub estimated: &'a [UnitKind],
    /// The paper's gathering unit, run with splat records.
    pub records: &'a SynthReport,
    /// The memories around the units, and the unit of the array.
    pub system: &'a SynthReport,
    /// Sizes of the array and of the buffers around the units.
    pub sizes: OnChipSizes,
    /// Share that is added to periods of logic for wires.
    pub wire_margin: f64,
}

/// Energy of a frame on chip by part, in picojoules; `None` where it is not known.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct OnChip {
    /// The gathering unit's logic.
    pub gathering_pj: Option<f64>,
    /// The gathering unit's memories.
    pub gathering_memories_pj: Option<f64>,
    /// The vector unit's logic.
    pub vector_pj: Option<f64>,
    /// The splat units with their memories.
    pub splat_pj: Option<f64>,
    /// The MAC array.
    pub array_pj: Option<f64>,
    /// The global feature buffer and the weight buffer.
    pub buffers_pj: Option<f64>,
}

impl Default for OnChip {
    fn default() -> Self {
        Self {
            gathering_pj: Some(0.0),
            gathering_memories_pj: Some(0.0),
            vector_pj: Some(0.0),
            splat_pj: Some(0.0),
            array_pj: Some(0.0),
            buffers_pj: Some(0.0),
        }
    }
}

/// The sum of two figures where both are known.
pub(super) fn sum(a: Option<f64>, b: Option<f64>) -> Option<f64> {
    Some(a? + b?)
}

impl std::ops::AddAssign for OnChip {
    fn add_assign(&mut self, other: Self) {
        self.gathering_pj = sum(self.gathering_pj, other.gathering_pj);
        self.gathering_memories_pj = sum(self.gathering_memories_pj, other.gathering_memories_pj);
        self.vector_pj = sum(self.vector_pj, other.vector_pj);
        self.splat_pj = sum(self.splat_pj, other.splat_pj);
        self.array_pj = sum(self.array_pj, other.array_pj);
        self.buffers_pj = sum(self.buffers_pj, other.buffers_pj);
    }
}

impl Costs {
    /// Energies for the units of a configuration.
    ///
    /// The vector unit's energy and area are those of the first of the reports with the same vector
    /// unit, else from formulas, else composed of a synthesised unit and formulas. The gathering
    /// unit's are those of the report given, whatever its netlist gathered; else from formulas where
    /// entries have vertices, else of its own synthesis, else composed. For splat records they are
    /// those of `records`, scaled by the ratio of the two units. What no source has is unknown.
    ///
    /// # Errors
    /// Parameters at a node without factors.
    pub fn new(
        config: &Config,
        program: Program,
        fit: impl Into<Arc<Fit>>,
        parameters: &Parameters<'_>,
    ) -> Result<Self, CostError> {
        let fit = fit.into();
        let node = fit.grid().library.node_nm;
        let factors = node.and_then(|nm| scaling::logic(nm, NODE_NM));
        let factors = factors.ok_or(CostError::Node {
            what: "the grid",
            node,
        })?;
        let known = Known {
            fit: &fit,
            reports: parameters.reports,
            estimated: parameters.estimated,
        };
        let mut unknown = vec![];
        let mut note = |block: &str, why: String| {
            let block = block.to_owned();
            unknown.push(Unknown { block, why });
        };
        let mac = mac_energy(parameters.system, &parameters.sizes)
            .map_err(|why| note("MAC array", why.to_owned()))
            .ok();
        let gathering = Gathered::new(config, program, &known, parameters, &factors);
        let gathering = gathering.map_err(|why| note("gathering unit", why)).ok();
        let vector = Logic::of(&known, config, UnitKind::Vector, &factors);
        let vector = vector.map_err(|why| note("vector unit", why)).ok();
        let splat = (config.su.as_ref()).map(|su| SplatUnitCosts::new(config, su, &known));
        let splat = splat.and_then(|own| own.map_err(|why| note("splat unit", why)).ok());
        let from = |name: Option<&str>| name.unwrap_or("not known").to_owned();
        // Splat units are known as synthesised alone.
        let splat_from = splat.as_ref().map(|_| "netlists of this configuration");
        let origin = format!(
            "gathering unit: {}; vector unit: {}{}; all in {}, with glitches, scaled to {NODE_NM} nm; \
             memories: CACTI; the array: a synthesised unit of it",
            from(gathering.as_ref().map(|own| &*own.from)),
            from(vector.as_ref().map(|(_, from)| *from)),
            match &config.su {
                Some(_) => format!("; splat unit: {}", from(splat_from)),
                None => String::new(),
            },
            fit.grid().library.name,
        );
        let memories = MemoryCosts::new(
            config,
            &known,
            (parameters.system, &parameters.sizes),
            &mut note,
        );
        let both = gathering.as_ref().zip(vector.as_ref());
        let both = both.and_then(|(gathering, (vector, _))| {
            let splat = match (&splat, &config.su) {
                (Some(own), _) => own.clone(),
                (None, None) => SplatUnitCosts::NONE,
                (None, Some(_)) => return None,
            };
            // Leakage at its own node, area at the system's.
            let leakage_mw = (gathering.leakage_nw + vector.leakage_nw) * 1e-6;
            let area_mm2 = (gathering.area_um2 + vector.area_um2) * 1e-6;
            Some((leakage_mw + splat.leakage_mw, area_mm2 + splat.area_mm2))
        });
        let clock = Clock::of(
            config,
            &Periods {
                known: &known,
                system: parameters.system,
                wire_margin: parameters.wire_margin,
            },
        );
        Ok(Self {
            origin,
            clock,
            area_mm2: both.map(|(_, area)| area),
            gatherer: gathering.map(|own| Arc::new(own.gatherer)),
            vector: vector.map(|(own, _)| own.energy),
            splat,
            config: config.clone(),
            logic: factors.energy,
            mac,
            leakage_mw: both
                .zip(memories.leakage_mw)
                .map(|((logic, _), own)| own + logic),
            memories,
            unknown,
            fit,
        })
    }

    /// The same hardware at the clock of `config`, which differs from this configuration in its clock
    /// alone. Nothing but the clock depends on it.
    #[must_use]
    pub fn at_clock_of(&self, config: &Config) -> Self {
        let own = self.clone();
        Self {
            clock: own.clock.assumed(config.clock_ghz()),
            config: config.clone(),
            ..own
        }
    }

    /// Whether the configuration has splat units.
    #[must_use]
    pub const fn has_splat_units(&self) -> bool {
        self.config.su.is_some()
    }

    /// Energy of a batch beside an array of `units`; `uses_gathering_unit` tells whether the
    /// gathering unit did its gathers.
    #[must_use]
    pub fn of(&self, done: &Batch, uses_gathering_unit: bool, array_units: u64) -> OnChip {
        let mut all = OnChip::default();
        if uses_gathering_unit && done.gather_cycles > 0 {
            all.gathering_pj = self.gathering_pj(done);
            all.gathering_memories_pj = self.memories.gathering_pj(done);
        }
        if done.vector_cycles > 0 {
            let vector = self.vector.as_ref();
            all.vector_pj = vector.map(|unit| unit.of(done.vector_cycles, done.vector_busy));
        }
        if done.splat_jobs > 0 {
            all.splat_pj = self.splat.as_ref().map(|unit| unit.pj(done));
        }
        if done.array_cycles > 0 {
            let clocked = (done.array_cycles * array_units) as f64;
            let mac = self.mac.as_ref();
            all.array_pj = mac.map(|mac| mac.rest_pj * clocked + mac.work_pj * done.macs as f64);
        }
        all.buffers_pj = self.memories.buffers_pj(done);
        all
    }

    fn gathering_pj(&self, done: &Batch) -> Option<f64> {
        let unit = match self.gatherer.as_deref()? {
            Gatherer::Measured(unit) => *unit,
            Gatherer::Fitted(known) => {
                let ports = u64::from(self.config.gu.ports) * done.gather_busy;
                let banks = done.codes_read as f64 / ports.max(1) as f64;
                self.fitted(known, (banks.round() as u64).max(1))?
            }
        };
        Some(unit.of(done.gather_cycles, done.gather_busy))
    }

    /// Fitted energy of the gathering unit with so many banks at work.
    fn fitted(
        &self,
        known: &Mutex<BTreeMap<u64, UnitEnergy>>,
        channels: u64,
    ) -> Option<UnitEnergy> {
        // A lock is held by nobody who fails.
        let mut known = known
            .lock()
            .unwrap_or_else(std::sync::PoisonError::into_inner);
        if let Some(unit) = known.get(&channels) {
            return Some(*unit);
        }
        let at = |busy| {
            let work = Work { busy, channels };
            let own = self.fit.estimate(&self.config, UnitKind::Gathering, work);
            Some(own.ok()?.with_glitches_pj)
        };
        let (rest, work) = (at(0.0)?, at(1.0)?);
        let unit = UnitEnergy {
            rest_pj: rest * self.logic,
            work_pj: (work - rest) * self.logic,
        };
        known.insert(channels, unit);
        Some(unit)
    }
}

/// Energy of a unit of the array, as synthesised and scaled.
fn mac_energy(system: &SynthReport, sizes: &OnChipSizes) -> Result<MacEnergy, &'static str> {
    if let Some(why) = sizes.unbuilt_array() {
        return Err(why);
    }
    let own = Logic::measured(system, UnitKind::ArrayMac)
        .ok_or("the parameters lack its unit: potamoi synth --unit mac")?;
    Ok(MacEnergy {
        rest_pj: own.energy.rest_pj,
        work_pj: own.energy.work_pj,
        leakage_mw: own.leakage_nw * 1e-6,
    })
}

/// Logic of the gathering unit in its use.
struct Gathered {
    gatherer: Gatherer,
    leakage_nw: f64,
    area_um2: f64,
    from: String,
}

impl Gathered {
    fn new(
        config: &Config,
        program: Program,
        known: &Known<'_>,
        parameters: &Parameters<'_>,
        factors: &scaling::Factors,
    ) -> Result<Self, String> {
        let unit = UnitKind::Gathering;
        if let Some(given) = parameters.given {
            let own = power_of(given, unit).zip(Logic::measured(given, unit));
            if let Some((power, own)) = own {
                let scene = &power.activity.scene;
                let from = format!("netlists of this configuration, on {scene}");
                return Ok(Self::of(own, Gatherer::Measured(own.energy), from));
            }
        }
        let (own, from) = Logic::of(known, config, unit, factors)?;
        let fitted = Logic::estimated(known.fit, config, unit, factors).ok();
        match program {
            // Formulas know the banks at work.
            Program::Fields => Ok(match fitted {
                Some(own) => Self::of(own, Gatherer::Fitted(Mutex::default()), FORMULAS.to_owned()),
                None => Self::of(own, Gatherer::Measured(own.energy), from.to_owned()),
            }),
            // A unit of single ids that was synthesised gathered records.
            Program::Splats if config.gu.modes == Modes::Unstructured && fitted.is_none() => Ok(
                Self::of(own, Gatherer::Measured(own.energy), from.to_owned()),
            ),
            Program::Splats => {
                let gatherer = of_records(known, parameters, fitted.unwrap_or(own), factors)?;
                let from = format!("netlists that gathered splat records; {from}");
                Ok(Self::of(fitted.unwrap_or(own), gatherer, from))
            }
        }
    }

    const fn of(own: Logic, gatherer: Gatherer, from: String) -> Self {
        Self {
            gatherer,
            leakage_nw: own.leakage_nw,
            area_um2: own.area_um2,
            from,
        }
    }
}

/// Energy of a gathering unit on splat records: that of the paper's unit, as measured, in the
/// proportion of both units on entries of eight vertices.
fn of_records(
    known: &Known<'_>,
    parameters: &Parameters<'_>,
    own: Logic,
    factors: &scaling::Factors,
) -> Result<Gatherer, String> {
    let unit = UnitKind::Gathering;
    let measured = UnitEnergy::measured(parameters.records, unit, factors.energy);
    let measured = measured.ok_or("the parameters lack the power of splat records")?;
    let paper = Logic::estimated(known.fit, &Config::paper(), unit, factors);
    let paper = paper.map_err(|why| why.to_string())?;
    let all = |of: &Logic| of.energy.rest_pj + of.energy.work_pj;
    let share = all(&own) / all(&paper);
    Ok(Gatherer::Measured(UnitEnergy {
        rest_pj: measured.rest_pj * share,
        work_pj: measured.work_pj * share,
    }))
}
