//! `potamoi warp` from end to end.

use std::path::Path;

use crate::common::{self, expect, json, shared};
use serde_json::Value;

const SCENE: [&str; 3] = ["warp", "--scene", "cairn:voxels"];

fn warp(folder: &Path, [width, frames]: [&str; 2], more: &[&str]) -> Value {
    let size = ["--width", width, "--frames", frames, "--json", "warp.json"];
    expect(folder, 0, &[&SCENE[..], &size, more].concat());
    json(&folder.join("warp.json"))
}

/// Side and frames where what is in the pictures does not matter.
const SMALL: [&str; 2] = ["24", "9"];

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value}"))
}

#[test]
fn ways_stand_side_by_side() {
    let folder = tempfile::tempdir().unwrap();
    let report = warp(
        folder.path(),
        ["48", "20"],
        &["--method", "sparw,temp,ds2", "--window", "6,16"],
    );
    assert_eq!(report["format_version"], 2);
    let variants = report["variants"].as_array().unwrap();
    assert!(variants.iter().all(|v| v["depth"] == "model"));
    let names: Vec<_> = variants
        .iter()
        .map(|v| (v["method"].as_str().unwrap(), v["window"].as_u64().unwrap()))
        .collect();
    assert_eq!(
        names,
        [
            ("SpaRW", 6),
            ("SpaRW", 16),
            ("Temp", 6),
            ("Temp", 16),
            ("DS-2", 6)
        ]
    );
    let psnr: Vec<f64> = variants
        .iter()
        .map(|v| number(&v["frame"]["truth"]["mean_psnr_db"]))
        .collect();
    // Small pictures are nearly all edge, which half the resolution blurs and a chain
    // renders again in every frame.
    assert!(
        psnr[0] > psnr[4] + 3.0 && psnr[1] > psnr[4] + 3.0,
        "{psnr:?}"
    );
    assert!(psnr[1] > psnr[3] && psnr[2] > psnr[3], "{psnr:?}");
    for variant in variants {
        let counts = &variant["frame"]["pixels"];
        let total: f64 = counts.as_object().unwrap().values().map(number).sum();
        assert_eq!(total, 20.0 * 48.0 * 48.0);
        let share = number(&variant["rendered_share"]);
        assert!((0.01..0.7).contains(&share), "{variant}");
    }
    let off = number(&variants[0]["prediction"]["largest_radians"]);
    assert!(off < 0.01, "{off}");
}

#[test]
fn frames_and_their_origins_are_written_and_the_same_on_any_number_of_threads() {
    let folder = tempfile::tempdir().unwrap();
    let bytes = |threads: &str, out: &str| {
        let done = common::potamoi()
            .current_dir(folder.path())
            .env("RAYON_NUM_THREADS", threads)
            .args(SCENE)
            .args(["--width", "32", "--frames", "5"])
            .args(["--window", "4", "--out-dir", out])
            .output()
            .unwrap();
        assert!(done.status.success(), "{done:?}");
        let names = (0..5).flat_map(|n| ["frame", "origin"].map(|k| format!("{k}.{n:04}.png")));
        names
            .map(|name| std::fs::read(folder.path().join(out).join(name)).unwrap())
            .collect::<Vec<_>>()
    };
    assert_eq!(bytes("1", "one"), bytes("3", "three"));
}

#[test]
fn a_lost_reference_is_made_up_for_by_full_rendering() {
    let folder = tempfile::tempdir().unwrap();
    let report = warp(folder.path(), SMALL, &["--window", "3", "--lose", "1"]);
    let variant = &report["variants"][0];
    assert_eq!(variant["fallbacks"], 3);
    for frame in variant["frames"].as_array().unwrap() {
        let lost = (3..6).contains(&frame["number"].as_u64().unwrap());
        assert_eq!(frame["fell_back"], lost, "{frame}");
        if lost {
            // The model's own picture.
            assert_eq!(frame["frame"]["model"]["psnr_db"], Value::Null);
        }
    }
}

/// What the schedule gives up, the frames do not have either.
#[test]
fn frames_go_without_references_that_come_too_late() {
    let folder = tempfile::tempdir().unwrap();
    let server = ["--window", "3", "--frame-ms", "40", "--server-ms"];
    let late = [&server[..], &["2000", "--timeout-ms", "100"]].concat();
    let report = warp(folder.path(), SMALL, &late);
    let variant = &report["variants"][0];
    assert_eq!(variant["fallbacks"], 9);
    assert_eq!(variant["frame"]["model"]["psnr_db"], Value::Null);
    assert_eq!(variant["frame"]["pixels"]["full"], 9 * 24 * 24);
    let in_time = [&server[..], &["20"]].concat();
    let report = warp(folder.path(), SMALL, &in_time);
    assert_eq!(report["variants"][0]["fallbacks"], 0);
}

