//! Searches, and what they write as a machine for every command.

use std::fs;

use super::assert_narrow;
use crate::common::{expect, json};

#[test]
fn what_the_search_finds_is_a_machine_for_every_command() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let search = [
        "explore",
        "small",
        "--scene",
        "garden",
        "--width",
        "16",
        "--vary",
        "vu.lanes=2,4,6",
        "--vary",
        "vu.exp.pipelined=false,true",
        "--vary",
        "system.memory_channels=2,4",
        "--vary",
        "clock=reached,0.5",
        "--max-area",
        "1.2",
        "--min-psnr",
        "60",
        "--objective",
        "fps",
        "--json",
        "e.json",
    ];
    let text = expect(path, 0, &search);
    assert_narrow(&text);
    assert!(text.contains("every point of the space: 24"), "{text}");
    assert!(text.contains("no mismatch in any bit or cycle"), "{text}");
    let found = fs::read_to_string(path.join("found.toml")).unwrap();
    assert!(!found.contains("not verified"), "{found}");
    let small = ["--width", "16", "--scene", "garden"];
    let on = |command: &[&str]| expect(path, 0, &[command, &small].concat());
    on(&[
        "model",
        "--config",
        "found.toml",
        "--frames",
        "2",
        "--variants",
        "fs+gu",
    ]);
    on(&["compare", "paper", "found.toml"]);
    on(&["verify", "--config", "found.toml"]);
    expect(
        path,
        0,
        &["emit", "--config", "found.toml", "--out-dir", "rtl"],
    );
    let report = json(&path.join("e.json"));
    assert!(report["proofs"][0]["elements"][0].as_u64().unwrap() > 0);
    // No point that keeps the limits is faster.
    let at = |name: &str| {
        let columns = report["columns"].as_array().unwrap();
        columns.iter().position(|own| own == name).unwrap()
    };
    let tried = report["trials"]["tried"].as_array().unwrap();
    let best = report["trials"]["best"].as_u64().unwrap() as usize;
    let fps = |own: &serde_json::Value| own["scenes"][0]["Ok"][at("fps")].as_f64();
    let most = tried
        .iter()
        .filter(|own| own["keeps_limits"] == true)
        .filter_map(fps);
    assert_eq!(most.fold(0.0, f64::max), fps(&tried[best]).unwrap());
    let front = report["trials"]["front"].as_array().unwrap();
    assert_eq!(front[0].as_u64().unwrap() as usize, best);
    assert!(text.contains("front of fps, area and quality"), "{text}");
    let out_of_reach = [&search[..16], &["--min-fps", "1e9"]].concat();
    let text = expect(path, 4, &out_of_reach);
    assert!(
        text.contains("no machine is found: of the nearest that was tried, "),
        "{text}"
    );
}

/// What the search over settings writes beside the configuration is honoured by every command.
#[test]
fn what_cost_finds_is_a_machine_for_every_command() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let small = ["--width", "16", "--scene", "garden"];
    let on = |command: &[&str]| expect(path, 0, &[command, &small].concat());
    let search = [
        "--config",
        "small",
        "cost",
        "--knobs",
        "stop",
        "--target-psnr",
        "25",
    ];
    on(&search);
    let found = fs::read_to_string(path.join("found.toml")).unwrap();
    assert!(found.contains("[render]"), "{found}");
    on(&["compare", "small", "found.toml"]);
    on(&["model", "--config", "found.toml", "--frames", "2"]);
    on(&["verify", "--config", "found.toml"]);
    let arguments = ["emit", "--config", "found.toml", "--out-dir", "rtl"];
    let text = expect(path, 0, &arguments);
    assert!(text.contains("emit does not use [render]"), "{text}");
    // The settings of rendering are those of the file.
    let drawn = |config: &str, report: &str| {
        let own = [
            "render", "--config", config, "--out", "p.png", "--json", report,
        ];
        on(&own);
        json(&path.join(report))["float"]["db"].as_f64()
    };
    assert_ne!(drawn("found.toml", "f.json"), drawn("small", "s.json"));
}

