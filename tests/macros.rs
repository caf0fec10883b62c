//! Macros in place of the memories: the benches run with them, and the checks find one that breaks the
//! rules.

use std::path::Path;
use std::process::Command;

/// Macros of preset `small`; `idle` is what a port shows after an edge at which it does not read.
fn macros(idle: &str) -> String {
    format!(
        "module mft_bank_macro (
  input wire clk, we, re,
  input wire [15:0] wdata,
  input wire [8:0] addr,
  output reg [15:0] rdata
);
  reg [15:0] mem [0:511];
  always @(posedge clk) begin
    if (we) mem[addr] <= wdata;
    rdata <= re ? mem[addr] : {idle};
  end
endmodule

module rit_bank_macro (
  input wire clk, we, re,
  input wire [5:0] waddr, raddr,
  input wire [63:0] wdata,
  output reg [63:0] rdata
);
  reg [63:0] mem [0:63];
  always @(posedge clk) begin
    if (we) mem[waddr] <= wdata;
    if (re) rdata <= mem[raddr];
  end
endmodule
"
    )
}

/// What the bench of the gathering unit says, and whether it passes.
fn simulated(rtl: &Path, idle: &str, checks: &str) -> (bool, String) {
    let made = tempfile::tempdir().unwrap();
    let file = made.path().join("macros.v");
    std::fs::write(&file, macros(idle)).unwrap();
    let done = Command::new("make")
        .arg("-C")
        .arg(rtl.join("sim"))
        .args(["UNITS=gathering_unit", "RUNS=40:1", checks])
        .arg(format!("BUILD={}", made.path().join("build").display()))
        .arg(format!("MACROS={}", file.display()))
        .output()
        .unwrap();
    let said = [done.stdout, done.stderr].concat();
    (done.status.success(), String::from_utf8(said).unwrap())
}

#[test]
fn macros_are_simulated_and_watched() {
    let made = tempfile::tempdir().unwrap();
    let emitted = Command::new(env!("CARGO_BIN_EXE_potamoi"))
        .args(["--config", "small", "emit", "--out-dir"])
        .arg(made.path())
        .output()
        .unwrap();
    assert!(emitted.status.success());
    let (passes, said) = simulated(made.path(), "rdata", "CHECKS=1");
    assert!(passes && said.contains("PASS: "), "{said}");
    let (passes, said) = simulated(made.path(), "16'd0", "CHECKS=1");
    assert!(
        !passes && said.contains("check_holds does not hold"),
        "{said}"
    );
}
