//! What both kinds of sequences are compared by.
#![allow(clippy::unwrap_used, missing_docs)]

use potamoi_dram_oracle::clocks;
use potamoi_system::system_model::dram::{Access, Dram, Geometry, Timing};

/// What the model may be off.
const WITHIN: f64 = 0.03;

pub fn agree(name: &str, accesses: &[Access]) {
    for channels in [1, 2, 4] {
        let (geometry, timing) = (Geometry::lpddr3(channels), Timing::LPDDR3_1600);
        let expected = clocks(&geometry, &timing, accesses).unwrap() as f64;
        let found = Dram::new(geometry, timing).serve(accesses.iter().copied());
        let bytes = accesses.len() as f64 * f64::from(geometry.burst_bytes);
        let error = found.clocks as f64 / expected - 1.0;
        println!(
            "{name}, {channels} channels: {} clocks, DRAMsim3 {expected}: {:+.3} %, {:.2} GB/s",
            found.clocks,
            100.0 * error,
            bytes / (found.clocks as f64 * timing.clock_ns)
        );
        assert!(error.abs() < WITHIN, "{name}, {channels} channels: {error}");
    }
}
