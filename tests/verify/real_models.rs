//! Trained models of real scenes, where the shared data are at hand.

use crate::common::{self, expect, json};

/// A trained DirectVoxGO model of a real scene: a share of a small frame.
#[test]
fn a_trained_field_agrees_on_a_share() {
    trained_field("quick", "40");
}

/// The same at 200 x 200: every gather and every vector operation.
#[test]
#[ignore = "exhaustive; run with make test-full"]
fn a_trained_field_agrees_in_every_gather() {
    trained_field("full", "200");
}

/// Its gathers in the organisation that the paper argues against.
#[test]
#[ignore = "exhaustive; run with make test-full"]
fn a_trained_field_agrees_in_banks_of_whole_vectors() {
    let Some(data) = common::shared() else {
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR"));
    let fields = std::fs::read_to_string(root.join("configs/fields.toml")).unwrap();
    let gu = "[gu]\norganisation = \"feature-major\"\nbanks = 16\nlanes = 16\n";
    let config = folder.path().join("lanes.toml");
    std::fs::write(&config, format!("{fields}\n{gu}")).unwrap();
    std::fs::write(folder.path().join("lego.toml"), lego(&data)).unwrap();
    let arguments = [
        "verify",
        "--config",
        "lanes.toml",
        "--scene",
        "lego.toml",
        "--width",
        "40",
        "--level",
        "quick",
        "--json",
        "r.json",
    ];
    let said = expect(folder.path(), 0, &arguments);
    assert!(said.contains("no mismatch"), "{said}");
    let r = json(&folder.path().join("r.json"));
    assert!(r["samples"].as_u64().unwrap() > 2_000, "{r}");
    assert!(r["stall_bank"].as_u64().unwrap() > 1_000, "{r}");
}

/// The description of the trained field.
fn lego(data: &std::path::Path) -> String {
    format!(
        "[model]\nkind = \"dvgo\"\npath = {:?}\n[camera]\nkind = \"transforms\"\npath = {:?}\n\
         index = 0\n[render]\nbackground = [1, 1, 1]\n",
        data.join("lego_dvgo/fine_last.tar"),
        data.join("lego_orbit/transforms.json")
    )
}

fn trained_field(level: &str, width: &str) {
    let Some(data) = common::shared() else {
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("lego.toml"), lego(&data)).unwrap();
    let arguments = [
        "verify",
        "--config",
        "fields",
        "--scene",
        "lego.toml",
        "--width",
        width,
        "--level",
        level,
        "--json",
        "r.json",
    ];
    let said = expect(folder.path(), 0, &arguments);
    assert!(said.contains("no mismatch"), "{said}");
    let r = json(&folder.path().join("r.json"));
    let n = |unit: &str, field: &str| r[unit][field].as_u64().unwrap();
    let side: u64 = width.parse().unwrap();
    let checked = [
        ("gathering_unit", "samples", 4),
        ("vector_unit", "elements", 1000),
    ];
    for (unit, of, a_pixel) in checked {
        let all = n(unit, &format!("{of}_total"));
        assert!(all > a_pixel * side * side, "{r}");
        if level == "full" {
            assert_eq!(n(unit, of), all);
        }
    }
}

/// A real scene at 200 x 200: a share spread over the frame.
#[test]
fn real_splats_agree_on_a_share() {
    real_splats(&[("playbot_8k.ply", 20_000)], "200", "quick", 2);
}

/// The real scenes at 400 x 400: every gather and every vector operation.
#[test]
#[ignore = "exhaustive; run with make test-full"]
fn real_splats_agree_in_every_gather() {
    let files = [("playbot_8k.ply", 60_000), ("playbot_31k.ply", 120_000)];
    real_splats(&files, "400", "full", 1);
}

/// Of files of splats, each with fewer gathers than it takes.
fn real_splats(files: &[(&str, u64)], width: &str, level: &str, share: u64) {
    let Some(data) = common::shared() else {
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    let camera = data.join("cameras/camera_playbot_31k_800.json");
    for &(file, samples) in files {
        let scene = data.join("splats").join(file);
        let trace = [
            "verify",
            "--scene",
            scene.to_str().unwrap(),
            "--camera",
            camera.to_str().unwrap(),
            "--width",
            width,
            "--level",
            level,
            "--json",
            "r.json",
        ];
        let said = expect(folder.path(), 0, &trace);
        assert!(said.contains("no mismatch"), "{said}");
        let r = json(&folder.path().join("r.json"));
        assert!(r["samples"].as_u64().unwrap() > samples / share, "{r}");
        let gather = &r["gathering_unit"];
        assert!(gather["samples_total"].as_u64().unwrap() > samples, "{r}");
        if share == 1 {
            assert_eq!(gather["samples"], gather["samples_total"]);
            let vector = &r["vector_unit"];
            assert_eq!(vector["elements"], vector["elements_total"]);
        }
    }
}
