//! Whatever the rules allow is emitted as Verilog that Verilator, Icarus and
//! Yosys accept without a word.
//!
//! `POTAMOI_SEED=N` takes the configuration of that seed alone.

use std::path::Path;
use std::process::Command;
use std::sync::Arc;

use potamoi_formats::config::Config;
use potamoi_netlist::{Header, IrErrors, Module, verilog};
use potamoi_units::gathering_unit::gathering_unit;
use potamoi_units::vector_unit::vector_unit;
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64Mcg;

fn text(seed: u64) -> String {
    let mut random = Pcg64Mcg::seed_from_u64(seed);
    let mut pick = |from: &[&str]| from[random.random_range(0..from.len())].to_owned();
    let ports: u32 = pick(&["1", "2", "3", "4", "8"]).parse().unwrap();
    let steps: u32 = pick(&["1", "2", "8"]).parse().unwrap();
    let trusted = pick(&["trusted", "any"]);
    let modes = pick(&["both", "both", "structured", "unstructured"]);
    let vertices = pick(&["[8, 4, 2]", "[8]", "[4, 2]"]);
    let deep = pick(&["false", "true"]);
    // The rules want cells for these.
    let (organisation, entry) = match (modes.as_str(), vertices.as_str()) {
        ("structured", "[8]") => ("parity", pick(&["paper", "compact"])),
        ("unstructured", _) => ("auto", "paper".to_owned()),
        _ => ("auto", pick(&["paper", "compact"])),
    };
    let exact = trusted == "trusted"
        && modes != "unstructured"
        && organisation == "auto"
        && entry == "paper";
    let sums = if exact {
        pick(&["rounded", "exact"])
    } else {
        "rounded".to_owned()
    };
    let records = if modes == "structured" {
        "1".to_owned()
    } else {
        pick(&["1", "2"])
    };
    let cells = organisation == "parity" || entry == "compact";
    let extra = match (ports, organisation) {
        (4 | 8, "auto") => pick(&["copies", "split"]),
        _ => "copies".to_owned(),
    };
    let form = pick(&[
        "restoring",
        "restoring",
        "restoring",
        "literal",
        "piecewise",
        "radix-4",
    ]);
    let output = match form.as_str() {
        "piecewise" | "radix-4" => "alpha".to_owned(),
        _ => pick(&["alpha", "alpha", "general"]),
    };
    let other = output == "alpha" && form != "restoring";
    let (input, ops) = match (form.as_str(), output.as_str()) {
        ("literal", _) => ("S0.14", r#"["exp"]"#.to_owned()),
        (_, "general") => ("S4.12", r#"["add", "exp"]"#.to_owned()),
        _ => (
            "U3.13",
            pick(&[
                r#"["pass", "relu", "add", "multiply", "square-sum", "exp", "one-minus-exp"]"#,
                r#"["one-minus-exp"]"#,
                r#"["exp", "relu"]"#,
                r#"["pass"]"#,
                if other {
                    r#"["exp"]"#
                } else {
                    r#"["exp", "one-minus-exp", "sigmoid", "softplus"]"#
                },
                if other {
                    r#"["exp", "one-minus-exp"]"#
                } else {
                    r#"["add", "sigmoid"]"#
                },
                if other {
                    r#"["add"]"#
                } else {
                    r#"["softplus"]"#
                },
            ]),
        ),
    };
    // Sigmoid and softplus are of the iterative form alone.
    let logistic = ops.contains("sigmoid") || ops.contains("softplus");
    let one_clock = form == "piecewise";
    let tail = form != "literal" && !one_clock && pick(&["true", "false"]) == "true";
    let pipelined =
        one_clock || form != "literal" && !logistic && pick(&["true", "false"]) == "true";
    let early_out = form == "restoring"
        && output == "alpha"
        && !(logistic || tail || pipelined)
        && pick(&["true", "false"]) == "true";
    let steps = if one_clock { 1 } else { steps };
    let registered = !early_out && pick(&["true", "false"]) == "true";
    let mut operands = String::new();
    if ops.contains("multiply") && pick(&["true", "false"]) == "true" {
        let (a, b) = (pick(&["2", "9", "22", "32"]), pick(&["3", "18", "31"]));
        let root = pick(&["2", "3", "19", "32"]);
        operands = format!("multiply = [{a}, {b}]\nsquare_sum = {root}\n");
    }
    let text = format!(
        "[gu]\norganisation = \"{organisation}\"\npipelined = {deep}\n\
         sums = \"{sums}\"\nrecords_a_row = {records}\n\
         banks = {}\nports = {ports}\nextra_ports = \"{extra}\"\nmodes = \"{modes}\"\nvertices = {vertices}\n\
         feature_bits = {}\nweight_bits = {}\nweights = \"{trusted}\"\nsegments = {}\n\
         fifo_depth = {}\ncounter_bits = {}\n[rit]\nentry = \"{entry}\"\nentries = {}\nslot_bits = {}\n\
         [mvoxel]\nrows = {}\n[vu]\nlanes = {}\nfifo_depth = {}\nops = {ops}\n\
         registered = {registered}\n[vu.operands]\n{operands}[vu.exp]\n\
         form = \"{form}\"\noutput = \"{output}\"\ninput = \"{input}\"\niterations = {}\ntail = {tail}\n\
         iterations_per_clock = {steps}\npipelined = {pipelined}\nearly_out = {early_out}\noutput_bits = {}\n\
         one_minus_frac_bits = {}\npieces = {}\nbase = \"{}\"\n",
        if organisation == "parity" {
            pick(&["8", "32", "64"])
        } else {
            pick(if records == "2" {
                &["2", "8", "34"]
            } else {
                &["1", "3", "8", "33", "64"]
            })
        },
        pick(&["8", "11", "16"]),
        pick(&["4", "9", "15"]),
        pick(&["1", "2", "8"]),
        pick(&["4", "8", "17"]),
        pick(&["24", "32"]),
        ports * 8,
        if modes == "structured" && entry == "paper" {
            pick(&["16", "32"])
        } else {
            "16".to_owned()
        },
        if cells || extra == "split" {
            pick(&["8", "64", "512"])
        } else {
            pick(&["8", "21", "512"])
        },
        pick(&["1", "3", "24"]),
        pick(&["3", "4", "9"]),
        if form == "radix-4" {
            pick(&["1", "4", "5", "8", "15"])
        } else {
            pick(&["4", "8", "16", "20", "27"])
        },
        if form == "literal" {
            "14".to_owned()
        } else {
            pick(&["8", "12", "16"])
        },
        pick(&["12", "16", "20", "24"]),
        pick(&["64", "128", "1024"]),
        if one_clock {
            pick(&["e", "two"])
        } else {
            "e".to_owned()
        },
    );
    // What would change nothing is refused where it is set.
    let is_unused = |line: &str| {
        modes == "unstructured" && line.starts_with("vertices =")
            || one_clock && line.starts_with("iterations =")
            || !one_clock && line.starts_with("pieces =")
    };
    (text.lines().filter(|line| !is_unused(line)))
        .map(|line| format!("{line}\n"))
        .collect()
}

fn accepted(config: &Config, seed: u64) {
    let again = format!(
        "seed {seed}\n{}\nrun again: POTAMOI_SEED={seed} cargo test -p potamoi-units --test units any_configuration",
        text(seed)
    );
    for unit in [gathering_unit(config), vector_unit(config)] {
        accepted_unit(unit, &again);
    }
}

fn accepted_unit(unit: Result<Arc<Module>, IrErrors>, of: &str) {
    let folder = tempfile::tempdir().unwrap();
    let unit = unit.unwrap_or_else(|e| panic!("{of}: {e}"));
    let mut files = vec![];
    for (name, text) in verilog(&unit, &Header::default()) {
        std::fs::write(folder.path().join(&name), text).unwrap();
        files.push(name);
    }
    let top = unit.name();
    let lint = [
        "--lint-only",
        "-Wall",
        "--language",
        "1364-2005",
        "--top-module",
        top,
    ];
    silent("verilator", &lint, &files, folder.path(), of);
    let icarus = ["-g2005", "-Wall", "-tnull", "-s", top];
    silent("iverilog", &icarus, &files, folder.path(), of);
    let script = format!(
        "read_verilog {}; hierarchy -check -top {top}; proc; check -assert",
        files.join(" ")
    );
    silent("yosys", &["-q", "-p", &script], &[], folder.path(), of);
}

fn silent(tool: &str, arguments: &[&str], files: &[String], folder: &Path, of: &str) {
    let mut command = Command::new(tool);
    command.args(arguments).args(files).current_dir(folder);
    let done = command
        .output()
        .unwrap_or_else(|e| panic!("{tool}: {e}; tools/setup installs it"));
    let said = [done.stdout, done.stderr].concat();
    let said = String::from_utf8_lossy(&said);
    assert!(
        done.status.success() && said.trim().is_empty(),
        "{tool} {arguments:?} says\n{said}\nof {of}"
    );
}

fn run(seeds: impl Iterator<Item = u64>) {
    let (mut taken, mut all) = (0, 0);
    for seed in seeds {
        all += 1;
        match Config::from_toml(&text(seed), "test") {
            Ok(config) => {
                taken += 1;
                accepted(&config, seed);
            }
            Err(error) => println!("seed {seed} is refused: {error}"),
        }
    }
    println!("{taken} of {all} configurations keep the rules");
    assert!(taken * 2 > all, "{taken} of {all}");
}

#[test]
fn tools_accept_what_the_rules_allow() {
    match std::env::var("POTAMOI_SEED") {
        Ok(seed) => run(std::iter::once(
            seed.parse().expect("POTAMOI_SEED is a number"),
        )),
        Err(_) => run(0..2),
    }
}

/// The feature-major organisation of small and odd sizes.
#[test]
fn tools_accept_banks_of_whole_vectors() {
    feature_major_units_are_accepted(&[
        "banks = 2\nlanes = 1\nports = 1\n[mvoxel]\nrows = 4",
        "banks = 4\nlanes = 4\nports = 2\nmodes = \"unstructured\"",
        "banks = 8\nlanes = 15\nports = 3\nmodes = \"structured\"\nvertices = [4, 2]\n\
         feature_bits = 9\nweight_bits = 7\nfifo_depth = 5\n\
         [rit]\nentries = 24\nslot_bits = 32\n[mvoxel]\nrows = 24",
        "banks = 8\nlanes = 2\nports = 2\nweights = \"any\"",
    ]);
}

/// The same up to the largest.
#[test]
#[ignore = "exhaustive; run with make test-full"]
fn tools_accept_many_banks_of_whole_vectors() {
    feature_major_units_are_accepted(&[
        "banks = 16\nlanes = 16\nports = 2\nmodes = \"unstructured\"",
        "banks = 64\nlanes = 2\nports = 2\nweights = \"any\"",
        "banks = 16\nlanes = 64\nports = 4",
    ]);
}

fn feature_major_units_are_accepted(shapes: &[&str]) {
    for (i, text) in shapes.iter().enumerate() {
        let text = format!("[gu]\norganisation = \"feature-major\"\n{text}");
        let config = Config::from_toml(&text, "test").unwrap_or_else(|e| panic!("{text}: {e}"));
        accepted_unit(gathering_unit(&config), &format!("{i}: {text}"));
    }
}

#[test]
#[ignore = "exhaustive; run with make test-full"]
fn tools_accept_many_configurations() {
    run((2..12).chain(100..160));
}

/// Engines of sigmoid and softplus of every shape: one step a clock and all at
/// once, tail, accumulators narrower and wider than the constants and the result.
#[test]
fn tools_accept_every_shape_of_sigmoid_and_softplus() {
    for (i, ops) in [
        r#"["sigmoid"]"#,
        r#"["softplus"]"#,
        r#"["sigmoid", "softplus"]"#,
        r#"["pass", "softplus", "one-minus-exp"]"#,
        r#"["exp", "sigmoid", "one-minus-exp"]"#,
    ]
    .into_iter()
    .enumerate()
    {
        for (j, exp) in [
            "iterations_per_clock = 20",
            "iterations = 9\ntail = true",
            "iterations = 5\niterations_per_clock = 9\ntail = true\noutput_bits = 20",
            "iterations = 31\naccumulator_bits = 40\nconstant_bits = 13\niterations_per_clock = 4",
            "accumulator_bits = 16\nconstant_bits = 40\none_minus_frac_bits = 8",
            "input = \"U1.24\"\noutput_bits = 4",
            "input = \"U2.4\"\nconstant_bits = 6\naccumulator_bits = 20\noutput_bits = 20",
        ]
        .into_iter()
        .enumerate()
        {
            // Each operation list with some of the shapes, all shapes with some list.
            if (i + j) % 3 == 0 {
                let text = format!("[vu]\nlanes = 2\nops = {ops}\n[vu.exp]\n{exp}");
                let config =
                    Config::from_toml(&text, "test").unwrap_or_else(|e| panic!("{text}: {e}"));
                accepted_unit(vector_unit(&config), &text);
            }
        }
    }
}

/// Straight pieces, radix 4 and early out of every shape: with and without
/// one-minus-exp and element-wise operations, narrow and wide.
#[test]
fn tools_accept_every_shape_of_the_other_exponentials() {
    let operations = [
        r#"["exp"]"#,
        r#"["one-minus-exp"]"#,
        r#"["exp", "one-minus-exp", "add"]"#,
    ];
    let shapes = [
        "form = \"piecewise\"\npipelined = true",
        "form = \"piecewise\"\npipelined = true\npieces = 1024\noutput_bits = 24\none_minus_frac_bits = 24",
        "form = \"piecewise\"\npipelined = true\npieces = 16\noutput_bits = 4\none_minus_frac_bits = 8",
        "form = \"piecewise\"\npipelined = true\nbase = \"two\"\nconstant_bits = 13",
        "form = \"piecewise\"\npipelined = true\ninput = \"U1.4\"\naccumulator_bits = 40\nconstant_bits = 40",
        "form = \"piecewise\"\npipelined = true\ninput = \"U3.24\"\naccumulator_bits = 16",
        "form = \"radix-4\"\niterations = 4\ntail = true",
        "form = \"radix-4\"\niterations = 4\ntail = true\npipelined = true",
        "form = \"radix-4\"\niterations = 15\niterations_per_clock = 4",
        "form = \"radix-4\"\niterations = 8\niterations_per_clock = 10\npipelined = true",
        "early_out = true",
        "early_out = true\niterations_per_clock = 3\noutput_bits = 8",
        "early_out = true\niterations = 31\noutput_bits = 24",
    ];
    for (i, ops) in operations.iter().enumerate() {
        for (j, exp) in shapes.iter().enumerate() {
            // Each operation list with some of the shapes, all shapes with some list.
            if (i + j) % 2 == 0 {
                let text = format!("[vu]\nlanes = 2\nops = {ops}\n[vu.exp]\n{exp}");
                let config =
                    Config::from_toml(&text, "test").unwrap_or_else(|e| panic!("{text}: {e}"));
                accepted_unit(vector_unit(&config), &text);
            }
        }
    }
}

/// Constants past the accumulator's precision are 0, and comparisons with them
/// decided.
#[test]
fn more_steps_than_precision() {
    for exp in [
        "iterations = 20\npipelined = true",
        "iterations = 27\npipelined = true\nconstant_bits = 19\naccumulator_bits = 20",
        "iterations = 27\niterations_per_clock = 31\nconstant_bits = 19\naccumulator_bits = 20",
    ] {
        let text = format!("[vu]\nlanes = 2\n[vu.exp]\n{exp}");
        let config = Config::from_toml(&text, "test").unwrap();
        accepted_unit(vector_unit(&config), &text);
    }
}