#[test]
fn phi_is_swept_and_a_small_one_renders_more() {
    let folder = tempfile::tempdir().unwrap();
    let report = warp(
        folder.path(),
        ["48", "12"],
        // 3.6 degrees a frame.
        &["--fps", "10", "--window", "6", "--phi", "1,4,90"],
    );
    let shares: Vec<f64> = report["variants"]
        .as_array()
        .unwrap()
        .iter()
        .map(|v| number(&v["rendered_share"]))
        .collect();
    assert!(
        shares[0] > shares[1] + 0.02 && shares[1] > shares[2] + 0.02,
        "{shares:?}"
    );
    let own = number(&report["model"]["mean_psnr_db"]);
    let loss = |n: usize| own - number(&report["variants"][n]["frame"]["truth"]["mean_psnr_db"]);
    assert!(
        loss(0) < loss(1) && loss(1) < loss(2),
        "{:?}",
        [0, 1, 2].map(loss)
    );
}

#[test]
fn schedules_overlap_references_and_targets_and_live_frames_are_the_same() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let window = [
        "--window",
        "5",
        "--out-dir",
        "given",
        "--chrome-trace",
        "given.json",
    ];
    let size = ["24", "20"];
    let times = ["--frame-ms", "40", "--warp-ms", "1"];
    let report = warp(at, size, &[&window[..], &times].concat());
    let timing = &report["variants"][0]["timing"];
    assert_eq!(timing["times"], "given");
    assert_eq!(report["variants"][0]["fallbacks"], 0);
    assert!(number(&timing["overlap_ms"]) > 1.0, "{timing}");
    let trace = json(&at.join("given.json"));
    let events = trace["traceEvents"].as_array().unwrap();
    assert!(events.len() > 25, "{}", events.len());
    // The paper's formula begins a reference with its first target, which waits.
    let lead = ["--window", "5", "--lead", "0"];
    let late = warp(at, size, &[&lead[..], &times].concat());
    let waits = |report: &Value| {
        let all = report["variants"][0]["timing"]["waits_ms"]
            .as_array()
            .unwrap();
        let found = all.iter().find(|w| w[0] == "reference").unwrap();
        number(&found[1])
    };
    assert!(
        waits(&late) > waits(&report) + 50.0,
        "{} {}",
        waits(&late),
        waits(&report)
    );

    let live = [
        "--window",
        "5",
        "--out-dir",
        "live",
        "--live",
        "--chrome-trace",
        "live.json",
    ];
    let report = warp(at, size, &live);
    assert_eq!(report["variants"][0]["timing"]["times"], "measured");
    for n in 0..20 {
        let name = format!("frame.{n:04}.png");
        let [a, b] = ["given", "live"].map(|f| std::fs::read(at.join(f).join(&name)).unwrap());
        assert_eq!(a, b, "{name}");
    }
}

#[test]
fn depth_is_of_the_model_of_a_mesh_or_given() {
    let folder = tempfile::tempdir().unwrap();
    let at = |depth: &[&str]| {
        let report = warp(
            folder.path(),
            ["48", "8"],
            &[&["--window", "4"], depth].concat(),
        );
        let variant = &report["variants"][0];
        (
            number(&variant["frame"]["model"]["psnr_db"]),
            number(&variant["rendered_share"]),
        )
    };
    let model = at(&["--depth", "model"]);
    for depth in [
        &["--depth", "given"][..],
        &["--depth", "mesh", "--mesh-cells", "96"],
    ] {
        let (psnr, share) = at(depth);
        assert!(psnr > 30.0, "{depth:?}: {psnr}");
        // What is known of the target spares rays through the void.
        assert!(share < model.1, "{depth:?}: {share} {model:?}");
    }
}

