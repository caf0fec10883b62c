//! The bench of the exponential by itself: every operand, against checksums of the golden reference;
//! and programs that compare its functions in C and Python with the same checksums.

use potamoi_cycles::Exponents;
use potamoi_formats::config::Config;
use potamoi_formats::units::{OpCode, VectorOp};
use potamoi_units::exponential::{EXPONENTIAL, alone, result_bits};
use std::collections::BTreeMap;

use super::exponential_sums as sums;
use super::exponential_twins as twins;
use super::makefile;
use super::vector::run;
use crate::RtlError;
use crate::vector_drive::{VectorBatch, Vectors};

/// Bits of an operand of which every code is run. 2^20 codes take seconds in Verilator.
const BITS: std::ops::RangeInclusive<u32> = 9..=20;

/// The folder `sim` of the exponential by itself: a Makefile, the bench, its expected checksums, and
/// programs that compare the functions in C and Python with them. The exponential lies in
/// `../exponential`, the C function in `../potamoi_exp.h`; `prefix` stands before the names of both.
///
/// # Errors
/// An operand of more bits than a bench can run through.
pub fn exponential(config: &Config, prefix: &str) -> Result<BTreeMap<String, String>, RtlError> {
    let config = alone(config);
    let exp = &config.vu.exp;
    let (bits, wide) = (exp.input.width(), result_bits(exp));
    if !BITS.contains(&bits) {
        let (least, most) = (BITS.start(), BITS.end());
        return Err(RtlError::Usage(format!(
            "vu.exp.input = {}: operands of {bits} bits; the bench runs through all operands of {least} \
             to {most} bits: choose other fraction bits",
            exp.input
        )));
    }
    let operands = sums::operands(exp);
    let batch = VectorBatch {
        op: VectorOp::new(OpCode::Exp),
        a: &operands,
        b: &vec![0; operands.len()],
    };
    let vectors = Vectors::new(&[batch], 1, &Exponents::of(&config))?;
    let (cycles, _) = run(&config, &vectors, 0)?;
    let bench = BENCH
        .replace("@UNIT@", &format!("{prefix}{EXPONENTIAL}"))
        .replace("@COMMAND@", &makefile::commands(EXPONENTIAL)[1])
        .replace("@BITS@", &bits.to_string())
        .replace("@WIDE@", &wide.to_string())
        .replace("@CYCLES@", &cycles.to_string())
        .replace("@START@", &format!("32'h{:08x}", sums::FNV[0]))
        .replace("@FACTOR@", &format!("32'h{:08x}", sums::FNV[1]));
    Ok(BTreeMap::from([
        ("Makefile".to_owned(), twins::makefile()),
        (format!("{EXPONENTIAL}_tb.v"), bench),
        (sums::FILE.to_owned(), sums::text(exp, &operands)),
        (twins::C_FILE.to_owned(), twins::c(exp, prefix)),
        (twins::PYTHON_FILE.to_owned(), twins::python(exp)),
    ]))
}

const BENCH: &str = r#"// Every operand of the exponential, in order. 256 results have a checksum, by the golden reference.
//
// Run in this folder: make, or
//   @COMMAND@
//
// Options: +gaps=P  source and sink pause in about P % of the clocks (default 0)
//          +seed=N  another pattern of pauses (default 1)
//          +dump    write all signals; +dump=FILE into that file
// The last line says PASS or FAIL; the exit status of FAIL is not 0. Without gaps the cycles from
// the first operand to the last result are compared too.

`timescale 1ns/1ps
`default_nettype none

