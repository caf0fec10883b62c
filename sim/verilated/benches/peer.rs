//! Speed of a Rust-driven model relative to a C++ test bench of the same stimulus.
//!
//! Fails when a model of the size of a small accelerator unit runs below 0.95 of its C++ speed.
#![allow(missing_docs, clippy::expect_used, clippy::panic)]

use criterion::{Criterion, Throughput};
use potamoi_verilated::{ModelBuilder, Toolchain, peer::Peer};
use std::hint::black_box;

const CYCLES: usize = 40_000;
const ROUNDS: usize = 21;
const LEAST: f64 = 0.95;

/// A pair of 512-bit operands into 64 multiply-accumulate units: so little work a cycle that
/// the cost of driving shows most. Measured, and not held to the limit.
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

/// 32 banks with an arbiter-like address mix, read by lanes of two pipelined multiply-accumulate
/// units each: of the size of a small accelerator unit.
const GATHER: &str = r"
module lane(
    input  wire        clk,
    input  wire        en,
    input  wire [15:0] a,
    input  wire [15:0] b,
    input  wire [5:0]  raddr,
    output reg  [31:0] acc0,
    output reg  [31:0] acc1
);
    reg [31:0] bank [0:63];
    reg [31:0] rd, p0, p1;
    reg [5:0]  waddr;
    reg        en1, en2;
    integer i;
    initial begin
        for (i = 0; i < 64; i = i + 1) bank[i] = i * 32'h9e3779b9;
        rd = 0; p0 = 0; p1 = 0; waddr = 0; en1 = 0; en2 = 0; acc0 = 0; acc1 = 0;
    end
    always @(posedge clk) begin
        rd  <= bank[raddr];
        en1 <= en;
        en2 <= en1;
        if (en) waddr <= waddr + 6'd1;
        if (en2) bank[waddr] <= acc0 ^ acc1;
        if (en1) begin
            p0 <= {16'd0, a} * {16'd0, rd[15:0]};
            p1 <= {16'd0, b} * {16'd0, rd[31:16]};
        end
        if (en2) begin
            acc0 <= acc0 + p0;
            acc1 <= p1[31] ? acc1 - p1 : acc1 + p1;
        end
    end
endmodule
module gather(
    input  wire          clk,
    input  wire          valid,
    input  wire [11:0]   gain,
    input  wire [47:0]   tag,
    input  wire [511:0]  a,
    input  wire [511:0]  b,
    output reg  [59:0]   tag_q,
    output reg  [37:0]   total,
    output wire [511:0]  acc
);
    wire [511:0] low;
    wire [1023:0] high;
    genvar g;
    generate
        for (g = 0; g < 32; g = g + 1) begin : lanes
            wire [31:0] acc0;
            lane u(
                .clk(clk), .en(valid | a[16*g]),
                .a(a[16*g +: 16]), .b(b[16*g +: 16] ^ {4'd0, gain}),
                .raddr(a[16*g +: 6] ^ b[16*((g + 7) % 32) +: 6] ^ low[16*((g + 13) % 32) +: 6]),
                .acc0(acc0), .acc1(high[32*g +: 32]));
            assign low[16*g +: 16] = acc0[31:16] ^ acc0[15:0];
        end
    endgenerate
    assign acc = low;
    integer i;
    reg [37:0] sum;
    always @* begin
        sum = 0;
        for (i = 0; i < 32; i = i + 1) sum = sum + {6'd0, high[32*i +: 32]};
    end
    initial begin
        tag_q = 0; total = 0;
    end
    always @(posedge clk) begin
        tag_q <= {gain, tag};
        total <= sum;
    end
endmodule
";

fn main() {
    let tools = Toolchain::detect().expect("Verilator and a C++ compiler");
    println!("{} and {}", tools.verilator_version(), tools.cxx_version());
    let mut criterion = Criterion::default().configure_from_args().sample_size(10);
    let mut ratios = Vec::new();
    for (top, text) in [("macs", MACS), ("gather", GATHER)] {
        let builder = ModelBuilder::new(top)
            .source(format!("{top}.v"), text)
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
        ratios.push(report.ratio);
    }
    criterion.final_summary();
    assert!(
        ratios.last().is_some_and(|r| *r >= LEAST),
        "driven from Rust, gather runs below {LEAST} of its speed from C++"
    );
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
