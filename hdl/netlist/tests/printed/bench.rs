//! One stimulus, three simulators.

use std::fmt::Write as _;
use std::path::Path;
use std::process::Command;
use std::sync::Arc;

use potamoi_netlist::{Header, Interpreter, Module, ModuleBuilder, PortInfo, verilog};
use potamoi_verilated::{ModelBuilder, Opt, Toolchain, Warnings};

use super::grow::ROWS;
use crate::choices::Random;

/// Cycles in reset, in which every row is written, and read after that.
const LOADING: usize = 2 * ROWS as usize;

/// Outputs, as hexadecimal digits: by cycle, then by port.
pub(crate) type Outputs = Vec<Vec<String>>;

/// Every module of a batch side by side, its ports under its name.
pub(crate) fn side_by_side(modules: &[Arc<Module>]) -> Arc<Module> {
    let mut m = ModuleBuilder::new("batch");
    for module in modules {
        let path = |port: &PortInfo| format!("{}__{}", module.name(), port.name);
        let (outputs, inputs): (Vec<_>, Vec<_>) =
            module.ports().into_iter().partition(|p| p.output);
        let given: Vec<_> = inputs
            .iter()
            .map(|p| (p.name.as_str(), m.input(&path(p), p.ty, "")))
            .collect();
        let instance = m.instance(&format!("the_{}", module.name()), module, &given);
        for port in &outputs {
            let s = m.out(instance, &port.name);
            m.output(&path(port), s, "");
        }
    }
    m.finish().expect("a batch of sound modules")
}

pub(crate) struct Bench {
    top: Arc<Module>,
    pub(crate) files: Vec<(String, String)>,
    pub(crate) inputs: Vec<PortInfo>,
    pub(crate) outputs: Vec<PortInfo>,
    /// By cycle: `rst_n`, then every input.
    stimulus: Vec<(bool, Vec<Vec<u32>>)>,
}

impl Bench {
    pub(crate) fn new(top: Arc<Module>, cycles: usize, seed: u64) -> Self {
        let (outputs, inputs): (Vec<_>, Vec<_>) = top.ports().into_iter().partition(|p| p.output);
        let mut r = Random::new(seed);
        let stimulus = (0..LOADING + cycles)
            .map(|cycle| {
                let loading = cycle < LOADING;
                let values = inputs.iter().map(|p| match p.name.rsplit("__").next() {
                    Some("load") => vec![u32::from(loading)],
                    Some("load_row") if loading => vec![cycle as u32 % ROWS],
                    _ => r.edge_value(p.ty.width),
                });
                let values = values.collect();
                (!loading && !r.chance(4), values)
            })
            .collect();
        let files = verilog(&top, &Header::default()).into_iter().collect();
        Self {
            top,
            files,
            inputs,
            outputs,
            stimulus,
        }
    }

    /// Runs the interpreter, from contents of this seed.
    pub(crate) fn interpret(&self, seed: u64) -> Outputs {
        let mut sim = Interpreter::new(&self.top, seed);
        let inputs: Vec<_> = self
            .inputs
            .iter()
            .map(|p| sim.port(&p.name).unwrap())
            .collect();
        let outputs: Vec<_> = self
            .outputs
            .iter()
            .map(|p| sim.port(&p.name).unwrap())
            .collect();
        let rst_n = sim.port("rst_n").ok();
        let mut seen = vec![];
        for (cycle, (running, values)) in self.stimulus.iter().enumerate() {
            if let Some(port) = rst_n {
                sim.set_u64(port, u64::from(*running)).unwrap();
            }
            for (port, value) in inputs.iter().zip(values) {
                sim.set_words(*port, value).unwrap();
            }
            sim.eval().unwrap();
            if cycle >= LOADING {
                seen.push(
                    outputs
                        .iter()
                        .map(|p| hex(&sim.words(*p).unwrap(), p.width()))
                        .collect(),
                );
            }
            sim.clock().unwrap();
        }
        seen
    }

