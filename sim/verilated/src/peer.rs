//! Measures a Rust-driven model against a C++ test bench of the same stimulus.
//!
//! The C++ program is what one would write by hand for the module: it assigns every input
//! member, evaluates the two halves of the clock, and reads every output, cycle by cycle. It is
//! linked with the very object file of the model that the Rust side loads, and compiled with
//! the same flags. Both sides fold all outputs of all cycles into a checksum, which must agree.
//!
//! ```no_run
//! use potamoi_verilated::{ModelBuilder, Toolchain, peer::Peer};
//!
//! # fn main() -> Result<(), potamoi_verilated::Error> {
//! # let verilog = "";
//! let builder = ModelBuilder::new("mac").source("mac.v", verilog);
//! let peer = Peer::build(builder, &Toolchain::detect()?, "clk")?;
//! let words = peer.words_per_cycle();
//! let stimulus: Vec<u32> = (0..1000 * words as u32).collect();
//! let report = peer.compare(&stimulus, 15)?;
//! println!("{:.2} of the speed of C++", report.ratio);
//! # Ok(())
//! # }
//! ```

use crate::{
    Direction, Error, Library, ModelBuilder, Port, Toolchain, commands, compile,
    store::{self, SCRATCH},
};
use std::{
    fmt::Write as _,
    io::{BufRead as _, BufReader, Write as _},
    path::{Path, PathBuf},
    process::{Child, ChildStdin, ChildStdout, Command, Stdio},
};

const PROGRAM: &str = "peer";
const SOURCE: &str = include_str!("cpp/peer.cpp");
const SEED: u32 = 1;
const PRIME: u64 = 0x0000_0100_0000_01b3;

/// A model with its C++ test bench.
#[derive(Debug)]
pub struct Peer {
    library: Library,
    clock: String,
    inputs: Vec<Port>,
    outputs: Vec<Port>,
    program: PathBuf,
}

/// Times of both drivers for the same cycles.
#[derive(Debug, Clone, PartialEq)]
pub struct DriverTimes {
    /// Cycles in each round.
    pub cycles: usize,
    /// Median processor time of a cycle driven from Rust, in nanoseconds.
    pub rust_ns: f64,
    /// Median processor time of a cycle driven from C++, in nanoseconds.
    pub cpp_ns: f64,
    /// Processor time of a cycle in the fastest round driven from Rust, in nanoseconds.
    pub rust_fastest_ns: f64,
    /// Processor time of a cycle in the fastest round driven from C++, in nanoseconds.
    pub cpp_fastest_ns: f64,
    /// Speed of the Rust side relative to C++: `cpp_ns / rust_ns`.
    pub ratio: f64,
    /// Checksum of all outputs, equal on both sides.
    pub checksum: u64,
}

impl Peer {
    /// Builds the model of `builder` and a C++ program that drives it by the input `clock`.
    ///
    /// # Errors
    /// As [`ModelBuilder::build`], and as [`Model::clock`](crate::Model::clock) for `clock`.
    pub fn build(builder: ModelBuilder, tools: &Toolchain, clock: &str) -> Result<Self, Error> {
        let builder = builder.keep_objects();
        let library = builder.build(tools)?;
        library.model(SEED)?.clock(clock)?;
        let (entry, ports) = builder.entry(tools)?;
        let members = entry.members()?;
        let pick = |dir: Direction| -> Vec<Port> {
            let wanted = |p: &&Port| p.dir == dir && p.name != clock;
            ports.iter().filter(wanted).cloned().collect()
        };
        let (inputs, outputs) = (pick(Direction::Input), pick(Direction::Output));
        let cpp = |name: &str| {
            let member = members.iter().find(|m| m.port.name == name);
            member.map_or_else(String::new, |m| m.cpp.clone())
        };
        let source = source(&inputs, &outputs, &cpp, &cpp(clock));
        let cache = builder.cache_folder()?;
        let optimise = builder.optimise_flag();
        let key = commands::tools_key(PROGRAM, tools, &[optimise])
            .with(library.key())
            .with(&source);
        let twin = store::fetch(&cache, PROGRAM, &key, &|folder| {
            let scratch = folder.join(SCRATCH);
            commands::write_prelude(&scratch)?;
            commands::write(&scratch.join("peer.cpp"), &source)?;
            let mut command = commands::compiler(tools, &scratch, builder.is_traced());
            command
                .arg(optimise)
                .arg("-I")
                .arg(entry.folder.join(compile::OBJ));
            command.arg("peer.cpp");
            command.arg(entry.folder.join(compile::MODEL_OBJECT));
            command.args(compile::runtime(&cache, tools, builder.is_traced())?);
            command.arg("-o").arg(folder.join(PROGRAM));
            commands::run(command, "compiling the C++ test bench")?;
            Ok(store::Product {
                files: vec![PROGRAM.into()],
                notes: Vec::new(),
            })
        })?;
        Ok(Peer {
            library,
            clock: clock.to_string(),
            inputs,
            outputs,
            program: twin.folder.join(PROGRAM),
        })
    }