/// A camera that goes ahead evenly for a second, then stands.
fn way(folder: &Path, more: &str) {
    let pose = |k: u32| {
        let ahead = f64::from(k.min(100)) / 100.0;
        format!("{} 0 0 {ahead} 0 0 0 1\n", f64::from(k) / 100.0)
    };
    let poses: String = (0..=200).map(pose).collect();
    std::fs::write(folder.join("way.txt"), poses).unwrap();
    let scene = format!(
        "[model]\nkind = \"builtin\"\nname = \"garden\"\n[camera]\nkind = \"trajectory\"\n\
         path = \"way.txt\"\nscale = 0.5\nwidth = 24\nheight = 24\n{more}"
    );
    std::fs::write(folder.join("s.toml"), scene).unwrap();
}

/// Two rates of a recorded motion and of the orbit, in one table and one report.
#[test]
fn a_recorded_motion_stands_beside_the_orbit_at_several_rates() {
    let folder = tempfile::tempdir().unwrap();
    way(folder.path(), "");
    let arguments =
        "warp --scene s.toml --fps 20,50 --frames 8 --window 4 --frame-ms 60 --json r.json";
    let arguments: Vec<&str> = arguments.split(' ').collect();
    let said = expect(folder.path(), 0, &arguments);
    assert!(
        said.contains("deadline misses") && said.contains("way.txt: format: tum"),
        "{said}"
    );
    let report = json(&folder.path().join("r.json"));
    let rows = report["rates"].as_array().unwrap();
    let own: Vec<_> = rows
        .iter()
        .map(|row| (number(&row["fps"]), row["path"].as_str().unwrap()))
        .collect();
    assert_eq!(
        own,
        [
            (20.0, "trajectory"),
            (20.0, "orbit"),
            (50.0, "trajectory"),
            (50.0, "orbit")
        ]
    );
    for row in rows {
        assert_eq!(row["frames"], 8);
        // Two seconds, both ends included, and the same number on the orbit.
        let fps = number(&row["fps"]);
        assert_eq!(number(&row["motion_frames"]), 2.0 * fps + 1.0);
        assert_eq!(
            number(&row["prediction"]["references"]),
            ((2.0 * fps - 2.0) / 4.0).floor()
        );
        // A full frame takes longer than its time, so that the first is late.
        assert!(number(&row["deadline_misses"]) >= 1.0, "{row}");
        assert!(number(&row["no_miss_up_to_ms"]) > 0.0, "{row}");
    }
    // An even way is predicted but for the frames after its end; an orbit is not straight.
    let error = |row: &Value, what: &str| number(&row["prediction"][what]);
    let [even, orbit] = [&rows[2], &rows[3]];
    assert!(error(even, "largest_degrees") < 1e-6, "{even}");
    assert!(error(even, "mean_distance") < 0.01 && error(orbit, "mean_distance") > 0.01);

    // With a rate of its own, the motion is scheduled at that rate.
    way(folder.path(), "rate_hz = 25\nduration_s = 0.4\n");
    let said = expect(
        folder.path(),
        0,
        &[
            "warp",
            "--scene",
            "s.toml",
            "--window",
            "4",
            "--frame-ms",
            "60",
        ],
    );
    assert!(
        said.contains("10 frames of 24 x 24 at 25 frames a second"),
        "{said}"
    );
    let said = expect(
        folder.path(),
        2,
        &["warp", "--scene", "s.toml", "--fps", "30,72"],
    );
    assert!(said.contains("--fps: expected one rate"), "{said}");
    let render = "render --scene s.toml --numerics float --frames 10 --out p.png";
    expect(folder.path(), 0, &render.split(' ').collect::<Vec<_>>());
    let pictures =
        [0, 9].map(|n| std::fs::read(folder.path().join(format!("p.{n:04}.png"))).unwrap());
    assert_ne!(pictures[0], pictures[1]);
}

#[test]
fn scenes_and_depths_stand_side_by_side() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let run = |scenes: &[&str]| {
        let common = ["warp", "--width", "32", "--frames", "6", "--window", "3"];
        let depths = ["--depth", "model,mesh", "--mesh-cells", "16,64"];
        let ways = ["--method", "ds2,sparw", "--json", "all.json"];
        let said = expect(at, 0, &[&common[..], &depths, &ways, scenes].concat());
        (said, json(&at.join("all.json")))
    };
    let (said, all) = run(&["--scenes", "cairn:voxels,cairn:efficientnerf,lantern"]);
    assert!(said.contains("the paper, trained models"), "{said}");
    let scenes = all["scenes"].as_array().unwrap();
    let names = |found: &Value| -> Vec<String> {
        let variants = found["variants"].as_array().unwrap().iter();
        variants
            .map(|v| v["name"].as_str().unwrap().to_owned())
            .collect()
    };
    for found in scenes {
        assert_eq!(
            names(found),
            [
                "DS-2",
                "SpaRW-3, model",
                "SpaRW-3, mesh 16",
                "SpaRW-3, mesh 64"
            ]
        );
    }
    // The voxels of the lantern have no truth to be compared with.
    assert_eq!(scenes[2]["model"], Value::Null);
    // Ground truth that is shared is the one of the scene alone.
    let (_, alone) = run(&["--scene", "cairn:efficientnerf"]);
    assert_eq!(scenes[1]["model"], alone["model"]);
    assert_eq!(
        scenes[1]["variants"][3]["frame"],
        alone["variants"][3]["frame"]
    );
}

