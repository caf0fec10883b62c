//! Energy of units and on-chip memories, from synthesised parameters.

use std::collections::BTreeMap;
use std::sync::Mutex;

use potamoi_formats::config::Config;
use potamoi_synth::fit::{Estimate, EstimatedModule, Fit, Work};
use potamoi_synth::{SynthError, SynthReport, Synthesised, UnitKind, scaling};
use serde::Serialize;
use thiserror::Error;

use super::kernels::Program;
use super::logic::{Logic, NODE_NM, UnitEnergy, power_of, reached_ghz};
use potamoi_cycles::frame_meter::Batch;

/// Register bits of a MAC unit beyond the reducer's own: two inputs of 16 bits (paper, ibid.).
const MAC_REGISTERS: f64 = 32.0;
/// Bytes of a word of the global feature buffer; weights in a word of the weight buffer.
pub(super) const FEATURE_WORD: f64 = 16.0;
pub(super) const WEIGHT_WORD: f64 = 48.0;
/// Bytes of a word of a bank of the RIT buffer.
const RIT_WORD: f64 = 2.0;

/// Why an energy is not known.
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
    /// Its power was not measured.
    #[error(
        "the parameters lack the power of {0}: synthesise them with an activity (potamoi synth \
         --activity SCENE)"
    )]
    Power(&'static str),
    /// The parameters given lack the power of a unit.
    #[error(
        "{source}\nthe parameters that were given lack the power of the gathering unit or the node of their \
         library: synthesise them with both (potamoi synth --node NM, and power not left out)"
    )]
    Given {
        /// Reason why they were needed.
        source: SynthError,
    },
    /// The parameters lack a memory.
    #[error("no memory {0} in the parameters: synthesise them with CACTI (tools/setup memories)")]
    Memory(&'static str),
}

/// Energy of a memory, in picojoules an access.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Port {
    /// Read.
    pub read_pj: f64,
    /// Write.
    pub write_pj: f64,
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

/// Energy of the units at 12 nm.
#[derive(Debug)]
pub struct Costs {
    fit: Fit,
    config: Config,
    gatherer: Gatherer,
    vector: UnitEnergy,
    /// Scaling factor of logic from the grid's node to 12 nm.
    logic: f64,
    /// A unit of the MAC array; its clock is gated between products.
    pub mac: MacEnergy,
    /// A bank of the MFT.
    pub mft: Port,
    /// A bank of the RIT buffer.
    pub rit: Port,
    /// The global feature buffer.
    pub features: Port,
    /// The weight buffer.
    pub weights: Port,
    /// Leakage of the units' memories and logic, in milliwatts.
    pub leakage_mw: f64,
    /// Highest clock in gigahertz of the slower unit at 12 nm, before wires. Access times of
    /// memories are included where known. `None` where the units were not synthesised.
    pub reached_ghz: Option<f64>,
    /// Cell area of both units at 12 nm, in square millimetres, without memories.
    pub area_mm2: f64,
    /// Source of the numbers.
    pub origin: String,
}

/// Energy of a frame on chip by part, in picojoules.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct OnChip {
    /// The gathering unit's logic.
    pub gathering_pj: f64,
    /// The gathering unit's memories.
    pub gathering_memories_pj: f64,
    /// The vector unit's logic.
    pub vector_pj: f64,
    /// The MAC array.
    pub array_pj: f64,
    /// The global feature buffer and the weight buffer.
    pub buffers_pj: f64,
}

impl std::ops::AddAssign for OnChip {
    fn add_assign(&mut self, other: Self) {
        self.gathering_pj += other.gathering_pj;
        self.gathering_memories_pj += other.gathering_memories_pj;
        self.vector_pj += other.vector_pj;
        self.array_pj += other.array_pj;
        self.buffers_pj += other.buffers_pj;
    }
}

