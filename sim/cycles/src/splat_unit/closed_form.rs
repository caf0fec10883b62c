//! Cycles of jobs by formula, with streams that never pause.

use potamoi_formats::config::{Config, SplatOpacity};
use potamoi_formats::units::OpCode;

use super::{front, lanes, tiles, walk};
use crate::vector_unit::VectorTiming;
use crate::work::WorkError;

/// What jobs of a splat unit do.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct SplatSums {
    /// Jobs.
    pub jobs: u64,
    /// Records.
    pub records: u64,
    /// Pairs of pixel and record whose power is computed.
    pub square_sums: u64,
    /// Pairs whose exponential is computed.
    pub exponentials: u64,
    /// Pixels that are given.
    pub pixels: u64,
}

impl SplatSums {
    /// Cycles of one unit: the time of the slowest of its parts, and what no other pair hides, which are
    /// the stages of a job's first pair and the pixels. The parts are a record in six clocks, a pixel of a row a clock, and vectors of
    /// exponentials at the pace of the lanes. It is a lower bound, since a part may wait for another and
    /// the slowest one may change; a job of one pair takes exactly as long on a single lane. 0 without a splat unit.
    ///
    /// # Errors
    /// A configuration that breaks its rules.
    pub fn cycles(self, config: &Config) -> Result<u64, WorkError> {
        let Some(su) = &config.su else { return Ok(0) };
        let timing = VectorTiming::new(&config.splat_lanes(su))?;
        let exp = OpCode::Exp.code();
        let vectors = self.exponentials.div_ceil(su.lanes.into());
        let after_first = |all: u64, pace: u64| all.saturating_sub(self.jobs) * pace;
        let slowest = after_first(self.records, front::PHASES.into())
            .max(after_first(self.square_sums, 1))
            .max(after_first(vectors, timing.occupancy(exp, 0)));
        let multiplied = match su.opacity {
            SplatOpacity::Multiplied => tiles::MULTIPLIES,
            SplatOpacity::InPower => 0,
        };
        let stages = front::CYCLES + walk::CYCLES + lanes::CYCLES + tiles::CYCLES + multiplied;
        let first = stages as u64 + timing.latency(exp, 0);
        Ok(self.jobs * first + slowest + self.pixels)
    }
}
