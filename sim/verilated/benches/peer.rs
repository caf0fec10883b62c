//! Speed of a Rust-driven model relative to a C++ test bench of the same stimulus.
//!
//! Fails when the Rust side is below 0.95 of the C++ side.
#![allow(missing_docs, clippy::expect_used, clippy::panic)]

use criterion::{Criterion, Throughput};
use potamoi_verilated::{ModelBuilder, Toolchain, peer::Peer};
use std::hint::black_box;

const CYCLES: usize = 40_000;
const ROUNDS: usize = 21;
const LEAST: f64 = 0.95;

/// 32 multiply-accumulate units on each of two sets of 512-bit operands, and ports of every
/// storage size.
const MACS: &str = r"
module macs(
    input  wire          clk,
    input  wire          valid,
    input  wire [11:0]   gain,
    input  wire [47:0]   tag,
    input  wire [511:0]  a,
    input  wire [511:0]  b,
    output reg           valid_q,
    output reg  [59:0]   tag_q,
    output reg  [1023:0] acc0,
    output reg  [1023:0] acc1
);
    integer i;
    initial begin
        valid_q = 0; tag_q = 0; acc0 = 0; acc1 = 0;
    end
    always @(posedge clk) begin
        valid_q <= valid;
        tag_q <= {gain, tag};
        for (i = 0; i < 32; i = i + 1) begin
            if (valid) begin
                acc0[32*i +: 32] <= acc0[32*i +: 32] + {16'd0, a[16*i +: 16]} * {16'd0, b[16*i +: 16]};
                acc1[32*i +: 32] <= acc1[32*i +: 32] ^ ({16'd0, a[16*i +: 16]} * {20'd0, gain});
            end
        end
    end
endmodule
";

fn main() {
    let tools = Toolchain::detect().expect("Verilator and a C++ compiler");
    let folder = tempfile::tempdir().expect("a temporary folder");
    let builder = ModelBuilder::new("macs")
        .source("macs.v", MACS)
        .cache_dir(folder.path());
    let peer = Peer::build(builder, &tools, "clk").expect("the model builds");
    let mut state = 0x2545_f491_4f6c_dd1du64;
    let stimulus: Vec<u32> = (0..CYCLES * peer.words_per_cycle())
        .map(|_| {
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            (state >> 16) as u32
        })
        .collect();

    let mut criterion = Criterion::default().configure_from_args().sample_size(10);
    let mut group = criterion.benchmark_group("macs");
    group.throughput(Throughput::Elements(CYCLES as u64));
    group.bench_function("rust", |b| {
        b.iter(|| peer.drive(black_box(&stimulus)).expect("the model runs"));
    });
    group.finish();
    criterion.final_summary();

    let report = peer.compare(&stimulus, ROUNDS).expect("both sides agree");
    println!(
        "{}, {} cycles, medians of {ROUNDS} interleaved rounds: Rust {:.1} ns/cycle, C++ {:.1} \
         ns/cycle, ratio {:.3} (least {LEAST}), checksum {:016x}",
        tools.verilator_version(),
        report.cycles,
        report.rust_ns,
        report.cpp_ns,
        report.ratio,
        report.checksum
    );
    assert!(report.ratio >= LEAST, "the Rust side is too slow");
}
