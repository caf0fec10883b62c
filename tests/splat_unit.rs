//! The splat unit as a user gets it: emitted with a configuration that has one, linted and simulated; and
//! what is said where there is none.

use std::path::Path;
use std::process::{Command, Output};

use crate::rtl_out::lints;

/// Configurations with a splat unit: one pipelined lane, and lanes of the paper's exponential.
const CONFIGURATIONS: [&str; 2] = [
    "[vu.exp]\npipelined = true\n[su]\nlanes = 1\ntiles = 4\n",
    "[su]\nlanes = 5\ntiles = 2\n",
];

fn potamoi(config: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_potamoi"))
        .arg("--config")
        .arg(config)
        .args(arguments)
        .output()
        .unwrap()
}

fn written(folder: &Path, text: &str) -> std::path::PathBuf {
    let path = folder.join("config.toml");
    std::fs::write(&path, text).unwrap();
    path
}

#[test]
fn the_emitted_splat_unit_lints_and_its_bench_passes() {
    benches_pass(&CONFIGURATIONS[..1], "60:3", &["CHECKS=1"]);
}

#[test]
#[ignore = "exhaustive; run with make test-full"]
fn emitted_splat_units_lint_and_their_benches_pass() {
    benches_pass(&CONFIGURATIONS, "0:1 60:3", &["CHECKS=", "CHECKS=1"]);
}

/// Benches of configurations, in runs of gaps and seeds, and in modes.
fn benches_pass(configurations: &[&str], runs: &str, modes: &[&str]) {
    for text in configurations {
        let folder = tempfile::tempdir().unwrap();
        let config = written(folder.path(), text);
        let out = folder.path().join("rtl");
        let done = potamoi(
            &config,
            &["emit", "--unit", "su", "--out-dir", out.to_str().unwrap()],
        );
        assert!(done.status.success(), "{done:?}");
        lints(&out);
        for more in modes {
            let done = Command::new("make")
                .arg("-C")
                .arg(out.join("sim"))
                .args([&format!("RUNS={runs}"), *more])
                .output()
                .unwrap();
            let said = String::from_utf8([done.stdout, done.stderr].concat()).unwrap();
            assert!(done.status.success(), "{said}");
            let passed = said.matches("PASS: splat_unit").count();
            assert_eq!(passed, runs.split(' ').count(), "{said}");
        }
    }
}

#[test]
fn configurations_without_a_splat_unit_or_with_a_wrong_one_are_refused_by_name() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("rtl");
    let out = out.to_str().unwrap();
    let emit = ["emit", "--unit", "su", "--out-dir", out];
    for (text, named) in [
        ("", "no splat unit: add a table [su]"),
        ("[su]\ntiles = 12\n", "su.tiles"),
        ("[su]\nlanes = 0\n", "su.lanes"),
        ("[su]\nlanez = 1\n", "lanez"),
        (
            "[vu.exp]\noutput = \"general\"\n[su]\n",
            "vu.exp.output = general; expected \"alpha\"",
        ),
    ] {
        let config = written(folder.path(), text);
        let done = potamoi(&config, &emit);
        let said = String::from_utf8_lossy(&done.stderr);
        assert!(
            !done.status.success() && said.contains(named),
            "{text}: {said}"
        );
    }
    assert!(!Path::new(out).exists());
}

/// The preset for splats alone has the paper's picture, and refuses a scene whose operations it lacks.
#[test]
fn the_picture_of_lean_splats_is_that_of_paper() {
    let folder = tempfile::tempdir().unwrap();
    let pictures = ["paper", "lean-splats"].map(|preset| {
        let picture = folder.path().join(format!("{preset}.png"));
        let mut arguments = "render --scene garden --width 64 --numerics fixed --out".split(' ');
        let arguments: Vec<_> = arguments.by_ref().chain(picture.to_str()).collect();
        let done = potamoi(Path::new(preset), &arguments);
        assert!(done.status.success(), "{done:?}");
        std::fs::read(&picture).unwrap()
    });
    assert!(pictures[0] == pictures[1], "the pictures differ");
    for (scene, named) in [
        ("lantern", "voxels need \"relu\""),
        ("cairn:ngp", "--config fields"),
    ] {
        let arguments = format!("render --scene {scene} --numerics fixed --out no.png");
        let arguments: Vec<_> = arguments.split(' ').collect();
        let done = potamoi(Path::new("lean-splats"), &arguments);
        let said = String::from_utf8_lossy(&done.stderr);
        assert!(
            !done.status.success() && said.contains(named),
            "{scene}: {said}"
        );
    }
}

#[test]
fn characterise_tells_the_cycles_of_the_splat_unit() {
    let folder = tempfile::tempdir().unwrap();
    let config = written(folder.path(), CONFIGURATIONS[0]);
    let report = folder.path().join("c.json");
    let to = report.to_str().unwrap();
    let done = potamoi(
        &config,
        &[
            "characterise",
            "--scene",
            "garden",
            "--width",
            "64",
            "--height",
            "64",
            "--json",
            to,
        ],
    );
    let said = String::from_utf8_lossy(&done.stdout);
    assert!(done.status.success(), "{done:?}");
    assert!(
        said.contains("splat unit, one lane, 4 tiles in flight"),
        "{said}"
    );
    let report: serde_json::Value =
        serde_json::from_slice(&std::fs::read(&report).unwrap()).unwrap();
    let (unit, pairs) = (&report["splat_unit"], &report["pairs"]);
    for field in ["drawn", "stopped"] {
        assert_eq!(unit["counters"][field], pairs[field], "{report}");
    }
    let count = |value: &serde_json::Value| value.as_u64().unwrap();
    let kept = count(&unit["counters"]["exponentials"]);
    assert!(kept >= count(&pairs["kept"]) && kept <= count(&pairs["kept"]) * 11 / 10);
    assert!(count(&unit["cycles"]) > kept);
}
