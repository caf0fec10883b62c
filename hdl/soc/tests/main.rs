//! The SoC top in the netlist interpreter: its bus and registers, held to the table.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

mod bus;
mod model;
mod peakrdl;
mod registers;
mod starts;

use potamoi_formats::config::Config;

/// Small units, so that a clock is cheap.
fn config() -> Config {
    let text = "[gu]\nbanks = 1\nports = 1\nweight_bits = 8\nsegments = 2\nvertices = [8, 2]\n\
        counter_bits = 40\nrecords_a_row = 1\n[rit]\nentries = 8\n[mvoxel]\nrows = 4\n[vu]\nlanes = 1\n\
        ops = [\"pass\", \"add\"]\n";
    Config::from_toml(text, "test").unwrap()
}
