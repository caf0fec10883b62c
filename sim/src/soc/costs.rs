//! Energy of what units and memories on chip do, from synthesised parameters.

use potamoi_formats::config::Config;
use serde::Serialize;
use thiserror::Error;

use super::work::Batch;
use crate::synth::fit::{Fit, Work};
use crate::synth::{SynthError, SynthReport, UnitKind, scaling};

/// The node of the system (paper, Sec. "Experimental Setup").
const NODE_NM: u32 = 12;
/// Registers of a MAC unit beyond the reducer's own: two inputs of 16 bits (paper, ibid.).
const MAC_REGISTERS: f64 = 32.0;
/// Bytes of a word of the global feature buffer, and weights of one of the weight buffer.
const FEATURE_WORD: f64 = 16.0;
const WEIGHT_WORD: f64 = 48.0;
/// Bytes of a word of a bank of the RIT buffer.
const RIT_WORD: f64 = 2.0;

/// Energy that is not known.
#[derive(Debug, Error)]
pub enum CostError {
    /// Parameters cannot be read.
    #[error(transparent)]
    Synth(#[from] SynthError),
    /// Nobody knows how to scale them.
    #[error("{what} is at {node:?} nm: expected a node with factors to {NODE_NM} nm")]
    Node {
        /// Which parameters.
        what: &'static str,
        /// Their node.
        node: Option<u32>,
    },
    /// A memory is not among the parameters.
    #[error("no memory {0} in the parameters: synthesise them with CACTI (tools/setup memories)")]
    Memory(&'static str),
}

/// A memory, picojoules an access.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Port {
    /// Of a read.
    pub read_pj: f64,
    /// Of a write.
    pub write_pj: f64,
}

/// Energy by unit, at 12 nm.
#[derive(Debug)]
pub struct Costs {
    fit: Fit,
    config: Config,
    /// From the grid's node to 12 nm.
    logic: f64,
    /// A multiplication and addition in the array.
    pub mac_pj: f64,
    /// A bank of the MFT.
    pub mft: Port,
    /// A bank of the RIT buffer.
    pub rit: Port,
    /// The global feature buffer.
    pub features: Port,
    /// The weight buffer.
    pub weights: Port,
    /// Memories and logic of the units at rest, in milliwatts.
    pub leakage_mw: f64,
    /// Where the numbers are from.
    pub origin: String,
}

/// Picojoules of a frame by what they were spent on.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct OnChip {
    /// The gathering unit's logic.
    pub gathering_pj: f64,
    /// Its memories.
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
    /// Of the units of a configuration by the fitted model, and of memories by `synth/*.json`.
    ///
    /// # Errors
    /// A configuration that the model is not of; parameters that lack something.
    pub fn new(config: &Config, fit: Fit, memories: &SynthReport) -> Result<Self, CostError> {
        let node = fit.grid().library.node_nm;
        let factors = node.and_then(|nm| scaling::logic(nm, NODE_NM));
        let logic = factors
            .ok_or(CostError::Node {
                what: "the grid",
                node,
            })?
            .energy;
        let most = Work {
            busy: 1.0,
            channels: config.gu.banks.into(),
        };
        let gathering = fit.estimate(config, UnitKind::Gathering, most)?;
        let vector = fit.estimate(config, UnitKind::Vector, most)?;
        let logic_mw = (gathering.leakage_nw + vector.leakage_nw) * 1e-6;
        let flop_pj = fit.flop_pj(fit.family(config, UnitKind::Gathering)?);
        let reducer = gathering.modules.iter().find(|m| m.module == "reducer");
        let reducer = reducer.map_or(0.0, |m| m.with_glitches_pj / m.count.max(1) as f64);
        let port = |unit: &str, name: &'static str| -> Result<(Port, f64), CostError> {
            let (raw, scaled) = memories.memory(unit, name).ok_or(CostError::Memory(name))?;
            let figures = scaled.map_or(raw.figures, |s| s.figures);
            let port = Port {
                read_pj: figures.read_pj,
                write_pj: figures.write_pj,
            };
            Ok((port, figures.leakage_mw * raw.count as f64))
        };
        let unit = UnitKind::Gathering.top();
        let (mft, mft_mw) = port(unit, "mft_bank")?;
        let (rit, rit_mw) = port(unit, "rit_bank")?;
        let (features, features_mw) = port("system", "global_feature_buffer")?;
        let (weights, weights_mw) = port("system", "weight_buffer")?;
        let library = &fit.grid().library.name;
        Ok(Self {
            origin: format!(
                "units: formulas fitted to syntheses in {library}, with glitches, scaled to {NODE_NM} nm; \
                 memories: CACTI; the array: reducers of that size with two registers of 16 bits"
            ),
            config: config.clone(),
            logic,
            mac_pj: (reducer + MAC_REGISTERS * flop_pj) * logic,
            mft,
            rit,
            features,
            weights,
            leakage_mw: mft_mw + rit_mw + features_mw + weights_mw + logic_mw,
            fit,
        })
    }

    /// Energy of what was done; `uses_gathering_unit` says whether the gathers were its.
    ///
    /// # Errors
    /// A configuration that the model is not of.
    pub fn of(&self, done: &Batch, uses_gathering_unit: bool) -> Result<OnChip, CostError> {
        let mut all = OnChip::default();
        if uses_gathering_unit && done.gather_cycles > 0 {
            let channels = done.codes_read as f64 / done.gather_busy.max(1) as f64;
            let work = Work {
                busy: done.gather_busy as f64 / done.gather_cycles as f64,
                channels: ((channels / f64::from(self.config.gu.ports)).round() as u64).max(1),
            };
            let own = self.fit.estimate(&self.config, UnitKind::Gathering, work)?;
            all.gathering_pj = own.with_glitches_pj * done.gather_cycles as f64 * self.logic;
            let rit_words = (done.rit_read_bytes as f64) / RIT_WORD;
            all.gathering_memories_pj = done.codes_read as f64 * self.mft.read_pj
                + done.row_bytes as f64 / 2.0 * self.mft.write_pj
                + rit_words * (self.rit.read_pj + self.rit.write_pj);
            all.buffers_pj += done.feature_bytes as f64 / FEATURE_WORD * self.features.write_pj;
        }
        if done.vector_cycles > 0 {
            let work = Work {
                busy: done.vector_busy as f64 / done.vector_cycles as f64,
                channels: 0,
            };
            let own = self.fit.estimate(&self.config, UnitKind::Vector, work)?;
            all.vector_pj = own.with_glitches_pj * done.vector_cycles as f64 * self.logic;
        }
        all.array_pj = done.macs as f64 * self.mac_pj;
        all.buffers_pj += done.input_bytes as f64 / FEATURE_WORD * self.features.read_pj
            + done.output_bytes as f64 / FEATURE_WORD * self.features.write_pj
            + done.weight_bytes as f64 / WEIGHT_WORD * self.weights.read_pj;
        Ok(all)
    }
}
