//! `potamoi effects` and what follows it, from end to end.

use std::fs;
use std::path::Path;

use crate::common::{expect, json};
use serde_json::Value;

const NAMES: [&str; 14] = [
    "trilinear",
    "exponential",
    "spherical_harmonics",
    "view_mlp",
    "hash_levels",
    "segments",
    "sorting",
    "early_termination",
    "warping",
    "disocclusion",
    "void_test",
    "octree_merging",
    "remote_link",
    "random_dram",
];

fn effects(folder: &Path, scene: &str, more: &[&str]) -> Value {
    let arguments = ["effects", "--scene", scene, "--width", "24"];
    let arguments = [&arguments, more, &["--json", "e.json"]].concat();
    expect(folder, 0, &arguments);
    json(&folder.join("e.json"))
}

/// Of an effect, of harmonics those of degree 1.
fn of<'a>(report: &'a Value, name: &str) -> &'a Value {
    let all = report["effects"].as_array().unwrap();
    all.iter().find(|effect| effect["name"] == name).unwrap()
}

fn calls(report: &Value, name: &str) -> bool {
    of(report, name)["called_for"].as_bool().unwrap()
}

#[test]
fn every_effect_has_evidence_a_cost_and_a_saving() {
    let folder = tempfile::tempdir().unwrap();
    let more = ["--force", "all"];
    let report = effects(folder.path(), "cairn:voxels", &more);
    assert_eq!(report["format_version"], 2);
    for name in NAMES {
        let effect = of(&report, name);
        assert!(!effect["evidence"].as_str().unwrap().is_empty(), "{effect}");
        assert!(effect["cost"]["unit"].is_string(), "{effect}");
        let saved = &effect["saving"]["wall_ms"];
        match effect["called_for"].as_bool().unwrap() {
            true => assert_eq!(saved, 0.0, "{effect}"),
            false => assert!(saved.is_null() || saved.is_number(), "{effect}"),
        }
    }
    // Hardware that no camera needs is priced, and other effects say where they are done.
    for effect in report["effects"].as_array().unwrap() {
        let hardware = &effect["saving"]["hardware"];
        assert_eq!(hardware.is_null(), effect["called_for"] == true, "{effect}");
        for figure in ["area_mm2", "cycles", "energy_uj"].map(|of| &hardware[of]) {
            if hardware.is_object() {
                assert!(!figure["origin"].as_str().unwrap().is_empty(), "{effect}");
                let value = &figure["value"];
                assert!(
                    value.is_null() || value.as_f64().unwrap() >= 0.0,
                    "{effect}"
                );
            }
        }
    }
    // What there is nothing of to simulate saves nothing.
    for name in ["view_mlp", "hash_levels", "remote_link"] {
        let effect = of(&report, name);
        assert_eq!(effect["saving"]["wall_ms"], 0.0, "{effect}");
        assert_eq!(effect["cost"]["wall_ms"], 0.0, "{effect}");
    }
    // Opaque and diffuse: no harmonics, no perceptron.
    for name in ["spherical_harmonics", "view_mlp", "hash_levels", "sorting"] {
        assert!(!calls(&report, name), "{name}");
    }
    for name in ["trilinear", "exponential", "void_test", "early_termination"] {
        assert!(calls(&report, name), "{name}");
        let cycles = &of(&report, name)["cost"]["cycles"];
        assert!(cycles.is_null() || cycles.as_u64().unwrap() > 100, "{name}");
    }
    let forced = &report["forced"];
    for same in ["same_image", "same_trace", "same_cycles"] {
        assert_eq!(forced[same], true, "{forced}");
    }
}

#[test]
fn a_still_camera_costs_no_warping_and_splats_need_no_reducer() {
    let folder = tempfile::tempdir().unwrap();
    let still = effects(folder.path(), "garden", &["--still"]);
    assert!(!calls(&still, "warping") && !calls(&still, "disocclusion"));
    let evidence = &of(&still, "warping")["evidence"];
    assert_eq!(evidence, "the camera does not move in 3 frames");
    let moved = effects(folder.path(), "garden", &[]);
    assert!(calls(&moved, "warping") && calls(&moved, "disocclusion"));
    assert!(!calls(&moved, "trilinear"));
    let unit = &moved["units"][0];
    assert_eq!(unit["unit"], "gathering_unit");
    let left_out = unit["left_out"].as_array().unwrap();
    let modes = left_out.iter().find(|part| part["field"] == "gu.modes");
    assert_eq!(modes.unwrap()["left"], "unstructured");
}

/// Wall times are of pairs, and are printed; what they are depends on the machine.
#[test]
fn wall_times_are_of_pairs() {
    let folder = tempfile::tempdir().unwrap();
    let arguments = [
        "effects", "--scene", "garden", "--width", "16", "--pairs", "2",
    ];
    let said = expect(
        folder.path(),
        0,
        &[&arguments[..], &["--json", "e.json"]].concat(),
    );
    assert!(said.contains("medians of 2 interleaved pairs"), "{said}");
    let report = json(&folder.path().join("e.json"));
    for name in [
        "trilinear",
        "sorting",
        "octree_merging",
        "warping",
        "disocclusion",
    ] {
        let cost = &of(&report, name)["cost"];
        assert!(cost["wall"]["with_ms"].as_f64().unwrap() > 0.0, "{cost}");
        assert!(cost["wall"]["spread_ms"].as_f64().unwrap() >= 0.0, "{cost}");
        assert!(cost["wall_ms"].is_number(), "{cost}");
    }
    let left = of(&report, "disocclusion")["cost"]["amount"].as_u64();
    assert!(left.is_some_and(|n| 0 < n && n < 2 * 16 * 16), "{left:?}");
}

