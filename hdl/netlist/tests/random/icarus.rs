//! Runs Verilog under Icarus, with inputs from one file and outputs to another.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;
use std::process::Command;

use potamoi_netlist::{Module, PortInfo};

use super::Cycle;

/// A number in hexadecimal, of the width's digits.
pub(crate) fn hex(words: &[u32], width: u32) -> String {
    let mut text = String::new();
    for w in words.iter().rev() {
        let _ = write!(text, "{w:08x}");
    }
    text.split_off(text.len() - width.div_ceil(4) as usize)
}

/// A testbench: drives all inputs and `rst_n` while the clock is low, and
/// prints all outputs before it rises.
fn testbench(top: &Module, cycles: usize, folder: &Path) -> String {
    let ports = top.ports();
    let of =
        |output: bool| -> Vec<&PortInfo> { ports.iter().filter(|p| p.output == output).collect() };
    let inputs: Vec<_> = of(false);
    let width: u32 = 1 + inputs.iter().map(|p| p.ty.width).sum::<u32>();
    let mut t = String::from("`timescale 1ns / 1ps\nmodule bench;\n  reg clk = 0;\n");
    let _ = writeln!(t, "  reg [{}:0] stimulus [0:{}];", width - 1, cycles - 1);
    let _ = writeln!(t, "  reg [{}:0] now = 0;\n  integer i, file;", width - 1);
    for p in of(true) {
        let _ = writeln!(t, "  wire [{}:0] {};", p.ty.width - 1, p.name);
    }
    let _ = writeln!(
        t,
        "  {} dut (.clk(clk), .rst_n(now[{}])",
        top.name(),
        width - 1
    );
    let mut low = width - 1;
    for p in &inputs {
        low -= p.ty.width;
        let _ = writeln!(t, "    , .{}(now[{}:{low}])", p.name, low + p.ty.width - 1);
    }
    for p in of(true) {
        let _ = writeln!(t, "    , .{0}({0})", p.name);
    }
    let path = |name: &str| folder.join(name).display().to_string();
    let _ = writeln!(
        t,
        "  );\n  initial begin\n    $readmemh(\"{}\", stimulus);\n    file = $fopen(\"{}\", \"w\");\n    \
         for (i = 0; i < {cycles}; i = i + 1) begin\n      now = stimulus[i];\n      #5;",
        path("stimulus.hex"),
        path("outputs.txt")
    );
    for p in of(true) {
        let _ = writeln!(t, "      $fwrite(file, \"%h\\n\", {});", p.name);
    }
    t.push_str("      clk = 1;\n      #5;\n      clk = 0;\n    end\n    $fclose(file);\n    $finish;\n  end\nendmodule\n");
    t
}

fn tool(command: &mut Command) -> String {
    let name = command.get_program().to_string_lossy().into_owned();
    match command.output() {
        Err(e) => panic!(
            "{name} cannot be run ({e}): this test compares against Icarus Verilog; get it with \
             `apt-get install iverilog`, or put its folder into PATH"
        ),
        Ok(out) if !out.status.success() => {
            panic!(
                "{name} failed:\n{}{}",
                String::from_utf8_lossy(&out.stdout),
                String::from_utf8_lossy(&out.stderr)
            )
        }
        Ok(out) => String::from_utf8_lossy(&out.stdout).into_owned(),
    }
}

/// The outputs of every cycle, in hexadecimal, in the order of the ports.
pub(crate) fn run(
    top: &Module,
    files: &BTreeMap<String, String>,
    stimulus: &[Cycle],
    folder: &Path,
) -> Vec<Vec<String>> {
    let mut sources = vec![];
    for (name, text) in files {
        let path = folder.join(name);
        std::fs::write(&path, text).unwrap();
        sources.push(path);
    }
    let mut bits = String::new();
    let inputs: Vec<_> = top.ports().into_iter().filter(|p| !p.output).collect();
    for cycle in stimulus {
        // As one binary number, because widths are no multiples of four.
        let mut digits = String::from(if cycle.rst_n { "1" } else { "0" });
        for (port, words) in inputs.iter().zip(&cycle.inputs) {
            for bit in (0..port.ty.width).rev() {
                digits.push(if words[(bit / 32) as usize] >> (bit % 32) & 1 == 1 {
                    '1'
                } else {
                    '0'
                });
            }
        }
        let pad = (4 - digits.len() % 4) % 4;
        let digits = "0".repeat(pad) + &digits;
        for nibble in digits.as_bytes().chunks(4) {
            let value = nibble.iter().fold(0, |v, b| v * 2 + u32::from(b - b'0'));
            let _ = write!(bits, "{value:x}");
        }
        bits.push('\n');
    }
    std::fs::write(folder.join("stimulus.hex"), bits).unwrap();
    let bench = folder.join("bench.v");
    std::fs::write(&bench, testbench(top, stimulus.len(), folder)).unwrap();
    let program = folder.join("bench.vvp");
    tool(
        Command::new("iverilog")
            .args(["-g2005", "-s", "bench", "-o"])
            .arg(&program)
            .arg(&bench)
            .args(&sources),
    );
    tool(Command::new("vvp").arg("-n").arg(&program));
    let text = std::fs::read_to_string(folder.join("outputs.txt")).unwrap();
    let count = top.ports().iter().filter(|p| p.output).count();
    let lines: Vec<String> = text.lines().map(str::to_owned).collect();
    lines.chunks(count).map(<[String]>::to_vec).collect()
}