/// Real images and depths: shares of pixels as measured by another program, and
/// everything but what was warped as it was taken.
#[test]
fn image_sequences_are_warped_from_their_own_frames() {
    image_sequences_are_warped(&[("3", [0.0204, 0.0254])]);
}

#[test]
#[ignore = "exhaustive; run with make test-full"]
fn image_sequences_are_warped_from_frames_further_away() {
    image_sequences_are_warped(&[("7", [0.0494, 0.0627]), ("17", [0.1072, 0.1353])]);
}

/// By windows of as many frames: the share of disoccluded pixels in the frames farthest from the
/// reference, one, three or eight frames away, lies in the range of all such pairs of the sequence,
/// as a plain program in NumPy finds them too.
fn image_sequences_are_warped(windows: &[(&str, [f64; 2])]) {
    let Some(shared) = shared() else { return };
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let orbit = shared.join("lego_orbit");
    let description = format!(
        "[model]\nkind = \"images\"\npath = {orbit:?}\ndepth_scale = 10\nvoid_above = 9.99\n\
         [render]\nbackground = [1, 1, 1]\n"
    );
    std::fs::write(at.join("lego.toml"), description).unwrap();
    for &(window, [least, most]) in windows {
        let arguments = [
            "warp",
            "--scene",
            "lego.toml",
            "--window",
            window,
            "--frames",
            window,
            "--profile",
            "paper",
            "--out-dir",
            "out",
            "--json",
            "lego.json",
        ];
        expect(at, 0, &arguments);
        let report = json(&at.join("lego.json"));
        let variant = &report["variants"][0];
        // The frames as far from the middle as there are.
        let all = variant["frames"].as_array().unwrap();
        let first = &all[0];
        for frame in [first, &all[all.len() - 1]] {
            let pixels = &frame["frame"]["pixels"];
            let total: f64 = pixels.as_object().unwrap().values().map(number).sum();
            let share = number(&pixels["disoccluded"]) / total;
            assert!((least..=most).contains(&share), "window {window}: {share}");
        }
        let psnr = number(&first["frame"]["model"]["psnr_db"]);
        assert!((24.0..36.0).contains(&psnr), "window {window}: {psnr}");
        // Where nothing was warped, the frame is the image, byte for byte.
        let read = |path: &Path| image::open(path).unwrap().into_rgba8();
        let frame = read(&at.join("out/frame.0000.png"));
        let origin = read(&at.join("out/origin.0000.png"));
        let image = read(&orbit.join("test/r_0.png"));
        let (mut other, mut warped) = (0, 0);
        for ((a, from), b) in frame.pixels().zip(origin.pixels()).zip(image.pixels()) {
            let grey = from.0[0] == from.0[1] && from.0[1] == from.0[2] && from.0[0] > 0;
            if grey {
                warped += 1;
                continue;
            }
            let alpha = f64::from(b.0[3]) / 255.0;
            for c in 0..3 {
                let over = f64::from(b.0[c]) * alpha + 255.0 * (1.0 - alpha);
                assert!((f64::from(a.0[c]) - over).abs() <= 0.51);
            }
            other += 1;
        }
        assert!(warped > 100_000 && other > 300_000, "{warped} {other}");
    }
    let refused = expect(
        at,
        2,
        &[
            "warp",
            "--scene",
            "lego.toml",
            "--reference",
            "predicted",
            "--frames",
            "8",
            "--window",
            "4",
        ],
    );
    assert!(
        refused.contains("no image was taken from this camera"),
        "{refused}"
    );
    let refused = expect(at, 2, &["render", "--scene", "lego.toml", "--out", "x.png"]);
    assert!(refused.contains("only `warp`"), "{refused}");
}