#[test]
fn what_is_missed_is_measured() {
    let folder = tempfile::tempdir().unwrap();
    let without = |scene: &str, effect: &str| {
        let report = effects(folder.path(), scene, &["--without", effect]);
        report["without"][0].clone()
    };
    for (scene, effect) in [
        ("garden", "exponential"),
        ("garden", "sorting"),
        ("garden", "spherical_harmonics:1"),
        ("lantern", "trilinear"),
        ("lantern", "early_termination"),
        ("lantern", "warping"),
        ("lantern", "disocclusion"),
    ] {
        let found = without(scene, effect);
        assert_eq!(found["called_for"], true, "{scene}: {found}");
        let psnr = found["psnr_db"].as_f64().unwrap();
        assert!((1.0..120.0).contains(&psnr), "{scene}: {found}");
        assert!(found["pixels_changed"].as_u64().unwrap() > 5, "{found}");
    }
    // What takes cycles, but no pixel.
    let found = without("lantern", "void_test");
    assert!(found["psnr_db"].is_null() && found["pixels_changed"] == 0);
    assert!(found["cycles_more"].as_i64().unwrap() > 10_000, "{found}");
    // What is not called for is missed by nobody.
    let found = without("lantern", "spherical_harmonics:3");
    assert_eq!(found["called_for"], false);
    assert!(found["psnr_db"].is_null() && found["cycles_more"] == 0);
}

#[test]
fn verilog_for_a_scene_is_verified_on_it() {
    verilog_is_verified("garden", false);
}

#[test]
#[ignore = "slow; run with make test-full"]
fn verilog_with_reducers_is_verified_on_its_scene() {
    verilog_is_verified("lantern", true);
}

/// Verilog for a scene has reducers where the scene interpolates.
fn verilog_is_verified(scene: &str, reducers: bool) {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let emit = [
        "--config",
        "paper",
        "emit",
        "--out",
        "rtl",
        "--for-scene",
        scene,
    ];
    let said = expect(at, 0, &[&emit[..], &["--json", "e.json"]].concat());
    assert!(said.contains("gu.modes"), "{said}");
    let report = json(&at.join("e.json"));
    assert_eq!(report["for_scene"], scene);
    let files = report["files"].as_object().unwrap();
    let has_reducers = files.keys().any(|file| file.contains("reducer"));
    assert_eq!(has_reducers, reducers, "{files:?}");
    // Nor does the table carry weights that nothing multiplies.
    let table = fs::read_to_string(at.join("rtl/gathering_unit/rit_buffer.v")).unwrap();
    assert_eq!(table.contains("p_weight"), reducers);
    let verify = [
        "--config",
        "rtl/configuration.toml",
        "verify",
        "--scene",
        scene,
        "--width",
        "8",
        "--engine",
        "interpreter",
    ];
    let said = expect(at, 0, &verify);
    assert!(said.contains("no mismatch in any bit or cycle"), "{said}");
    // The same configuration, the same Verilog.
    let again = [
        "--config",
        "rtl/configuration.toml",
        "emit",
        "--out",
        "again",
    ];
    expect(at, 0, &again);
    for file in files.keys() {
        let [a, b] = ["rtl", "again"].map(|f| std::fs::read(at.join(f).join(file)).unwrap());
        assert!(a == b, "{file}");
    }
}

#[test]
fn forcing_changes_no_file_and_leaving_out_does() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    for scene in ["garden", "chrome:voxels"] {
        let render = |more: &[&str], name: &str| {
            let arguments = ["render", "--scene", scene, "--width", "16", "--out", name];
            expect(at, 0, &[&arguments, more].concat());
            std::fs::read(at.join(name)).unwrap()
        };
        let trace = |more: &[&str], name: &str| {
            let arguments = ["trace", "--scene", scene, "--width", "16", "--out", name];
            expect(at, 0, &[&arguments, more].concat());
            std::fs::read(at.join(name)).unwrap()
        };
        let plain = render(&[], "p.png");
        assert!(plain == render(&["--force", "all"], "f.png"), "{scene}");
        let harmonics = ["--without", "spherical_harmonics"];
        assert!(plain != render(&harmonics, "w.png"), "{scene}");
        let kept = trace(&[], "p.npz");
        assert!(kept == trace(&["--force", "all"], "f.npz"), "{scene}");
    }
}

/// A picture that leaves something out is compared with one that does not, and says so.
#[test]
fn what_is_left_out_is_seen_and_said() {
    let folder = tempfile::tempdir().unwrap();
    let report = effects(folder.path(), "garden", &["--without", "sorting"]);
    let error = report["without"][0]["psnr_db"].as_f64().unwrap();
    for numerics in ["fixed", "float"] {
        let arguments = [
            "render",
            "--scene",
            "garden",
            "--width",
            "24",
            "--out",
            "x.png",
            "--json",
            "x.json",
            "--numerics",
            numerics,
            "--without",
            "sorting",
        ];
        let said = expect(folder.path(), 0, &arguments);
        assert!(said.contains("leaving out sorting"), "{said}");
        let found = json(&folder.path().join("x.json"));
        let own = found["float"]["db"].as_f64().unwrap();
        assert!((own - error).abs() < 0.5, "{numerics}: {own}, {error}");
        assert!(
            found["not_checked"]
                .to_string()
                .contains("leaving out sorting")
        );
    }
}