module exponential_tb;
  localparam OPERANDS = 1 << @BITS@;
  localparam CYCLES = @CYCLES@;
  localparam [31:0] START = @START@;  // of a checksum
  localparam [31:0] FACTOR = @FACTOR@;

  reg clk = 1'b0;
  always #5 clk = ~clk;
  reg rst_n = 1'b0;
  reg x_valid = 1'b0;
  reg [@BITS@-1:0] x_data = 0;
  wire x_ready;
  wire y_valid;
  wire [@WIDE@-1:0] y_data;
  reg y_ready = 1'b0;

  @UNIT@ unit (
    .clk(clk), .rst_n(rst_n),
    .x_valid(x_valid), .x_data(x_data), .x_ready(x_ready),
    .y_valid(y_valid), .y_data(y_data), .y_ready(y_ready)
  );

  reg [31:0] sums [0:OPERANDS/256-1];
  reg [31:0] sum = START;
  reg [31:0] drawn;
  integer gaps;
  integer seed;
  integer file;
  reg [8*256-1:0] dump;
  integer sent = 0;
  integer taken = 0;
  integer cycles = 0;
  integer quiet = 0;  // clocks since a result was taken
  reg failed = 1'b0;
  reg held = 1'b0;
  reg [@WIDE@-1:0] held_data;

  task fail;
    begin
      failed = 1'b1;
`ifdef __ICARUS__
      $finish_and_return(1);
`else
      $fatal(1);
`endif
    end
  endtask

  initial begin
    if (!$value$plusargs("gaps=%d", gaps)) gaps = 0;
    if (!$value$plusargs("seed=%d", seed)) seed = 1;
    drawn = seed * 2 + 1;
    if ($value$plusargs("dump=%s", dump)) begin
      $dumpfile(dump);
      $dumpvars(0, exponential_tb);
    end else if ($test$plusargs("dump")) begin
      $dumpfile("exponential.vcd");
      $dumpvars(0, exponential_tb);
    end
    file = $fopen("exponential_sums.hex", "r");
    if (file == 0) begin
      $display("FAIL: exponential_sums.hex is missing: run in the folder of the .hex files");
      fail;
    end else begin
      $fclose(file);
      $readmemh("exponential_sums.hex", sums);
    end
  end

  // An xorshift generator, so that all simulators pause alike.
  task draw;
    begin
      drawn = drawn ^ (drawn << 13);
      drawn = drawn ^ (drawn >> 17);
      drawn = drawn ^ (drawn << 5);
    end
  endtask

  always @(posedge clk) begin
    if (rst_n && !failed) begin
      cycles = cycles + 1;
      quiet = quiet + 1;
      if (held && (y_valid !== 1'b1 || y_data !== held_data)) begin
        $display("FAIL: result %0d was not held until it was taken", taken);
        fail;
      end
      held = y_valid === 1'b1 && !y_ready;
      held_data = y_data;
      if (y_valid !== 1'b0 && y_ready) begin
        quiet = 0;
        sum = (sum ^ y_data) * FACTOR;
        if (taken == OPERANDS) begin
          $display("FAIL: a result too many");
          fail;
        end else if (taken % 256 == 255 && sum !== sums[taken / 256]) begin
          $display("FAIL: operands %0d to %0d: checksum %h, expected %h", taken - 255, taken, sum,
            sums[taken / 256]);
          fail;
        end
        if (taken % 256 == 255) sum = START;
        taken = taken + 1;
        if (!failed && taken == OPERANDS && gaps == 0 && cycles != CYCLES) begin
          $display("FAIL: %0d cycles, expected %0d", cycles, CYCLES);
          fail;
        end
      end
      if (!failed && taken == OPERANDS && quiet == 64) begin
        $display("PASS: exponential, %0d results, +gaps=%0d +seed=%0d", taken, gaps, seed);
        failed = 1'b1;
        $finish(0);
      end else if (!failed && quiet > 5000) begin
        $display("FAIL: nothing came for %0d clocks after %0d results", quiet, taken);
        fail;
      end
    end
    // Inputs of the next clock. A source that pauses holds another operand, which must not be taken.
    if (rst_n && x_valid && x_ready === 1'b1) begin
      sent = sent + 1;
      x_valid <= 1'b0;
    end
    if (!x_valid || x_ready === 1'b1) begin
      draw;
      if (sent < OPERANDS && drawn[30:8] % 100 >= gaps) begin
        x_valid <= 1'b1;
        x_data <= sent;
      end else begin
        x_valid <= 1'b0;
        x_data <= ~sent;
      end
    end
    draw;
    y_ready <= drawn[30:8] % 100 >= gaps;
    rst_n <= 1'b1;
  end
endmodule

`default_nettype wire
"#;