    /// Inputs that the stimulus of a cycle sets, in order; the clock is not among them.
    pub fn inputs(&self) -> &[Port] {
        &self.inputs
    }

    /// Outputs read every cycle, in order.
    pub fn outputs(&self) -> &[Port] {
        &self.outputs
    }

    /// The loaded model.
    pub fn library(&self) -> &Library {
        &self.library
    }

    /// 32-bit words of stimulus for one cycle: the words of each input, the low word first, one
    /// input after another.
    pub fn words_per_cycle(&self) -> usize {
        self.inputs.iter().map(Port::words).sum()
    }

    /// Runs `stimulus` on both sides in turn, `rounds` times each, and reports the medians.
    ///
    /// Bits above a port's width are dropped on both sides.
    ///
    /// # Errors
    /// [`Error::Peer`] when the stimulus is empty or no whole number of cycles, when `rounds` is
    /// 0, or when the two sides do not read the same; [`Error::Stopped`] when the model stops.
    pub fn compare(&self, stimulus: &[u32], rounds: usize) -> Result<DriverTimes, Error> {
        let stimulus = self.masked(stimulus)?;
        if rounds == 0 {
            return Err(Error::Peer(
                "0 rounds were asked for; 1 is the least".into(),
            ));
        }
        let cycles = stimulus.len() / self.words_per_cycle();
        let folder =
            tempfile::tempdir().map_err(|e| Error::io("create", &std::env::temp_dir(), &e))?;
        let file = folder.path().join("stimulus");
        let bytes: Vec<u8> = stimulus.iter().flat_map(|w| w.to_le_bytes()).collect();
        std::fs::write(&file, bytes).map_err(|e| Error::io("write", &file, &e))?;
        let mut twin = CppDriver::start(&self.program, &file)?;
        let (mut rust, mut cpp) = (Vec::new(), Vec::new());
        let mut checksum = 0;
        for round in 0..rounds {
            // Whichever goes first may find the machine in another state, so they take turns.
            let (ours, theirs) = if round % 2 == 0 {
                let ours = self.run_rust(&stimulus)?;
                (ours, twin.run()?)
            } else {
                let theirs = twin.run()?;
                (self.run_rust(&stimulus)?, theirs)
            };
            if ours.checksum != theirs.checksum {
                return Err(Error::Peer(format!(
                    "Rust and C++ read different outputs over {cycles} cycles: checksums \
                     {:016x} and {:016x}",
                    ours.checksum, theirs.checksum
                )));
            }
            checksum = ours.checksum;
            rust.push(ours.ns);
            cpp.push(theirs.ns);
        }
        let fastest = |times: &[f64]| times.iter().copied().fold(f64::INFINITY, f64::min);
        let [rust_fastest_ns, cpp_fastest_ns] =
            [&rust, &cpp].map(|own| fastest(own) / cycles as f64);
        let per_cycle = |times: Vec<f64>| median(times) / cycles as f64;
        let (rust_ns, cpp_ns) = (per_cycle(rust), per_cycle(cpp));
        Ok(DriverTimes {
            cycles,
            rust_ns,
            cpp_ns,
            rust_fastest_ns,
            cpp_fastest_ns,
            ratio: cpp_ns / rust_ns,
            checksum,
        })
    }

    /// Drives a new model with the stimulus of [`Peer::compare`] and returns the checksum.
    ///
    /// # Errors
    /// As [`Peer::compare`].
    pub fn drive(&self, stimulus: &[u32]) -> Result<u64, Error> {
        Ok(self.run_rust(&self.masked(stimulus)?)?.checksum)
    }

    fn masked(&self, stimulus: &[u32]) -> Result<Vec<u32>, Error> {
        let words = self.words_per_cycle();
        if words == 0 || stimulus.is_empty() || !stimulus.len().is_multiple_of(words) {
            return Err(Error::Peer(format!(
                "the stimulus has {} words, which is not a positive multiple of the {words} \
                 words that the inputs take in a cycle",
                stimulus.len()
            )));
        }
        let masks: Vec<u32> = self.inputs.iter().flat_map(masks).collect();
        let cut = |(i, word): (usize, &u32)| word & masks.get(i % words).copied().unwrap_or(0);
        Ok(stimulus.iter().enumerate().map(cut).collect())
    }

    fn run_rust(&self, stimulus: &[u32]) -> Result<Round, Error> {
        let mut model = self.library.model(SEED)?;
        let clock = model.clock(&self.clock)?;
        let ports = self.library.ports();
        // The stimulus leaves the clock out; the model's packed inputs hold a word for it.
        let inputs = ports.iter().filter(|p| p.dir == Direction::Input);
        let mut at = 0;
        for port in inputs.clone() {
            if port.name == self.clock {
                break;
            }
            at += port.words();
        }
        let words = self.words_per_cycle();
        let packed: Vec<u32> = stimulus
            .chunks_exact(words)
            .flat_map(|cycle| {
                let (before, after) = cycle.split_at(at.min(words));
                before.iter().chain(&[0]).chain(after).copied()
            })
            .collect();
        // Low words of values of 33 to 64 bits, which are folded as one.
        let pairs: Vec<bool> = self
            .outputs
            .iter()
            .flat_map(|p| (0..p.words()).map(|i| p.words() == 2 && p.bits <= 64 && i == 0))
            .collect();
        let mut outputs = vec![0; pairs.len()];
        let start = cpu_ns();
        let mut checksum = 0;
        for cycle in packed.chunks_exact(words + 1) {
            model.cycle(clock, cycle, &mut outputs)?;
            checksum = fold_outputs(&pairs, &outputs, checksum);
        }
        Ok(Round {
            ns: cpu_ns() - start,
            checksum,
        })
    }
}

