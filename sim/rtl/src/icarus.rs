//! Runs a module's Verilog under Icarus Verilog, cycle by cycle over pipes.
//!
//! A generated testbench reads one line of inputs a cycle, lets the module
//! settle, prints its outputs and gives the clock edge. Digits with bits that
//! are neither 0 nor 1 are kept separately.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::process::Command;
use std::sync::Arc;

use potamoi_netlist::{Header, Module, verilog};
use potamoi_verilated::cache::Scratch;
use potamoi_verilated::child::{self, Fault, Talker};

use super::model::RtlError;

/// Longest quoted output of a failed program, in characters.
const SAID: usize = 2000;

/// A compiled testbench.
pub(super) struct Program {
    folder: Arc<Scratch>,
    inputs: Vec<Port>,
    outputs: Vec<Port>,
}

#[derive(Debug, Clone)]
struct Port {
    name: String,
    width: u32,
}

/// A port of a running testbench.
#[derive(Debug, Clone, Copy)]
pub(super) struct Pin {
    output: bool,
    index: usize,
    width: u32,
}

impl Pin {
    pub(super) const fn words(self) -> usize {
        self.width.div_ceil(32) as usize
    }
}

/// A running testbench.
pub(super) struct Icarus {
    ports: [Vec<Port>; 2],
    /// 32-bit words of every input and output.
    values: [Vec<Vec<u32>>; 2],
    /// Unknown digits of every output, as words.
    unknown: Vec<Vec<u32>>,
    talker: Talker,
    line: String,
    answer: String,
    cycle: u64,
    _folder: Arc<Scratch>,
}

impl Program {
    pub(super) fn new(module: &Arc<Module>) -> Result<Self, RtlError> {
        Self::of_files(module, &verilog(module, &Header::default()))
    }

    /// Other Verilog with the ports of a module.
    pub(super) fn of_files(
        module: &Arc<Module>,
        sources: &BTreeMap<String, String>,
    ) -> Result<Self, RtlError> {
        let folder = Scratch::temporary().map_err(RtlError::Folder)?;
        let mut inputs = vec![Port {
            name: "rst_n".to_owned(),
            width: 1,
        }];
        let mut outputs = vec![];
        for port in module.ports() {
            let to = if port.output {
                &mut outputs
            } else {
                &mut inputs
            };
            to.push(Port {
                name: port.name,
                width: port.ty.width,
            });
        }
        let mut files = vec![PathBuf::from("testbench.v")];
        let bench = testbench(module.name(), &inputs, &outputs);
        std::fs::write(folder.path().join(&files[0]), bench).map_err(RtlError::Folder)?;
        for (name, text) in sources {
            std::fs::write(folder.path().join(name), text).map_err(RtlError::Folder)?;
            files.push(name.into());
        }
        let mut iverilog = Command::new("iverilog");
        iverilog
            .current_dir(folder.path())
            .env("TMPDIR", folder.path())
            .args(["-g2005", "-Wall", "-s", "testbench", "-o", "run.vvp"])
            .args(&files);
        let done = child::run(&iverilog, child::TO_READ).map_err(|f| broken("iverilog", f))?;
        if !done.status.success() {
            let said = String::from_utf8_lossy(&done.err);
            return Err(RtlError::Icarus(format!(
                "iverilog refuses the module {}: {}",
                module.name(),
                said.chars().take(SAID).collect::<String>()
            )));
        }
        if !folder.path().join("run.vvp").is_file() {
            let reason = "it left no program".to_owned();
            return Err(broken("iverilog", Fault::Ended { reason }));
        }
        Ok(Self {
            folder: Arc::new(folder),
            inputs,
            outputs,
        })
    }

    pub(super) fn start(&self) -> Result<Icarus, RtlError> {
        let mut vvp = Command::new("vvp");
        vvp.current_dir(self.folder.path()).args(["-n", "run.vvp"]);
        let talker = child::talk(&vvp, child::TO_READ).map_err(|f| broken("vvp", f))?;
        let zeros = |ports: &[Port]| {
            let words = |p: &Port| vec![0; p.width.div_ceil(32) as usize];
            ports.iter().map(words).collect::<Vec<_>>()
        };
        Ok(Icarus {
            values: [zeros(&self.inputs), zeros(&self.outputs)],
            unknown: zeros(&self.outputs),
            ports: [self.inputs.clone(), self.outputs.clone()],
            talker,
            line: String::new(),
            answer: String::new(),
            cycle: 0,
            _folder: self.folder.clone(),
        })
    }
}

/// Error of a program that gave no answer.
fn broken(tool: &'static str, fault: Fault) -> RtlError {
    match fault {
        Fault::Missing { .. } => RtlError::MissingTool {
            tool,
            disables: "the icarus engine",
            get: "install the package iverilog",
        },
        fault => RtlError::BrokenTool { tool, fault },
    }
}

