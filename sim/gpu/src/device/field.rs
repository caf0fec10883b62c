//! Fields of a device file: keys, ranges and units.

use super::Device;

/// Which way a device becomes faster.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Better {
    /// A larger value is faster, or costs no time.
    More,
    /// A smaller value is faster.
    Less,
}

/// A field of a device file.
#[derive(Debug, Clone, Copy)]
pub struct Field {
    /// Key in the file.
    pub key: &'static str,
    /// Unit, for messages and tables.
    pub unit: &'static str,
    /// Least value that is accepted.
    pub least: f64,
    /// Largest value that is accepted.
    pub most: f64,
    /// Direction in which the device is faster.
    pub better: Better,
    /// Place of the value.
    pub place: fn(&mut Device) -> &mut f64,
}

macro_rules! field {
    ($key:ident, $unit:literal, $least:literal..$most:literal, $better:ident) => {
        Field {
            key: stringify!($key),
            unit: $unit,
            least: $least,
            most: $most,
            better: Better::$better,
            place: |device| &mut device.$key,
        }
    };
}

/// All fields of a device file that hold figures.
pub const FIELDS: [Field; 19] = [
    field!(multiprocessors, "SMs", 1.0..1024.0, More),
    field!(clock_ghz, "GHz", 0.05..5.0, More),
    field!(fp32_lanes, "lanes an SM", 1.0..512.0, More),
    field!(int_lanes, "lanes an SM", 1.0..512.0, More),
    field!(sfu_lanes, "lanes an SM", 1.0..512.0, More),
    field!(warps, "warps an SM", 1.0..128.0, More),
    field!(l2_bytes, "bytes", 1e4..1e9, More),
    field!(l2_bytes_clock, "bytes a clock and SM", 1.0..256.0, More),
    field!(dram_gb_s, "GB/s", 1.0..2e4, More),
    field!(dram_share, "of the peak", 0.2..1.0, More),
    field!(tensor_tflops, "TFLOPS", 0.1..5e3, More),
    field!(operation_us, "us", 0.0..1e3, Less),
    field!(wait_us, "us", 0.0..1e3, Less),
    field!(launch_us, "us", 0.0..1e3, Less),
    field!(ramp_us, "us", 0.0..1e3, Less),
    field!(dram_latency_ns, "ns", 10.0..1e4, Less),
    field!(l2_latency_clocks, "clocks", 10.0..2e3, Less),
    field!(copy_gb_s, "GB/s", 0.1..1e3, More),
    field!(watts, "W", 1.0..2e3, More),
];
