//! What both kinds of sequences are compared by.
#![allow(clippy::unwrap_used, missing_docs)]

use potamoi_dram_oracle::clocks;
use potamoi_system::system_model::MemoryDevice;
use potamoi_system::system_model::dram::{Access, Dram};

/// Compares a sequence on every device, with 1, 2 and 4 channels. The model may be off by `within`.
pub fn agree(name: &str, accesses: &[Access], within: f64) {
    for device in MemoryDevice::names() {
        agree_on(device, name, accesses, within);
    }
}

/// Compares a sequence on a device. DRAMsim3 has one delay for both gaps of the bus.
pub fn agree_on(device: &str, name: &str, accesses: &[Access], within: f64) {
    let own = MemoryDevice::builtin(device).unwrap();
    let timing = own.timing();
    assert!(own.geometry(1).ranks == 1 || timing.turnaround == timing.rank_switch);
    for channels in [1, 2, 4] {
        let geometry = own.geometry(channels);
        let expected = clocks(&geometry, &timing, accesses).unwrap() as f64;
        let found = Dram::new(geometry, timing).serve(accesses.iter().copied());
        let bytes = accesses.len() as f64 * f64::from(geometry.burst_bytes);
        let error = found.clocks as f64 / expected - 1.0;
        println!(
            "{device}, {name}, {channels} channels: {} clocks, DRAMsim3 {expected}: {:+.3} %, {:.2} GB/s",
            found.clocks,
            100.0 * error,
            bytes / (found.clocks as f64 * timing.clock_ns)
        );
        assert!(
            error.abs() < within,
            "{device}, {name}, {channels} channels: {error}"
        );
    }
}
