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
            "missing field",
        ),
    ] {
        let arguments = [&["synth", "--json", "r.json"], arguments].concat();
        let found = expect(at, 2, &arguments);
        assert!(found.contains(said), "{arguments:?}: {found}");
        assert!(!at.join("r.json").exists(), "{arguments:?}");
    }
    let output = potamoi()
        .current_dir(at)
        .env("PATH", at)
        .args(["synth", "--liberty", "tiny.lib", "--json", "r.json"])
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(3));
    let said = stderr(&output);
    assert!(
        said.contains("yosys is not here") && said.contains("tools/setup synth"),
        "{said}"
    );
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
    for unit in report["units"].as_array().unwrap() {
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
    let memories = report["units"][0]["memories"].as_array().unwrap();
    assert_eq!(memories.len(), 2);
}