impl Costs {
    /// Energies for the units of a configuration.
    ///
    /// The vector unit's energy and area are those of the first of `reports` with the same vector
    /// unit, else from formulas. The gathering unit's are those of `given`, whatever its netlist
    /// gathered. Without `given` they are from formulas where entries have vertices. For splat
    /// records they are those of `records`, scaled by the ratio that formulas give for the two
    /// units. Memories and the MAC array, with reducers of the paper's size, are those of
    /// `memories`.
    ///
    /// # Errors
    /// A unit without known energy; parameters that lack something.
    pub fn new(
        config: &Config,
        program: Program,
        fit: Fit,
        given: Option<&SynthReport>,
        reports: &[Synthesised],
        records: &SynthReport,
        memories: &SynthReport,
    ) -> Result<Self, CostError> {
        let node = fit.grid().library.node_nm;
        let factors = node.and_then(|nm| scaling::logic(nm, NODE_NM));
        let factors = factors.ok_or(CostError::Node {
            what: "the grid",
            node,
        })?;
        let logic = factors.energy;
        let paper = Config::paper();
        let most = Work {
            busy: 1.0,
            channels: paper.gu.banks.into(),
        };
        let array = fit.estimate(&paper, UnitKind::Gathering, most)?;
        let flop_pj = fit.flop_pj(fit.family(&paper, UnitKind::Gathering)?);
        let mac = mac_energy(&array, flop_pj, logic);
        let is_given = given.is_some();
        let given = given.and_then(|given| {
            let scene = &power_of(given, UnitKind::Gathering)?.activity.scene;
            Some((scene, Logic::measured(given, UnitKind::Gathering)?))
        });
        // Leakage at its own node, area at the system's.
        let (gathering_nw, gathering_um2, share) = match &given {
            Some((_, own)) => (own.leakage_nw, own.area_um2, 1.0),
            None => {
                let own = fit.estimate(config, UnitKind::Gathering, most);
                let own = own.map_err(|source| match is_given {
                    true => CostError::Given { source },
                    false => source.into(),
                })?;
                let share = own.with_glitches_pj / array.with_glitches_pj;
                (own.leakage_nw, own.scaled(&factors).area_um2, share)
            }
        };
        let gathering_from = match (&given, program) {
            (Some((scene, _)), _) => format!("netlists of this configuration, on {scene}"),
            (None, Program::Splats) => "netlists that gathered splat records".to_owned(),
            (None, Program::Fields) => "formulas fitted to syntheses".to_owned(),
        };
        let gatherer = match (given, program) {
            (Some((_, own)), _) => Gatherer::Measured(own.energy),
            (None, Program::Fields) => Gatherer::Fitted(Mutex::default()),
            (None, Program::Splats) => gatherer_of_records(records, logic, share)?,
        };
        let (vector, vector_from) = vector_unit(config, &fit, &factors, reports)?;
        let logic_mw = (gathering_nw + vector.leakage_nw) * 1e-6;
        let port = |unit, name| port(memories, unit, name);
        let unit = UnitKind::Gathering.top();
        let (mft, mft_mw) = port(unit, "mft_bank")?;
        let (rit, rit_mw) = port(unit, "rit_bank")?;
        let (features, features_mw) = port("system", "global_feature_buffer")?;
        let (weights, weights_mw) = port("system", "weight_buffer")?;
        let library = &fit.grid().library.name;
        Ok(Self {
            origin: format!(
                "gathering unit: {gathering_from}; vector unit: {vector_from}; all in {library}, with glitches, scaled to \
                 {NODE_NM} nm; memories: CACTI; the array: reducers of the paper's size with two \
                 registers of 16 bits"
            ),
            reached_ghz: {
                let own = reports.iter().find(|r| r.report.is_of(config));
                own.and_then(|own| reached_ghz(&own.report))
            },
            area_mm2: (gathering_um2 + vector.area_um2) * 1e-6,
            gatherer,
            vector: vector.energy,
            config: config.clone(),
            logic,
            mac,
            mft,
            rit,
            features,
            weights,
            leakage_mw: mft_mw + rit_mw + features_mw + weights_mw + logic_mw,
            fit,
        })
    }

    /// Energy of a batch beside an array of `units`; `uses_gathering_unit` tells whether the
    /// gathering unit did its gathers.
    ///
    /// # Errors
    /// A configuration outside the model.
    pub fn of(
        &self,
        done: &Batch,
        uses_gathering_unit: bool,
        array_units: u64,
    ) -> Result<OnChip, CostError> {
        let mut all = OnChip::default();
        if uses_gathering_unit && done.gather_cycles > 0 {
            all.gathering_pj = match &self.gatherer {
                Gatherer::Measured(unit) => unit.of(done.gather_cycles, done.gather_busy),
                Gatherer::Fitted(known) => {
                    let ports = u64::from(self.config.gu.ports) * done.gather_busy;
                    let banks = done.codes_read as f64 / ports.max(1) as f64;
                    let unit = self.fitted(known, (banks.round() as u64).max(1))?;
                    unit.of(done.gather_cycles, done.gather_busy)
                }
            };
            let rit_words = (done.rit_read_bytes as f64) / RIT_WORD;
            all.gathering_memories_pj = done.codes_read as f64 * self.mft.read_pj
                + done.row_bytes as f64 / 2.0 * self.mft.write_pj
                + rit_words * (self.rit.read_pj + self.rit.write_pj);
        }
        all.vector_pj = self.vector.of(done.vector_cycles, done.vector_busy);
        let clocked = (done.array_cycles * array_units) as f64;
        all.array_pj = self.mac.rest_pj * clocked + self.mac.work_pj * done.macs as f64;
        // Whoever gathers, features are written to the buffer that the array reads.
        let read = done.input_bytes + done.partial_bytes + done.operand_bytes;
        let written =
            done.feature_bytes + done.output_bytes + done.partial_bytes + done.result_bytes;
        all.buffers_pj += read as f64 / FEATURE_WORD * self.features.read_pj
            + written as f64 / FEATURE_WORD * self.features.write_pj
            + done.weight_bytes as f64 / WEIGHT_WORD * self.weights.read_pj;
        Ok(all)
    }

