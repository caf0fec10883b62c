//! Models of the configured organisation.

use potamoi_formats::config::Config;

use crate::gather_work::GatherWork;
use crate::work::MftPiece;
use crate::{
    FeatureMajorModel, GatherCycles, GatherInputs, GatherModel, GatherOutputs, WorkError,
    feature_major_cycles, gather_cycles, split_cycles,
};

/// The stepwise model of a unit.
pub enum UnitModel {
    /// Channel-major: ports that never wait for one another, or that take turns.
    ChannelMajor(GatherModel),
    /// Feature-major: lanes with bank conflicts.
    FeatureMajor(FeatureMajorModel),
}

impl UnitModel {
    /// The model after reset.
    ///
    /// # Errors
    /// Work that the unit cannot do.
    pub fn new(config: &Config, work: &GatherWork<'_>) -> Result<Self, WorkError> {
        let run = work.run();
        if let Some(lanes) = work.lane_run() {
            return Ok(Self::FeatureMajor(FeatureMajorModel::new(config, &lanes)?));
        }
        Ok(Self::ChannelMajor(match work.split_run() {
            None => GatherModel::new(config, run.vertices, run.segments)?,
            Some(split) => GatherModel::of_turns(config, &split)?,
        }))
    }

    /// Whether the unit is empty, so that the settings may change: `idle` in the next cycle.
    #[must_use]
    pub fn is_idle(&self) -> bool {
        match self {
            Self::ChannelMajor(model) => model.is_idle(),
            Self::FeatureMajor(model) => model.is_idle(),
        }
    }

    /// One clock cycle.
    pub fn step(&mut self, inputs: &GatherInputs) -> GatherOutputs {
        match self {
            Self::ChannelMajor(model) => model.step(inputs),
            Self::FeatureMajor(model) => model.step(inputs),
        }
    }
}

impl<'a> GatherWork<'a> {
    /// Beats of the MFT stream, in order.
    pub fn mft_pieces(&'a self, config: &Config) -> Box<dyn Iterator<Item = MftPiece> + 'a> {
        match self.lane_run() {
            None => Box::new(self.run().mft_beats()),
            Some(lanes) => Box::new(lanes.mft_pieces(config)),
        }
    }

    /// Closed-form cycles with streams always ready.
    ///
    /// # Errors
    /// Work that the unit cannot do.
    pub fn predicted(&self, config: &Config) -> Result<GatherCycles, WorkError> {
        match (self.lane_run(), self.split_run()) {
            (Some(lanes), _) => feature_major_cycles(config, &lanes),
            (None, Some(split)) => split_cycles(config, &split),
            (None, None) => gather_cycles(config, &self.run()),
        }
    }
}
