//! Speed of a Rust-driven model relative to a C++ test bench of the same stimulus.
#![allow(missing_docs, clippy::expect_used, clippy::panic)]

use criterion::{Criterion, Throughput};
use potamoi_verilated::{ModelBuilder, Toolchain, peer::Peer};
use std::hint::black_box;

const CYCLES: usize = 10_000;
const ROUNDS: usize = 201;

/// A pair of 512-bit operands into 64 multiply-accumulate units: so little work a cycle that
/// the cost of driving shows most.
const MACS: &[(&str, &str)] = &[("macs.v", include_str!("macs.v"))];

/// 32 banks with an arbiter-like address mix, read by lanes of two pipelined multiply-accumulate
/// units each: of the size of a small accelerator unit.
const GATHER: &[(&str, &str)] = &[
    ("lane.v", include_str!("lane.v")),
    ("gather.v", include_str!("gather.v")),
];

fn main() {
    let tools = Toolchain::detect().expect("Verilator and a C++ compiler");
    println!("{} and {}", tools.verilator_version(), tools.cxx_version());
    let mut criterion = Criterion::default().configure_from_args().sample_size(10);
    for (top, files) in [("macs", MACS), ("gather", GATHER)] {
        let builder = files
            .iter()
            .fold(ModelBuilder::new(top), |b, (name, text)| {
                b.source(*name, *text)
            })
            .cache_dir(concat!(env!("CARGO_TARGET_TMPDIR"), "/models"));
        let peer = Peer::build(builder, &tools, "clk").expect("the model builds");
        let stimulus = stimulus(CYCLES * peer.words_per_cycle());
        let mut group = criterion.benchmark_group(top);
        group.throughput(Throughput::Elements(CYCLES as u64));
        group.bench_function("rust", |b| {
            b.iter(|| peer.drive(black_box(&stimulus)).expect("the model runs"));
        });
        group.finish();
        let report = peer.compare(&stimulus, ROUNDS).expect("both sides agree");
        println!(
            "{top}: {} cycles, medians of {ROUNDS} interleaved rounds: Rust {:.1} ns/cycle, C++ \
             {:.1} ns/cycle, ratio {:.3}, checksum {:016x}",
            report.cycles, report.rust_ns, report.cpp_ns, report.ratio, report.checksum
        );
    }
    criterion.final_summary();
}

/// A fixed sequence of words (xorshift64).
fn stimulus(words: usize) -> Vec<u32> {
    let mut state = 0x2545_f491_4f6c_dd1du64;
    let next = || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 16) as u32
    };
    std::iter::repeat_with(next).take(words).collect()
}
