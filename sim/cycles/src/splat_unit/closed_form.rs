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
    /// Cycles of one unit: latency of each job's first pair, time of the slowest part, and output of the pixels. The
    /// parts are the setup of records (six clocks each), the walk (a pixel a clock) and the lanes (a vector
    /// of exponentials an interval). The sum is a lower bound, since parts wait for one another. It is exact
    /// for a job of one pair on one lane. 0 without a splat unit.
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
