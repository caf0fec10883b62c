//! The system on hard scenes and hard paths: every variant ends, and no time, energy or count is
//! below zero or no number.

use std::path::Path;
use std::process::{Output, Stdio};
use std::time::{Duration, Instant};

use serde_json::Value;

use super::scenes::{cameras, write};
use crate::common::{json, potamoi, stderr, stdout};
use potamoi_analysis::hard_cases::pictures::all;

/// Far longer than any of these takes, and shorter than for ever.
const PATIENCE: Duration = Duration::from_secs(300);

/// Runs, but not for ever.
fn model(folder: &Path, arguments: &[&str]) -> Output {
    let mut child = potamoi()
        .current_dir(folder)
        .env("POTAMOI_CACHE", folder.join("cache"))
        .arg("model")
        .args(arguments)
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let start = Instant::now();
    while child.try_wait().unwrap().is_none() {
        if start.elapsed() > PATIENCE {
            child.kill().unwrap();
            panic!(
                "potamoi model {}: no end after {PATIENCE:?}",
                arguments.join(" ")
            );
        }
        std::thread::sleep(Duration::from_millis(20));
    }
    child.wait_with_output().unwrap()
}

/// Every number of a report is 0 or more; one that is none would be written as null.
pub(crate) fn sound(value: &Value, path: &str) -> u32 {
    match value {
        Value::Number(n) => {
            let n = n.as_f64().unwrap();
            assert!(n >= 0.0 && n.is_finite(), "{path} is {n}");
            1
        }
        Value::Array(all) => {
            let each = all
                .iter()
                .enumerate()
                .map(|(i, v)| sound(v, &format!("{path}/{i}")));
            each.sum()
        }
        Value::Object(all) => all
            .iter()
            .map(|(k, v)| sound(v, &format!("{path}/{k}")))
            .sum(),
        Value::Null => panic!("{path} is no number"),
        _ => 0,
    }
}

/// Models with samples along rays, seen from within: rays along axes, samples on faces, and, of
/// Instant-NGP, corners that share an entry.
const WITHIN: [&str; 2] = ["lantern", "cairn:ngp"];
/// Further ones, in `make test-full`: fog, and a model whose truth is known.
const FURTHER_WITHIN: [&str; 2] = ["mist", "cairn:voxels"];

/// Of a hard scene from a path of cameras, every variant at home and afar; of models with samples,
/// too.
fn frames(poses: &[([f64; 3], f64)], only: impl Fn(&str) -> bool, within: &[&str]) {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let chosen: Vec<_> = all().into_iter().filter(|s| only(s.name)).collect();
    assert!(!chosen.is_empty());
    let mut names = vec![];
    for scene in &chosen {
        write(scene, at, &cameras(poses));
        names.push(format!("{}.toml", scene.name));
    }
    for (i, model) in within.iter().enumerate() {
        std::fs::write(at.join("within.json"), cameras(poses)).unwrap();
        let name = format!("within-{i}.toml");
        let (scene, representation) = model.split_once(':').unwrap_or((model, ""));
        let representation = match representation {
            "" => String::new(),
            own => format!("representation = \"{own}\"\n"),
        };
        let text = format!(
            "[model]\nkind = \"builtin\"\nname = \"{scene}\"\n{representation}\
             [camera]\nkind = \"opencv-json\"\npath = \"within.json\"\nindex = 0\n"
        );
        std::fs::write(at.join(&name), text).unwrap();
        names.push(name);
    }
    let count = poses.len().to_string();
    let arguments = [
        "--scenes",
        &names.join(","),
        "--frames",
        &count,
        "--window",
        "2",
        "--scenario",
        "both",
        "--phi",
        "4",
        "--json",
        "r.json",
    ];
    let output = model(at, &arguments);
    let said = stdout(&output) + &stderr(&output);
    assert_eq!(output.status.code(), Some(0), "{said}");
    assert!(!said.contains("NaN") && !said.contains("inf "), "{said}");
    let report = json(&at.join("r.json"));
    let scenes = report["scenes"].as_array().unwrap();
    assert_eq!(scenes.len(), names.len());
    for (scene, found) in names.iter().zip(scenes) {
        for outcome in found["outcomes"].as_array().unwrap() {
            for bound in ["max", "sum"] {
                let name = format!("{scene} {} {bound}", outcome["variant"]["name"]);
                let run = &outcome["run"][bound];
                for field in ["span_ns", "frames_per_second", "free_units_ns"] {
                    let value = run[field].as_f64();
                    assert!(value.is_some_and(|v| v > 0.0), "{name}: {field} {value:?}");
                }
                assert!(sound(&run["energy"], &name) >= 9, "{name}");
                assert!(sound(&run["stages"], &name) > 2, "{name}");
                assert!(sound(&run["utilisation"], &name) > 0, "{name}");
                assert!(sound(&run["demand"], &name) > 0, "{name}");
                assert!(sound(&run["spent"], &name) > 20, "{name}");
            }
        }
        assert!(found["outcomes"].as_array().unwrap().len() >= 12);
        assert!(sound(&found["gpu_only"]["fused"], scene) >= 2, "{scene}");
    }
}

const STILL: ([f64; 3], f64) = ([0.0; 3], 0.0);

/// A step aside, a step back, and standing still.
#[test]
fn every_hard_scene_is_modelled() {
    frames(
        &[STILL, ([0.05, 0.0, 0.0], 1.0), STILL, STILL],
        |_| true,
        &[],
    );
}

/// All hard paths on one scene and within a model; the turns within another, too.
#[test]
fn hard_paths_are_modelled() {
    let chosen = |name: &str| name == "near" || name == "none-and-all";
    let [still, turns, away] = PATHS;
    paths(&[still, away], chosen, &WITHIN[..1]);
    paths(&[turns], chosen, &WITHIN);
}

#[test]
#[ignore = "exhaustive; run with make test-full"]
fn hard_paths_through_further_models_are_modelled() {
    paths(&PATHS, |name| name == "near", &FURTHER_WITHIN);
    paths(&PATHS, |name| name == "near", &WITHIN[1..]);
}

const AWAY: ([f64; 3], f64) = ([1e6, -1e6, 1e6], 90.0);

const fn turned(angle: f64) -> ([f64; 3], f64) {
    ([0.0; 3], angle)
}

/// Six equal poses, half turns, a whole one, and a place from which nothing is seen.
const PATHS: [&[([f64; 3], f64)]; 3] = [
    &[STILL; 6],
    &[
        STILL,
        turned(180.0),
        STILL,
        turned(179.999_999),
        turned(-180.0),
        turned(360.0),
    ],
    &[AWAY, STILL, AWAY, ([0.0, 0.0, 3.0], 0.0), STILL],
];

fn paths(paths: &[&[([f64; 3], f64)]], only: impl Fn(&str) -> bool, within: &[&str]) {
    for path in paths {
        frames(path, &only, within);
    }
}
