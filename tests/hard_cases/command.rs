//! `potamoi hard-cases`, from end to end: cases that hold, that fail, and that do not apply; a user's
//! scene; reports and the contact sheet.

use std::fs;
use std::path::Path;

use potamoi_analysis::hard_cases::pictures::{Gaussian, HardScene, all};
use serde_json::Value;

use super::scenes::{cameras, write};
use crate::common::{expect, json, run, stderr, stdout};

fn named<'a>(list: &'a Value, name: &str) -> &'a Value {
    let all = list.as_array().unwrap();
    all.iter().find(|own| own["name"] == name).unwrap()
}

#[test]
fn every_case_of_the_paper_s_configuration_holds_or_says_why_it_does_not_apply() {
    let folder = tempfile::tempdir().unwrap();
    let outputs = ["--json", "h.json", "--csv", "h.csv", "--picture", "h.png"];
    let text = expect(folder.path(), 0, &[&["hard-cases"][..], &outputs].concat());
    assert!(text.starts_with("pass: all "), "{text}");
    let wide = text.lines().filter(|line| line.chars().count() > 100);
    assert_eq!(wide.collect::<Vec<_>>(), Vec::<&str>::new());
    let report = json(&folder.path().join("h.json"));
    assert_eq!(report["format_version"], 1);
    let cases = report["cases"].as_array().unwrap();
    let mut measured = 0;
    for case in cases {
        match case["state"].as_str().unwrap() {
            "measured" => {
                measured += 1;
                assert_eq!(case["passes"], true, "{case}");
                assert_eq!(case["is_hard"], true, "{case}");
                assert!(!case["derivation"].as_str().unwrap().is_empty(), "{case}");
            }
            "does-not-apply" => assert!(case["reason"].as_str().unwrap().len() > 10, "{case}"),
            other => panic!("{other}: {case}"),
        }
    }
    assert!(measured > 30, "{measured} of {}", cases.len());
    // A splat unit and untrusted weights are what this configuration does not have.
    let absent = named(&report["cases"], "needles along a row");
    assert!(
        absent["reason"].as_str().unwrap().contains("[su]"),
        "{absent}"
    );
    let shown = report["pictures"].as_array().unwrap().len();
    assert_eq!(shown, all().len());
    let csv = fs::read_to_string(folder.path().join("h.csv")).unwrap();
    assert_eq!(csv.lines().count(), 1 + cases.len() + shown, "{csv}");
    let sheet = image::open(folder.path().join("h.png")).unwrap();
    assert!(sheet.width() > 1000 && sheet.height() > 1000);
}

/// The form as the paper prints it, which is wrong below zero.
#[test]
fn a_configuration_whose_exponential_is_wrong_fails_with_its_name() {
    let folder = tempfile::tempdir().unwrap();
    let text = "[vu]\nops = [\"exp\"]\n[vu.exp]\nform = \"literal\"\ninput = \"S0.15\"\noutput_bits = 14\n";
    fs::write(folder.path().join("literal.toml"), text).unwrap();
    let done = run(folder.path(), &["hard-cases", "--config", "literal.toml"]);
    assert_eq!(done.status.code(), Some(1), "{}", stderr(&done));
    let [said, told] = [stdout(&done), stderr(&done)];
    assert!(said.contains("FAIL  exp of a negative power"), "{said}");
    assert!(told.contains("exp of a negative power"), "{told}");
}

fn on_scene(at: &Path, scene: &HardScene) -> (Option<i32>, Value) {
    let path = write(scene, at, &cameras(&[([0.0; 3], 0.0)]));
    let own = [
        "hard-cases",
        "--scene",
        path.to_str().unwrap(),
        "--width",
        "33",
        "--json",
        "s.json",
    ];
    let done = run(at, &own);
    let report = json(&at.join("s.json"));
    (done.status.code(), report["scene"]["checks"].clone())
}

#[test]
fn a_scene_s_own_gaussians_are_checked() {
    let folder = tempfile::tempdir().unwrap();
    let mut scenes = all();
    let mut near = scenes.remove(scenes.iter().position(|own| own.name == "near").unwrap());
    let (code, checks) = on_scene(folder.path(), &near);
    assert_eq!(code, Some(0), "{checks}");
    let culled = named(&checks, "Gaussians at and behind the camera");
    assert!(
        !culled["evidence"].as_str().unwrap().starts_with("0 of"),
        "{culled}"
    );
    assert!(
        culled["naive"].as_str().unwrap().contains("mirrored"),
        "{culled}"
    );
    for check in checks.as_array().unwrap() {
        assert_eq!(check["state"], "passes", "{check}");
    }
    // Colours of which a record's format holds less.
    near.gaussians.push(Gaussian {
        mean: [0.0, 0.0, 3.0],
        log_scale: [-1.0; 3],
        rotation: [1.0, 0.0, 0.0, 0.0],
        logit: 2.0,
        colour: [90.0, 0.0, 0.0],
    });
    let (code, checks) = on_scene(folder.path(), &near);
    assert_eq!(code, Some(1), "{checks}");
    let held = named(&checks, "values past the end of a record's formats");
    assert_eq!(held["state"], "fails", "{held}");
    assert!(
        held["evidence"].as_str().unwrap().starts_with("1 colour"),
        "{held}"
    );
}

/// The verdict names the configuration as it was given, or as the scene needs it.
#[test]
fn the_configuration_is_named_as_it_was_given() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("mine.toml"), "[vu]\nlanes = 12\n").unwrap();
    let verdict = |arguments: &[&str]| {
        let all = [&["hard-cases"][..], arguments].concat();
        let text = expect(folder.path(), 0, &all);
        text.lines().next().unwrap().to_owned()
    };
    let own = verdict(&["--config", "mine.toml"]);
    assert!(own.contains("with configuration mine.toml ("), "{own}");
    let switched = verdict(&["--scene", "cairn:dvgo", "--width", "8"]);
    let said = "with configuration fields, which scene cairn:dvgo needs";
    assert!(switched.contains(said), "{switched}");
}

#[test]
fn options_that_nothing_uses_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let said = |arguments: &[&str]| {
        let done = run(folder.path(), arguments);
        assert_eq!(done.status.code(), Some(2));
        stderr(&done)
    };
    let told = said(&["hard-cases", "--width", "32"]);
    assert!(told.contains("--width: expected with --scene"), "{told}");
    let twelve = "[gu]\nfeature_bits = 12\n";
    fs::write(folder.path().join("twelve.toml"), twelve).unwrap();
    let drawn = [
        "hard-cases",
        "--config",
        "twelve.toml",
        "--picture",
        "a.png",
    ];
    assert!(said(&drawn).contains("--picture a.png: there is nothing to draw"));
    assert_eq!(stdout(&run(folder.path(), &drawn)), "");
    assert!(said(&["hard-cases", "--picture", "a.svg"]).contains(".png"));
    assert!(said(&["hard-cases", "--scene", "gardn"]).contains("did you mean `garden`?"));
}
