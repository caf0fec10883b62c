//! The page of `report`, from end to end.

use std::fs;
use std::path::Path;

use crate::common::{expect, json, potamoi, run, stderr};

const SECTIONS: [&str; 9] = [
    "verdict",
    "pictures",
    "proof",
    "time-energy",
    "accuracy",
    "effects",
    "hard-cases",
    "paper",
    "provenance",
];

/// The page of a configuration of few lanes and banks, whose models are built soon.
fn report(folder: &Path, out: &str) -> String {
    let few = "[gu]\nbanks = 8\n[vu]\nlanes = 4\n";
    fs::write(folder.join("few.toml"), few).unwrap();
    let arguments = [
        "report",
        "garden",
        "--config",
        "few.toml",
        "--width",
        "12",
        "--frames",
        "2",
        "--knobs",
        "iterations",
        "--out",
        out,
        "--json",
        "report.json",
    ];
    expect(folder, 0, &arguments);
    fs::read_to_string(folder.join(out)).unwrap()
}

/// Addresses that a browser would load.
fn loaded(text: &str) -> Vec<&str> {
    let marks = ["src=\"", "href=\"", "url(", "@import"];
    let all = marks.iter().flat_map(|mark| text.split(mark).skip(1));
    all.map(|rest| rest.split(['"', ')']).next().unwrap_or_default())
        .filter(|own| !own.starts_with('#') && !own.starts_with("data:"))
        .collect()
}

#[test]
fn a_page_has_all_sections_loads_nothing_and_is_the_same_again() {
    let folder = tempfile::tempdir().unwrap();
    let text = report(folder.path(), "one.html");
    for id in SECTIONS {
        assert!(text.contains(&format!("<section id=\"{id}\"")), "{id}");
    }
    // The libraries have addresses of namespaces in their texts.
    let (page, scripts) = text.split_once("<script").unwrap();
    assert_eq!(loaded(page), Vec::<&str>::new());
    assert!(!scripts.contains("<script src") && !scripts.contains("<link"));
    // Machines, time, energy, and accuracy beside the converged picture: garden has no truth.
    assert_eq!(page.matches("<svg").count(), 4);
    // The document in the page is the one that is written.
    let (_, own) = text.split_once("id=\"document\">").unwrap();
    let (own, _) = own.split_once("</script>").unwrap();
    let own: serde_json::Value = serde_json::from_str(own).unwrap();
    assert_eq!(own, json(&folder.path().join("report.json")));
    let machine = &own["scenes"][0]["machines"][0];
    let share = &machine["more"]["proof"]["units"][0]["share"];
    assert!(
        share.as_f64().unwrap() > 0.0 && machine["figures"]["clock_ghz"].as_f64().unwrap() > 0.0
    );
    assert_eq!(report(folder.path(), "two.html"), text);
}

#[test]
fn what_is_not_asked_for_rightly_is_refused_before_any_work() {
    let folder = tempfile::tempdir().unwrap();
    let say = |arguments: &[&str]| {
        let done = run(folder.path(), arguments);
        assert_eq!(done.status.code(), Some(2));
        stderr(&done)
    };
    assert!(say(&["report", "garden", "--out", "page.png"]).contains("ends in .html"));
    let twice = [
        "report",
        "garden",
        "--config",
        "paper",
        "--config",
        "paper",
        "--out",
        "page.html",
    ];
    assert!(say(&twice).contains("named twice"));
    assert!(!folder.path().join("page.html").exists());
}

/// Without Verilator the page is made, and says at each place that nothing was verified.
#[test]
fn what_was_not_verified_is_said() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let words = "report garden --width 8 --frames 2 --knobs iterations --out p.html --json r.json";
    let done = potamoi()
        .env_clear()
        .env("PATH", at)
        .env("HOME", at)
        .current_dir(at)
        .args(words.split(' '))
        .output()
        .unwrap();
    assert!(done.status.success(), "{}", stderr(&done));
    let note = "note: garden was not verified on default: verilator was not found";
    assert!(stderr(&done).contains(note), "{}", stderr(&done));
    let report = json(&at.join("r.json"));
    let origins = report["provenance"].as_array().unwrap();
    let verified = origins
        .iter()
        .find(|own| own["figure"] == "what was verified")
        .unwrap();
    assert_eq!(verified["origin"], "-");
    let how = verified["how"].as_str().unwrap();
    assert!(how.starts_with("nothing: verilator was not found"), "{how}");
}