/// A search that was interrupted, and one with the same seed, try the same points.
#[test]
fn a_search_is_its_seed() {
    let folder = tempfile::tempdir().unwrap();
    let search = |out: &'static str, json: &'static str| {
        let arguments = [
            "explore",
            "small",
            "--width",
            "8",
            "--vary",
            "system.array_columns=8..32:+4",
            "--vary",
            "system.memory_channels=1,2,4,8",
            "--vary",
            "system.array_rows=8..32:+4",
            "--objective",
            "energy",
            "--max-area",
            "1.1",
            "--budget",
            "6",
            "--work-dir",
            out,
            "--json",
            json,
        ];
        expect(folder.path(), 0, &arguments)
    };
    let text = search("a", "a.json");
    assert!(
        text.contains("6 of 196 points, by Parzen estimators"),
        "{text}"
    );
    assert!(
        text.contains("by a random search of the same budget"),
        "{text}"
    );
    search("b", "b.json");
    search("a", "again.json");
    let bytes = |of: &str| fs::read(folder.path().join(of)).unwrap();
    assert!(bytes("a.json") == bytes("b.json") && bytes("a.json") == bytes("again.json"));
}

/// Points without figures are told by their reason, and a file of an earlier search for what it is.
#[test]
fn why_a_search_finds_nothing_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    fs::write(path.join("found.toml"), "preset = \"paper\"\n").unwrap();
    let search = |vary: &'static str| {
        let size = ["--width", "8", "--frames", "1", "--vary", vary];
        [&["explore", "paper"][..], &size].concat()
    };
    // A space in which no machine keeps the rules is refused before any work.
    let text = expect(path, 2, &search("vu.exp.form=piecewise"));
    assert!(text.contains("vu.exp.pipelined"), "{text}");
    let ports = ["--vary", "gu.ports=1,3", "--vary", "rit.entries=126,128"];
    let arguments = [
        &["explore", "paper", "--width", "8", "--frames", "1"][..],
        &ports,
    ]
    .concat();
    let text = expect(path, 4, &arguments);
    for part in [
        "no figures of 1 of 4 points",
        "rule `rit-entries`",
        "nothing that was tried is better than paper",
    ] {
        assert!(text.contains(part), "{part}: {text}");
    }
    let text = expect(path, 4, &search("rit.entries=256"));
    for part in [
        "no machine is found: of the nearest that was tried, its clock is a guess",
        "found.toml is of an earlier search",
    ] {
        assert!(text.contains(part), "{part}: {text}");
    }
    // What the model assumes is no choice of a machine.
    let text = expect(path, 4, &search("system.wire_margin=0.2"));
    assert!(
        text.contains("system.wire_margin is an assumption of the model"),
        "{text}"
    );
    // A field of [render] that no scene has is refused before any work, and so is the loss of the input.
    let text = expect(path, 2, &search("render.steps=0.5,1"));
    assert!(text.contains("steps"), "{text}");
    let own = ["explore", "found.toml", "--vary", "vu.lanes=2,4"];
    let text = expect(path, 2, &own);
    assert!(
        text.contains("--found found.toml would overwrite a file"),
        "{text}"
    );
    let text = expect(path, 4, &search("system.memory_channels=1"));
    assert!(text.contains("is better than paper"), "{text}");
    let kept = fs::read_to_string(path.join("found.toml")).unwrap();
    assert_eq!(kept, "preset = \"paper\"\n");
}

/// Knobs that no preset has, as many as the table can hold: its figures stay, and a clock that no block reaches
/// wins nothing.
#[test]
#[ignore = "slow; run with make test-full"]
fn a_search_over_many_knobs_keeps_its_figures() {
    let folder = tempfile::tempdir().unwrap();
    let vary = [
        "su.units=1,4",
        "su.lanes=1",
        "su.tiles=4",
        "rit.pairs=all,that-may-count",
        "vu.exp.pipelined=true",
        "vu.lanes=8,24",
        "vu.ops=[[\"exp\"], [\"square-sum\", \"exp\", \"multiply\"]]",
        "gu.pipelined=false,true",
        "system.array_rows=8,24",
        "clock=reached,2.0",
    ];
    let vary = vary.iter().flat_map(|own| ["--vary", own]);
    let search = [
        "explore",
        "paper",
        "--width",
        "16",
        "--frames",
        "1",
        "--budget",
        "40",
        "--max-area",
        "1.08",
    ];
    let text = expect(
        folder.path(),
        0,
        &search.into_iter().chain(vary).collect::<Vec<_>>(),
    );
    assert_narrow(&text);
    let front = text.split_once("front of fps, area and quality").unwrap().1;
    let header: Vec<&str> = front
        .lines()
        .skip(1)
        .take_while(|line| !line.contains("0."))
        .collect();
    assert!(header.concat().contains("psnr_db"), "{text}");
    assert!(
        text.contains("points is above the one that their slowest block reaches"),
        "{text}"
    );
    let found = fs::read_to_string(folder.path().join("found.toml")).unwrap();
    assert!(
        found.contains("[su]") && !found.contains("clock_ghz"),
        "{found}"
    );
}
