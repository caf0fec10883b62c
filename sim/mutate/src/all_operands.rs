//! Whether a mutant of a pipelined exponential changes the result of any operand.
//!
//! A lane with the fault and one without are given every operand, one a clock, and their results are
//! compared. That shows all that such a fault can do, if it reaches nothing but the exponential: by the
//! miter of the lane, with any contents of the exponential's registers, no other result and no other
//! register differs.

use std::fmt::Write as _;
use std::process::Command;
use std::time::Duration;

use potamoi_formats::config::Config;
use potamoi_verilated::child;
use tempfile::TempDir;

use crate::design::SELECT;
use crate::tools::{broken, no_result, succeed, text, write};
use crate::unit_miter::{CHOSEN, UnitMiter};
use crate::{Design, Mutant, MutateError};

/// The module with the exponential.
const LANE: &str = "vector_lane";
/// Operands beside those that are told apart, on both sides.
const BEYOND: i64 = 64;
/// Clocks after which a pipeline is filled.
const FILLED: u32 = 64;
/// Most operands.
const MOST: i64 = 1 << 26;
/// Time limit of one comparison.
const LIMIT: Duration = Duration::from_secs(900);

/// Two lanes, of which one has a fault.
pub(crate) struct AllOperands<'a> {
    miter: &'a UnitMiter,
    folder: TempDir,
}

impl<'a> AllOperands<'a> {
    /// Compiles the lanes, if the exponential is pipelined and has few enough operands, and compares them
    /// without a fault. `miters` are those of the unit and of its modules that are proven alone.
    pub(crate) fn new(
        config: &Config,
        design: &Design,
        miters: &'a [UnitMiter],
    ) -> Result<Option<Self>, MutateError> {
        let lane = miters.iter().find(|miter| miter.unit.module.name() == LANE);
        let ranges = operands(config);
        let few = ranges.iter().all(|range| range[1] - range[0] <= MOST);
        let (Some(miter), true) = (lane, config.vu.exp.pipelined && few) else {
            return Ok(None);
        };
        let folder = tempfile::tempdir().map_err(|error| MutateError::File {
            path: std::env::temp_dir(),
            error,
        })?;
        for (name, text) in design.verilog(0)? {
            write(&folder.path().join(name), &text)?;
        }
        write(
            &folder.path().join("lanes.v"),
            &lanes(miter, design.width(), &ranges),
        )?;
        let mut verilator = Command::new("verilator");
        verilator.current_dir(folder.path());
        verilator.args([
            "--binary",
            "--timing",
            "-O3",
            "-Wno-fatal",
            "-Wno-lint",
            "-Wno-WIDTH",
        ]);
        let unit = format!("{}_mutated.v", design.unit.module.name());
        verilator.args(["--top-module", "lanes", "-Mdir", "build", "lanes.v", &unit]);
        succeed(&verilator, "verilator", LANE)?;
        let this = Self { miter, folder };
        match this.difference(0)? {
            None => Ok(Some(this)),
            Some(said) => Err(MutateError::Unmutated("comparison", LANE.to_owned(), said)),
        }
    }

    /// Whether the mutant changes no result of the lane.
    pub(crate) fn equivalent(&self, mutant: &Mutant) -> Result<bool, MutateError> {
        Ok(mutant.module == LANE
            && self.miter.reaches_the_exponential_alone(mutant)?
            && self.difference(mutant.number)?.is_none())
    }

    /// The first difference.
    fn difference(&self, mutant: usize) -> Result<Option<String>, MutateError> {
        let mut command = Command::new(self.folder.path().join("build/Vlanes"));
        command.arg(format!("+mutant={mutant}"));
        let what = format!("{LANE} with mutant {mutant}");
        let done = child::run(&command, LIMIT).map_err(|e| broken("the comparison", &what, e))?;
        let said = text(&done);
        let differs = said.lines().find(|line| line.contains("DIFFERS"));
        match (differs, said.contains("ALL THE SAME")) {
            (Some(line), false) => Ok(Some(line.trim().to_owned())),
            (None, true) => Ok(None),
            _ => Err(no_result("the comparison", &what, &said)),
        }
    }
}

/// First and last operand of exp(-s), and of 1 - exp(-s) where it is built, with some that are out of
/// range.
fn operands(config: &Config) -> Vec<[i64; 2]> {
    let exp = &config.vu.exp;
    let bits = exp.input.width();
    let low = if exp.input.is_signed() {
        -(1i64 << (bits - 1))
    } else {
        0
    };
    let high = low + (1i64 << bits);
    let mut all = vec![[low - BEYOND, high + BEYOND]];
    if config.vu.ops.iter().any(|op| op.name() == "one-minus-exp") {
        all.push([-BEYOND, (1i64 << (4 + exp.one_minus_frac_bits)) + BEYOND]);
    }
    all
}

/// Verilog of both lanes and of their operands.
fn lanes(miter: &UnitMiter, width: u32, ranges: &[[i64; 2]]) -> String {
    let ports = |mutant: &str, result: &str| {
        let mut all = format!(".clk(clk), .{SELECT}({mutant})");
        for port in miter.unit.module.ports() {
            let value = match port.name.as_str() {
                "a" => "a",
                "one_minus" | "result_is_one_minus" => "one_minus",
                CHOSEN | "result_keep" => "1'b1",
                "keep" => "{8{1'b1}}",
                "result" => result,
                _ if port.output => "",
                _ => "0",
            };
            // Writing to a string does not fail.
            let _ = write!(all, ", .{}({value})", port.name);
        }
        all
    };
    let bounds = |end: fn(&[i64; 2]) -> i64| {
        let first = ranges.first().map_or(0, end);
        let last = ranges.last().map_or(0, end);
        format!("one_minus ? 64'sd0 + ({last}) : 64'sd0 + ({first})")
    };
    let [low, high] = [bounds(|range| range[0]), bounds(|range| range[1])];
    let passes = ranges.len();
    let (good, faulty) = (
        ports(&format!("{width}'d0"), "good"),
        ports("mutant", "faulty"),
    );
    format!(
        "module lanes;
  reg clk = 1'b0;
  always #1 clk = ~clk;
  reg [{top}:0] mutant;
  initial if (!$value$plusargs(\"mutant=%d\", mutant)) mutant = 0;
  reg one_minus = 1'b0;
  wire signed [63:0] low = {low};
  wire signed [63:0] high = {high};
  reg signed [63:0] offset = 0;
  wire signed [63:0] operand = low + offset;
  wire [31:0] a = operand[31:0];
  wire [31:0] good, faulty;
  {LANE} without ({good});
  {LANE} with_fault ({faulty});
  integer passes = 0;
  always @(posedge clk) begin
    offset <= offset + 1;
    if (offset > {FILLED} && good !== faulty) begin
      $display(\"DIFFERS: %h, expected %h, soon after operand %0d, 1 - exp: %b\", faulty, good, operand, one_minus);
      $finish;
    end else if (operand > high + {FILLED}) begin
      passes = passes + 1;
      if (passes == {passes}) begin
        $display(\"ALL THE SAME\");
        $finish;
      end
      one_minus <= 1'b1;
      offset <= 0;
    end
  end
endmodule
",
        top = width - 1,
    )
}
