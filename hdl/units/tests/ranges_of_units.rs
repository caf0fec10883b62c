//! The ranges of the units that are generated, and a run that keeps to them.

use std::sync::Arc;
use std::time::Instant;

use potamoi_formats::config::Config;
use potamoi_netlist::{Interpreter, Module, ranges};
use potamoi_units::gathering_unit::gathering_unit;
use potamoi_units::vector_unit::vector_unit;

fn keeps_to_its_ranges(module: &Arc<Module>, cycles: u64) {
    let start = Instant::now();
    let proven = ranges(module).unwrap_or_else(|e| panic!("{e}"));
    let derived = start.elapsed();
    let mut run = Interpreter::new(module, 1).with_ranges(&proven).unwrap();
    let rst_n = run.port("rst_n").unwrap();
    let inputs: Vec<_> = module.ports().into_iter().filter(|p| !p.output).collect();
    let mut state = 0x1234_5678u32;
    let mut random = || {
        state ^= state << 13;
        state ^= state >> 17;
        state ^= state << 5;
        state
    };
    run.clock().unwrap();
    run.set_u64(rst_n, 1).unwrap();
    let start = Instant::now();
    for _ in 0..cycles {
        for input in &inputs {
            let port = run.port(&input.name).unwrap();
            let value: Vec<u32> = (0..port.words()).map(|_| random()).collect();
            run.set_words(port, &value).unwrap();
        }
        run.clock()
            .unwrap_or_else(|e| panic!("{}: {e}", module.name()));
    }
    println!(
        "{}: ranges in {derived:?}, {:.0} cycles/s with checks",
        module.name(),
        cycles as f64 / start.elapsed().as_secs_f64()
    );
}

#[test]
fn the_gathering_unit_keeps_to_its_ranges() {
    keeps_to_its_ranges(&gathering_unit(&Config::paper()).unwrap(), 200);
}

#[test]
fn the_vector_unit_keeps_to_its_ranges() {
    keeps_to_its_ranges(&vector_unit(&Config::paper()).unwrap(), 200);
}

/// With one-minus-exp, whose powers reach 16: what is claimed of the pieces'
/// sums is proven.
#[test]
fn every_exponential_keeps_to_its_ranges() {
    for exp in [
        "form = \"piecewise\"\npipelined = true",
        "form = \"piecewise\"\npipelined = true\npieces = 1024\noutput_bits = 24",
        "form = \"piecewise\"\npipelined = true\npieces = 16\noutput_bits = 4\naccumulator_bits = 4",
        "form = \"piecewise\"\npipelined = true\nbase = \"two\"",
        "form = \"radix-4\"\niterations = 4\ntail = true",
        "form = \"radix-4\"\niterations = 8\npipelined = true",
        "early_out = true",
    ] {
        let text = format!("[vu]\nlanes = 2\n[vu.exp]\n{exp}");
        let config = Config::from_toml(&text, "test").unwrap_or_else(|e| panic!("{text}: {e}"));
        keeps_to_its_ranges(&vector_unit(&config).unwrap(), 300);
    }
}
