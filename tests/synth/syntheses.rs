//! Whole syntheses, and what of them is in the repository.

use crate::common::{self, expect, json, potamoi, stderr};

/// PATH without CACTI: folders that have it are left out, and what synthesis needs of
/// them is linked to in `folder`.
fn without_cacti(folder: &std::path::Path) -> std::ffi::OsString {
    let path = std::env::var_os("PATH").unwrap();
    let (with, without): (Vec<_>, Vec<_>) =
        std::env::split_paths(&path).partition(|p| p.join("cacti").is_file());
    for name in ["pyosys", "yosys", "sta"] {
        if let Some(program) = with.iter().map(|p| p.join(name)).find(|p| p.is_file()) {
            std::os::unix::fs::symlink(program, folder.join(name)).unwrap();
        }
    }
    std::env::join_paths([folder.to_owned()].into_iter().chain(without)).unwrap()
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
        .env("POTAMOI_CACHE", at.join("cache"))
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
        ("tools", here["tools"] == expected["tools"]),
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
    let links = tempfile::tempdir().unwrap();
    let path = without_cacti(links.path());
    let synth = |arguments: &[&str], code: i32| {
        let output = potamoi()
            .current_dir(at)
            .env("POTAMOI_CACHE", at.join("cache"))
            .env("PATH", &path)
            .args([&["--config", "small", "synth", "--unit", "gu"], arguments].concat())
            .output()
            .unwrap();
        let said = common::stdout(&output) + &stderr(&output);
        assert_eq!(output.status.code(), Some(code), "{said}");
        said
    };
    let said = synth(&["--json", "r.json"], 0);
    assert!(
        said.contains("memories are not included: cacti is not installed"),
        "{said}"
    );
    assert!(said.contains("tools/setup memories"), "{said}");
    let report = json(&at.join("r.json"));
    assert!(report["raw"]["memories"].is_null() && report["scaled"]["memories"].is_null());
    assert!(
        report["without"]
            .to_string()
            .contains("CACTI is not installed"),
        "{report}"
    );
    let said = synth(&["--report", "r.md"], 3);
    assert!(said.contains("cacti is not installed"), "{said}");
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
            .env("POTAMOI_CACHE", at.join("cache"))
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
        said.contains("GHz placed and routed") && said.contains("seed 1"),
        "{said}"
    );
    let report = json(&at.join("r.json"));
    let unit = &report["units"][0];
    let used = |part: &str| unit[part]["used"].as_u64().unwrap();
    // B x M multipliers; a bank a channel and port, and those of the RIT.
    assert_eq!(used("multipliers"), 8);
    assert_eq!(used("block_rams"), 4 * 2 + 48);
    assert!(used("luts") > 1000 && used("flops") > 1000, "{unit}");
    assert!(unit["clock_ghz"].as_f64().unwrap() > 0.02, "{unit}");
    assert!(unit["clock_mhz"].as_f64().unwrap() > 20.0, "{unit}");
    assert!(place("1").contains("cached"));
    assert_eq!(json(&at.join("r.json")), report);
}