    /// Builds a Verilator model and runs it; [`Bench::lint`] is for its warnings.
    pub(crate) fn verilate(&self, cache: &Path) -> Outputs {
        let tools = Toolchain::detect()
            .expect("this test needs Verilator 5 and a C++ compiler: run tools/setup");
        let mut builder = ModelBuilder::new(self.top.name())
            .cache_dir(cache)
            .optimise(Opt::O0)
            .warnings(Warnings::Allow);
        for (name, text) in &self.files {
            builder = builder.source(name, text);
        }
        let library = builder.build(&tools).unwrap_or_else(|e| panic!("{e}"));
        let mut sim = library.model(1).unwrap();
        let inputs: Vec<_> = self
            .inputs
            .iter()
            .map(|p| sim.port(&p.name).unwrap())
            .collect();
        let outputs: Vec<_> = self
            .outputs
            .iter()
            .map(|p| sim.port(&p.name).unwrap())
            .collect();
        let rst_n = self.top.has_reset().then(|| sim.port("rst_n").unwrap());
        let clock = self.top.is_clocked().then(|| sim.clock("clk").unwrap());
        let mut seen = vec![];
        for (cycle, (running, values)) in self.stimulus.iter().enumerate() {
            if let Some(port) = rst_n {
                sim.set_u64(port, u64::from(*running)).unwrap();
            }
            for (port, value) in inputs.iter().zip(values) {
                sim.set_words(*port, value).unwrap();
            }
            sim.eval().unwrap();
            if cycle >= LOADING {
                let ports = outputs.iter().zip(&self.outputs);
                seen.push(
                    ports
                        .map(|(p, info)| hex(&sim.words(*p).unwrap(), info.ty.width))
                        .collect(),
                );
            }
            if let Some(clock) = clock {
                sim.tick(clock).unwrap();
            }
        }
        seen
    }

    /// Compiles these files with Icarus, of which every warning is an error,
    /// and runs them. Unknown bits come back as `x`, which no value equals.
    pub(crate) fn icarus(&self, files: &[(String, String)]) -> Outputs {
        let dir = tempfile::tempdir().unwrap();
        for (name, text) in files {
            std::fs::write(dir.path().join(name), text).unwrap();
        }
        std::fs::write(dir.path().join("bench.v"), self.testbench()).unwrap();
        let mut lines = String::new();
        for (running, values) in &self.stimulus {
            let _ = writeln!(lines, "{}", u8::from(*running));
            for (value, port) in values.iter().zip(&self.inputs) {
                let _ = writeln!(lines, "{}", hex(value, port.ty.width));
            }
        }
        std::fs::write(dir.path().join("stimulus.hex"), lines).unwrap();
        let mut compile = Command::new("iverilog");
        compile.args([
            "-g2005",
            "-Wall",
            "-s",
            "bench",
            "-o",
            "bench.vvp",
            "bench.v",
        ]);
        compile.args(files.iter().map(|f| &f.0));
        let said = run(&mut compile, dir.path(), "Icarus Verilog");
        // The bench alone states a time scale.
        let said: Vec<_> = said.lines().filter(|l| !l.contains("timescale")).collect();
        assert!(said.is_empty(), "iverilog -Wall:\n{}", said.join("\n"));
        run(
            Command::new("vvp").args(["-n", "bench.vvp"]),
            dir.path(),
            "Icarus Verilog",
        );
        let text = std::fs::read_to_string(dir.path().join("outputs.hex")).unwrap();
        let values: Vec<_> = text.lines().map(str::to_owned).collect();
        let cycles = self.stimulus.len() - LOADING;
        assert_eq!(
            values.len(),
            cycles * self.outputs.len(),
            "values that Icarus wrote"
        );
        values
            .chunks(self.outputs.len())
            .map(<[String]>::to_vec)
            .collect()
    }