/// Testbench of a module: it reads one line of hexadecimal numbers a cycle, and writes one.
fn testbench(name: &str, inputs: &[Port], outputs: &[Port]) -> String {
    use std::fmt::Write as _;
    let mut text = String::from(
        "`timescale 1ns/1ps\n`default_nettype none\nmodule testbench;\n  reg clk;\n  integer got;\n",
    );
    let declare = |text: &mut String, kind: &str, port: &Port| {
        let _ = writeln!(text, "  {kind} [{}:0] {};", port.width - 1, port.name);
    };
    for port in inputs {
        declare(&mut text, "reg", port);
    }
    for port in outputs {
        declare(&mut text, "wire", port);
    }
    let _ = writeln!(text, "  {name} unit (\n    .clk(clk)");
    for port in inputs.iter().chain(outputs) {
        let _ = writeln!(text, "    ,.{0}({0})", port.name);
    }
    let list = |ports: &[Port]| {
        let names: Vec<&str> = ports.iter().map(|p| p.name.as_str()).collect();
        names.join(", ")
    };
    let format = |ports: &[Port]| vec!["%h"; ports.len()].join(" ");
    let _ = write!(
        text,
        "  );\n  initial begin\n    clk = 1'b0;\n    \
         got = $fscanf(32'h8000_0000, \"{}\", {});\n    \
         while (got == {}) begin\n      #1;\n      \
         $display(\"{}\", {});\n      $fflush(32'h8000_0001);\n      \
         clk = 1'b1;\n      #1 clk = 1'b0;\n      \
         got = $fscanf(32'h8000_0000, \"{}\", {});\n    end\n    $finish;\n  end\nendmodule\n",
        format(inputs),
        list(inputs),
        inputs.len(),
        format(outputs),
        list(outputs),
        format(inputs),
        list(inputs),
    );
    text
}

impl Icarus {
    pub(super) fn pin(&self, name: &str) -> Result<Pin, RtlError> {
        for (output, ports) in [false, true].into_iter().zip(&self.ports) {
            if let Some(index) = ports.iter().position(|p| p.name == name) {
                let width = ports[index].width;
                return Ok(Pin {
                    output,
                    index,
                    width,
                });
            }
        }
        Err(RtlError::Icarus(format!("the module has no port {name}")))
    }

    pub(super) fn write(&mut self, pin: Pin, words: &[u32]) -> Result<(), RtlError> {
        if pin.output {
            return Err(RtlError::Icarus("an output cannot be set".to_owned()));
        }
        for (to, from) in self.values[0][pin.index].iter_mut().zip(words) {
            *to = *from;
        }
        Ok(())
    }

    pub(super) fn read(&self, pin: Pin, words: &mut [u32]) -> Result<(), RtlError> {
        let from = &self.values[usize::from(pin.output)][pin.index];
        for (to, from) in words.iter_mut().zip(from) {
            *to = *from;
        }
        Ok(())
    }

    /// One clock cycle; outputs are those before its edge.
    pub(super) fn exchange(&mut self) -> Result<(), RtlError> {
        self.line.clear();
        for value in &self.values[0] {
            for word in value.iter().rev() {
                self.line.push_str(&format!("{word:08x}"));
            }
            self.line.push(' ');
        }
        self.line.push('\n');
        let asked = self.talker.ask(&self.line, &mut self.answer);
        asked.map_err(|fault| broken("vvp", fault))?;
        self.cycle += 1;
        let mut texts = self.answer.split_ascii_whitespace();
        let values = self.values[1].iter_mut().zip(&mut self.unknown);
        for (port, (value, unknown)) in self.ports[1].iter().zip(values) {
            let text = texts.next().unwrap_or_default();
            if !parse(text, value, unknown) {
                return Err(RtlError::Icarus(format!(
                    "cycle {}: port {} is `{text}`: expected {} bits in hexadecimal digits",
                    self.cycle - 1,
                    port.name,
                    port.width
                )));
            }
        }
        Ok(())
    }

    /// Unknown digits of an output.
    pub(super) fn unknown(&self, pin: Pin) -> Option<&[u32]> {
        pin.output.then(|| self.unknown[pin.index].as_slice())
    }

    /// Value of a port without unknown bits.
    pub(super) fn read_known(&self, pin: Pin) -> Result<u64, RtlError> {
        let mut words = [0; 2];
        self.read(pin, &mut words)?;
        if self.unknown(pin).is_some_and(|u| u.iter().any(|w| *w != 0)) {
            return Err(RtlError::Icarus(format!(
                "cycle {}: port {} has bits that are neither 0 nor 1",
                self.cycle - 1,
                self.ports[usize::from(pin.output)][pin.index].name
            )));
        }
        Ok(u64::from(words[0]) | u64::from(words[1]) << 32)
    }
}

/// Parses hexadecimal digits into words, low word first. A digit that is x or z, wholly or in part,
/// is 0 in `value` and 15 in `unknown`.
fn parse(text: &str, value: &mut [u32], unknown: &mut [u32]) -> bool {
    if text.is_empty() || text.len().div_ceil(8) > value.len() {
        return false;
    }
    value.fill(0);
    unknown.fill(0);
    for (i, digit) in text.bytes().rev().enumerate() {
        let (word, low) = (i / 8, 4 * (i % 8));
        match char::from(digit).to_digit(16) {
            Some(bits) => value[word] |= bits << low,
            None if b"xXzZ".contains(&digit) => unknown[word] |= 15 << low,
            None => return false,
        }
    }
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_read_low_first_and_unknown_digits_kept_apart() {
        let (mut value, mut unknown) = ([9; 2], [9; 2]);
        assert!(parse("1deadbeef", &mut value, &mut unknown));
        assert_eq!((value, unknown), ([0xdead_beef, 1], [0, 0]));
        assert!(parse("x7X", &mut value, &mut unknown));
        assert_eq!((value, unknown), ([0x70, 0], [0xf0f, 0]));
        for bad in ["", "g", "12345678123456781", "-1"] {
            assert!(!parse(bad, &mut value, &mut unknown), "{bad}");
        }
    }
}