/// A library that says nothing of power is no reason to fail, and no power of 0.
#[test]
#[ignore = "exhaustive; run with make test-full"]
fn power_that_a_library_does_not_say_is_absent_with_its_reason() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let cells = concat!(env!("CARGO_MANIFEST_DIR"), "/sim/synth/cells/handful.lib");
    let text = std::fs::read_to_string(cells).unwrap();
    let synth = |code: i32, text: &str| {
        std::fs::write(at.join("cells.lib"), text).unwrap();
        let arguments = [
            "--config", "small", "synth", "--unit", "gu", "--json", "r.json",
        ];
        expect(
            at,
            code,
            &[&arguments[..], &["--liberty", "cells.lib"]].concat(),
        )
    };
    synth(0, &text.replace("internal_power", "external_power"));
    let report = json(&at.join("r.json"));
    let why = report["raw"]["units"][0]["power"]["absent"]
        .as_str()
        .unwrap();
    assert!(why.contains("has no internal_power of its output"), "{why}");
    std::fs::remove_file(at.join("r.json")).unwrap();
    let said = synth(2, &text.replace("\"1.54, 1.66, 2.14\"", "\"1.54, 1.66\""));
    assert!(said.contains("expected 3 values"), "{said}");
    assert!(!at.join("r.json").exists());
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
            .env("POTAMOI_CACHE", at.join(cache))
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
    assert!(!said.contains("cached"), "{said}");
    assert_eq!(read("a.json"), read("b.json"));
    for unit in ["gathering_unit", "vector_unit"] {
        let name = |folder: &str| format!("{folder}/{unit}.netlist.v");
        assert_eq!(read(&name("a")), read(&name("b")));
    }
    let said = synth("a", 0, &["--compare", "a.json"]);
    assert!(
        said.contains("cached") && said.contains("\nthe same as a.json"),
        "{said}"
    );
    let said = synth("a", 0, &["--unit", "gu", "--compare", "a.json"]);
    assert!(
        said.contains("\nthe same as a.json\n  vector_unit is in the file and was not made"),
        "{said}"
    );

    sums_add_up(&json(&at.join("a.json")));
    let report = json(&at.join("a.json"));
    let units = report["raw"]["units"].as_array().unwrap();
    units.iter().for_each(powers_add_up);

    // Of slices, and of the whole: how far a composed figure is from a measured one.
    synth("a", 0, &["--json", "whole.json", "--whole"]);
    let whole = json(&at.join("whole.json"));
    for (composed, measured) in units.iter().zip(whole["raw"]["units"].as_array().unwrap()) {
        powers_add_up(measured);
        for (way, most) in [("zero_delay", 0.02), ("with_glitches", 0.05)] {
            let of = |unit: &serde_json::Value| unit["power"][way]["pj_a_cycle"].as_f64();
            let error = of(composed).unwrap() / of(measured).unwrap() - 1.0;
            eprintln!("{}: {way}: {:+.2} %", composed["unit"], 100.0 * error);
            assert!(error.abs() < most, "{}: {way}: {error}", composed["unit"]);
        }
    }

    // Without work there is no power, and no figure that says 0.
    let said = synth("a", 0, &["--json", "none.json", "--activity", "none"]);
    assert!(!said.contains("power"), "{said}");
    let none = json(&at.join("none.json"));
    assert!(none["raw"]["units"][0].get("power").is_none());
    let without = none["without"].to_string();
    assert!(without.contains("power: not asked for"), "{without}");

    let said = synth("a", 1, &["--clock", "50"]);
    assert!(
        said.contains("GHz before wires, but --clock is 50 GHz"),
        "{said}"
    );
    assert!(said.contains("--clock is compared with paths"), "{said}");
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

/// Energies of a unit are those of its modules, and of their kinds; power is energy
/// times clock, and leakage.
fn powers_add_up(unit: &serde_json::Value) {
    let power = &unit["power"];
    let same = |found: f64, expected: f64, what: &str| {
        assert!(
            (found / expected - 1.0).abs() < 1e-9,
            "{what}: {found}, {expected}"
        );
    };
    let number = |of: &serde_json::Value, field: &str| of[field].as_f64().unwrap();
    let of_modules = |field: &str| -> f64 {
        let modules = power["modules"].as_array().unwrap().iter();
        modules.map(|m| number(m, field)).sum()
    };
    let (leakage, clock) = (number(power, "leakage_nw"), number(power, "clock_ghz"));
    same(of_modules("leakage_nw"), leakage, "leakage");
    assert!(clock <= number(unit, "clock_ghz"));
    for way in ["zero_delay", "with_glitches"] {
        let figures = &power[way];
        let sum = number(figures, "pj_a_cycle");
        let kinds = ["switching", "internal", "clock"];
        let kinds = kinds.map(|kind| number(figures, &format!("{kind}_pj_a_cycle")));
        assert!(kinds.iter().all(|kind| *kind > 0.0), "{figures}");
        same(kinds.iter().sum(), sum, way);
        same(of_modules(&format!("{way}_pj_a_cycle")), sum, way);
        same(number(figures, "mw"), sum * clock + leakage * 1e-6, way);
        assert!(number(figures, "rest_pj_a_cycle") < sum);
        let activity = &power["activity"];
        let items = number(figures, "pj_an_item") * number(activity, "items");
        same(items, sum * number(activity, "cycles"), way);
        assert!(activity["busy"].as_u64() <= activity["cycles"].as_u64());
    }
    let of = |way: &str, field: &str| number(&power[way], field);
    assert!(of("with_glitches", "pj_a_cycle") > of("zero_delay", "pj_a_cycle"));
    assert!(of("with_glitches", "toggles_a_net") > of("zero_delay", "toggles_a_net"));
}