    fn testbench(&self) -> String {
        let widest = self.inputs.iter().map(|p| p.ty.width).max().unwrap_or(1);
        let rows = (self.inputs.len() + 1) * self.stimulus.len();
        let (mut ports, mut signals, mut set, mut show) =
            (vec![], String::new(), String::new(), String::new());
        if self.top.is_clocked() {
            ports.push(".clk(clk)".to_owned());
        }
        if self.top.has_reset() {
            ports.push(".rst_n(rst_n)".to_owned());
        }
        for (i, p) in self.inputs.iter().enumerate() {
            let top = p.ty.width - 1;
            let _ = writeln!(signals, "  reg [{top}:0] i{i};");
            let _ = writeln!(
                set,
                "      row = stimulus[at + {}]; i{i} = row[{top}:0];",
                i + 1
            );
            ports.push(format!(".{}(i{i})", p.name));
        }
        for (i, p) in self.outputs.iter().enumerate() {
            let _ = writeln!(signals, "  wire [{}:0] o{i};", p.ty.width - 1);
            let _ = writeln!(show, "        $fwrite(file, \"%h\\n\", o{i});");
            ports.push(format!(".{}(o{i})", p.name));
        }
        format!(
            "`timescale 1ns/1ns
module bench;
  reg clk = 0;
  reg rst_n;
  reg [{high}:0] stimulus [0:{last}];
  reg [{high}:0] row;
  integer cycle, at, file;
{signals}  {top} dut ({ports});
  initial begin
    $readmemh(\"stimulus.hex\", stimulus);
    file = $fopen(\"outputs.hex\");
    for (cycle = 0; cycle < {cycles}; cycle = cycle + 1) begin
      at = cycle * {stride};
      row = stimulus[at]; rst_n = row[0];
{set}      #1;
      if (cycle >= {LOADING}) begin
{show}      end
      clk = 1; #1;
      clk = 0; #1;
    end
    $fclose(file);
    $finish(0);
  end
endmodule
",
            high = widest - 1,
            last = rows - 1,
            top = self.top.name(),
            ports = ports.join(", "),
            cycles = self.stimulus.len(),
            stride = self.inputs.len() + 1,
        )
    }

    /// What Verilator's linter and Yosys say of the files; nothing, if all is
    /// well, but for the warnings that are `expected`.
    pub(crate) fn lint(&self, expected: &[&str]) {
        let dir = tempfile::tempdir().unwrap();
        for (name, text) in &self.files {
            std::fs::write(dir.path().join(name), text).unwrap();
        }
        let names: Vec<_> = self.files.iter().map(|f| f.0.as_str()).collect();
        let top = self.top.name();
        let mut verilator = Command::new("verilator");
        verilator
            .args([
                "--lint-only",
                "-Wall",
                "--language",
                "1364-2005",
                "--top-module",
                top,
            ])
            .args(&names);
        verilator.args(expected.iter().map(|w| format!("-Wno-{w}")));
        let said = run(&mut verilator, dir.path(), "Verilator");
        assert!(said.is_empty(), "verilator -Wall:\n{said}");
        let script = format!(
            "read_verilog {}; hierarchy -check -top {top}; proc; check -assert",
            names.join(" ")
        );
        let said = run(
            Command::new("yosys").args(["-q", "-p", &script]),
            dir.path(),
            "Yosys",
        );
        assert!(said.is_empty(), "yosys:\n{said}");
    }

    /// The first output that differs, if any.
    pub(crate) fn difference(
        &self,
        left: (&str, &Outputs),
        right: (&str, &Outputs),
    ) -> Option<Difference> {
        assert_eq!(
            left.1.len(),
            right.1.len(),
            "cycles of {} and {}",
            left.0,
            right.0
        );
        let cycles = left.1.iter().zip(right.1).enumerate();
        for (cycle, (a, b)) in cycles {
            if let Some(port) = (0..a.len()).find(|p| a[*p] != b[*p]) {
                let name = self.outputs[port].name.clone();
                let text = format!(
                    "cycle {} of {name}: {} says {}, {} says {}",
                    cycle + LOADING,
                    left.0,
                    a[port],
                    right.0,
                    b[port]
                );
                return Some(Difference { port: name, text });
            }
        }
        None
    }
}

pub(crate) struct Difference {
    pub(crate) port: String,
    pub(crate) text: String,
}

/// Runs a tool in a folder; what it said on standard error and output.
fn run(command: &mut Command, dir: &Path, tool: &str) -> String {
    let name = command.get_program().to_string_lossy().into_owned();
    let output = command.current_dir(dir).output();
    let output = output.unwrap_or_else(|e| {
        panic!(
            "`{name}` of {tool} does not start ({e}): run tools/setup, or apt-get install {}",
            tool.split(' ').next().unwrap_or(tool).to_lowercase()
        )
    });
    let said = String::from_utf8_lossy(&output.stderr).into_owned()
        + &String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success(), "{name} failed:\n{said}");
    said
}

/// All digits of a value, high digit first.
fn hex(words: &[u32], width: u32) -> String {
    let digits: String = words.iter().rev().map(|w| format!("{w:08x}")).collect();
    digits[digits.len() - width.div_ceil(4) as usize..].to_owned()
}
