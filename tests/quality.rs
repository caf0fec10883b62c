//! Pictures that quality is measured against, and PSNR wherever it is asked.

use std::path::Path;

use crate::common::{json, potamoi, stderr};
use crate::cost::{cost, number, point};
use serde_json::Value;

/// A setting finer than the default is better than it, and what nobody sees makes no knee.
#[test]
fn finer_is_better_and_the_invisible_has_no_knee() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let run = |knobs: &str| {
        let asked = format!("--scene lantern --width 24 --knobs {knobs} --json c.json");
        let said = cost(at, 0, &asked.split(' ').collect::<Vec<_>>());
        (said, json(&at.join("c.json")))
    };
    let (said, report) = run("step");
    let db = |knob, setting| number(&point(&report, knob, setting)["converged"], "db");
    assert!(db("step", "0.25") > db("default", "") + 6.0, "{report}");
    assert!(db("step", "0.75") < db("default", "") - 2.0, "{report}");
    let steps = &report["reference"]["converged"]["steps"];
    assert!(number(steps, "change") < number(steps, "bound"), "{steps}");
    assert!(said.contains("no early termination, steps of 1/"), "{said}");
    let (said, report) = run("constant-bits");
    assert!(report["knee"].is_null(), "{report}");
    assert!(!said.contains("the knee of the front"), "{said}");
}

/// The report of a command that runs in a folder.
fn report_of(at: &Path, command: &str) -> Value {
    let output = potamoi()
        .current_dir(at)
        .args(command.split(' '))
        .output()
        .unwrap();
    assert!(output.status.success(), "{command}: {}", stderr(&output));
    json(&at.join(command.split(' ').next_back().unwrap()))
}

/// A PSNR has one value for one machine: `render` has those of `cost` for the default, for another
/// configuration and for another rendering. What `model` has is of other pictures, under other names.
#[test]
fn one_machine_has_one_psnr() {
    psnr_is_the_same("lantern", "converged", "name = \"lantern\"");
}

#[test]
#[ignore = "slow; run with make test-full"]
fn one_machine_has_one_psnr_beside_the_truth() {
    let model = "name = \"cairn\"\nrepresentation = \"voxels\"";
    psnr_is_the_same("cairn:voxels", "truth", model);
}

/// All commands give one figure for a machine on a scene, beside each reference.
fn psnr_is_the_same(scene: &str, kind: &str, model: &str) {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    std::fs::write(at.join("8.toml"), "[vu.exp]\niterations = 8\n").unwrap();
    let qualities = ["truth", "converged", "float"];
    let size = format!("--scene {scene} --width 14");
    let of_cost = report_of(
        at,
        &format!("cost {size} --knobs iterations,step --json c.json"),
    );
    assert_eq!(of_cost["reference"]["kind"], kind);
    let shown = "--quality --out a.png --json r.json";
    let rendered = report_of(at, &format!("render {size} {shown}"));
    assert_eq!(rendered["reference"], of_cost["reference"], "{scene}");
    let other = report_of(at, &format!("--config 8.toml render {size} {shown}"));
    for (own, point) in [
        (&rendered, point(&of_cost, "default", "")),
        (&other, point(&of_cost, "iterations", "8")),
    ] {
        for quality in qualities {
            assert_eq!(own[quality], point[quality], "{scene} {quality}");
        }
        assert!(number(&own["converged"], "db") > 20.0, "{own}");
        assert_eq!(own["truth"].is_null(), kind == "converged");
    }

    // In floating point another step is another picture, with an error of the formats of its own.
    let description = format!("[model]\nkind = \"builtin\"\n{model}\n[render]\nstep = 0.25\n");
    std::fs::write(at.join("finer.toml"), description).unwrap();
    let finer = report_of(at, &format!("render --scene finer.toml --width 14 {shown}"));
    let of_step = point(&of_cost, "step", "0.25");
    for quality in ["truth", "converged"] {
        assert_eq!(finer[quality], of_step[quality], "{scene} {quality}");
    }
    assert!(of_step["float"].is_null() && number(&finer["float"], "db") > 60.0);

    // Frames of a path are in floating point, and named so.
    let modelled = report_of(
        at,
        &format!("model {size} --frames 1 --variants baseline --json m.json"),
    );
    let outcome = &modelled["scenes"][0]["outcomes"][0];
    assert!(qualities.iter().all(|own| outcome[*own].is_null()));
    let quality = &outcome["float_quality"];
    assert!(quality["full_db"].is_null(), "{quality}");
    let float = report_of(at, &format!("render {size} --numerics float {shown}"));
    assert_eq!(quality["truth_db"], float["truth"]["db"], "{scene}");
    assert!(float["float"].is_null());
}