/// The C++ program; it waits for a byte before each round.
struct CppDriver {
    child: Child,
    ask: ChildStdin,
    answers: BufReader<ChildStdout>,
}

impl CppDriver {
    fn start(program: &Path, stimulus: &Path) -> Result<Self, Error> {
        let fail = |reason: String| Error::Peer(format!("the C++ test bench {reason}"));
        let mut child = Command::new(program)
            .arg(stimulus)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .map_err(|e| fail(format!("did not start: {e}")))?;
        match (child.stdin.take(), child.stdout.take()) {
            (Some(ask), Some(answers)) => Ok(CppDriver {
                child,
                ask,
                answers: BufReader::new(answers),
            }),
            _ => Err(fail("has no pipes".into())),
        }
    }

    fn run(&mut self) -> Result<Round, Error> {
        let mut line = String::new();
        let said = self
            .ask
            .write_all(b"r")
            .and_then(|()| self.ask.flush())
            .and_then(|()| self.answers.read_line(&mut line));
        let mut words = line.split_whitespace();
        let ns = words.next().and_then(|w| w.parse().ok());
        let checksum = words.next().and_then(|w| u64::from_str_radix(w, 16).ok());
        match (said, ns, checksum) {
            (Ok(_), Some(ns), Some(checksum)) => Ok(Round { ns, checksum }),
            _ => Err(Error::Peer(
                "the C++ test bench ended early; what stopped it is on standard error".into(),
            )),
        }
    }
}

impl Drop for CppDriver {
    fn drop(&mut self) {
        // It has nothing to save, and one that has ended already is as good.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// Processor time of this process in nanoseconds, with microsecond resolution. Wall time would
/// include other work on the machine.
fn cpu_ns() -> f64 {
    unsafe extern "C" {
        fn clock() -> std::ffi::c_long;
    }
    // SAFETY: the C library's `clock` has no precondition. POSIX fixes its unit at 1 us.
    unsafe { clock() as f64 * 1e3 }
}

struct Round {
    ns: f64,
    checksum: u64,
}

/// Folds the packed words of the outputs as the C++ program does.
#[inline]
fn fold_outputs(pairs: &[bool], words: &[u32], mut checksum: u64) -> u64 {
    let mut low = None;
    for (&word, &pair) in words.iter().zip(pairs) {
        let word = u64::from(word);
        if pair {
            low = Some(word);
        } else {
            let value = low.take().map_or(word, |low| low | word << 32);
            checksum = fold(checksum, value);
        }
    }
    checksum
}

#[inline]
fn fold(checksum: u64, value: u64) -> u64 {
    (checksum ^ value).wrapping_mul(PRIME)
}

fn masks(port: &Port) -> impl Iterator<Item = u32> + use<> {
    let (words, over) = (port.words(), port.bits % 32);
    (0..words).map(move |i| {
        if i + 1 == words && over > 0 {
            (1 << over) - 1
        } else {
            u32::MAX
        }
    })
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    let at = |i: usize| values.get(i).copied().unwrap_or(f64::NAN);
    let n = values.len();
    (at(n.saturating_sub(1) / 2) + at(n / 2)) / 2.0
}

fn source(inputs: &[Port], outputs: &[Port], cpp: &dyn Fn(&str) -> String, clock: &str) -> String {
    let (mut set, mut read) = (String::new(), String::new());
    let mut at = 0;
    for port in inputs {
        let name = cpp(&port.name);
        let _ = match port.bits {
            0..=32 => writeln!(set, "        top.{name} = in[{at}];"),
            33..=64 => writeln!(
                set,
                "        top.{name} = in[{at}] | uint64_t{{in[{}]}} << 32;",
                at + 1
            ),
            _ => writeln!(
                set,
                "        memcpy(&top.{name}[0], in + {at}, sizeof top.{name});"
            ),
        };
        at += port.words();
    }
    for port in outputs {
        let name = cpp(&port.name);
        let _ = if port.bits <= 64 {
            writeln!(read, "        sum = (sum ^ top.{name}) * PRIME;")
        } else {
            writeln!(
                read,
                "        for (int i = 0; i < {}; ++i) sum = (sum ^ top.{name}[i]) * PRIME;",
                port.words()
            )
        };
    }
    SOURCE
        .replace("@WORDS@", &at.to_string())
        .replace("@SET@", &set)
        .replace("@READ@", &read)
        .replace("@CLOCK@", clock)
        .replace("@PRIME@", &format!("{PRIME:#x}"))
}