    /// Picojoules of writing weights into their buffer.
    #[must_use]
    pub(crate) fn loaded_weights(&self, bytes: f64) -> f64 {
        bytes / WEIGHT_WORD * self.weights.write_pj
    }

    /// Fitted energy of the gathering unit with so many banks at work.
    fn fitted(
        &self,
        known: &Mutex<BTreeMap<u64, UnitEnergy>>,
        channels: u64,
    ) -> Result<UnitEnergy, CostError> {
        // A lock is held by nobody who fails.
        let mut known = known
            .lock()
            .unwrap_or_else(std::sync::PoisonError::into_inner);
        if let Some(unit) = known.get(&channels) {
            return Ok(*unit);
        }
        let at = |busy| {
            let work = Work { busy, channels };
            self.fit.estimate(&self.config, UnitKind::Gathering, work)
        };
        let (rest, work) = (at(0.0)?.with_glitches_pj, at(1.0)?.with_glitches_pj);
        let unit = UnitEnergy {
            rest_pj: rest * self.logic,
            work_pj: (work - rest) * self.logic,
        };
        known.insert(channels, unit);
        Ok(unit)
    }
}

/// Energy of a MAC unit of the array: a reducer of the paper's unit, with registers.
fn mac_energy(array: &Estimate, flop_pj: f64, logic: f64) -> MacEnergy {
    let reducer = array.modules.iter().find(|m| m.module == "reducer");
    let reducer =
        |of: fn(&EstimatedModule) -> f64| reducer.map_or(0.0, |m| of(m) / m.count.max(1) as f64);
    MacEnergy {
        rest_pj: (reducer(|m| m.clock_pj) + MAC_REGISTERS * flop_pj) * logic,
        work_pj: reducer(|m| m.with_glitches_pj - m.clock_pj) * logic,
        leakage_mw: reducer(|m| m.leakage_nw) * 1e-6,
    }
}

/// Measured energy of the gathering unit on splat records, scaled by a share.
fn gatherer_of_records(
    records: &SynthReport,
    logic: f64,
    share: f64,
) -> Result<Gatherer, CostError> {
    let measured = UnitEnergy::measured(records, UnitKind::Gathering, logic);
    let measured = measured.ok_or(CostError::Power("splat records"))?;
    Ok(Gatherer::Measured(UnitEnergy {
        rest_pj: measured.rest_pj * share,
        work_pj: measured.work_pj * share,
    }))
}

/// The vector unit's energy, and its source.
fn vector_unit(
    config: &Config,
    fit: &Fit,
    factors: &scaling::Factors,
    reports: &[Synthesised],
) -> Result<(Logic, &'static str), CostError> {
    let own = reports.iter().find(|r| r.has(config, UnitKind::Vector));
    let own = own.and_then(|own| Logic::measured(&own.report, UnitKind::Vector));
    Ok(match own {
        Some(own) => (own, "netlists of this configuration"),
        None => match Logic::estimated(fit, config, factors) {
            Ok(own) => (own, "formulas fitted to syntheses"),
            Err(unknown) => (
                Logic::in_proportion(fit, config, reports).ok_or(unknown)?,
                "netlists of a unit with another exponential, in the proportion of formulas",
            ),
        },
    })
}

/// Access energy of a memory of a unit or of the system, and the leakage of all such memories in
/// milliwatts.
fn port(memories: &SynthReport, unit: &str, name: &'static str) -> Result<(Port, f64), CostError> {
    let (raw, scaled) = memories.memory(unit, name).ok_or(CostError::Memory(name))?;
    let figures = scaled.map_or(raw.figures, |s| s.figures);
    let port = Port {
        read_pj: figures.read_pj,
        write_pj: figures.write_pj,
    };
    Ok((port, figures.leakage_mw * raw.count as f64))
}
