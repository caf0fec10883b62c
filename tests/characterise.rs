//! `potamoi characterise`, and what closing its output does.

use std::process::Stdio;

use crate::common::{expect, json, potamoi};

#[test]
fn accesses_of_both_built_in_scenes_are_counted() {
    let folder = tempfile::tempdir().unwrap();
    for (scene, bytes) in [("garden", 92), ("lantern", 26)] {
        let said = expect(
            folder.path(),
            0,
            &[
                "characterise",
                "--scene",
                scene,
                "--width",
                "120",
                "--json",
                "r.json",
            ],
        );
        assert!(
            said.contains("oracle") && said.contains("the paper"),
            "{said}"
        );
        let r = json(&folder.path().join("r.json"));
        assert_eq!(r["tables"].as_array().unwrap().len(), 1);
        let n = |path: &str| r.pointer(path).unwrap().as_u64().unwrap();
        assert_eq!(n("/tables/0/bytes"), bytes);
        assert_eq!(n("/model_bytes"), n("/tables/0/count") * bytes);
        assert_eq!(n("/memory/bytes"), n("/memory/misses") * bytes);
        if n("/model_bytes") < n("/buffer_bytes") {
            // What fits is fetched once.
            assert!(n("/memory/misses") <= n("/tables/0/count"));
        }
        assert!(n("/memory/not_streaming") <= n("/memory/misses"));
        assert!(n("/memory/misses") <= n("/memory/reads"));
        let points = r["banks"].as_array().unwrap();
        assert_eq!(points.len(), 12);
        let rate = |i: usize| points[i]["conflict_rate"].as_f64().unwrap();
        // More rays on the same banks wait more.
        assert!(rate(0) < rate(8), "{r}");
        assert_eq!(r["merging"].is_null(), scene == "lantern");
        // Every ray group, of fields with both halos; the total is that of all
        // streams, and larger groups move less.
        let traffic = r["traffic"].as_array().unwrap();
        let halos = if scene == "lantern" { 2 } else { 1 };
        assert_eq!(traffic.len(), 4 * halos);
        let moved = |i: usize| {
            let streams = traffic[i]["streams"].as_object().unwrap();
            assert_eq!(streams.len(), 7);
            streams.values().map(|v| v.as_u64().unwrap()).sum::<u64>()
        };
        assert!(moved(0) > moved(traffic.len() - halos), "{r}");
        assert_eq!(traffic[0]["halo"].is_null(), scene == "garden");
        assert!(said.contains("each stream"), "{said}");
        let records = traffic[0]["streams"]["records_written"].as_u64();
        assert_eq!(records > Some(0), scene == "garden");
    }
}

/// `potamoi ... | head`: the work goes on, and the report is written.
#[test]
fn a_reader_that_leaves_stops_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let mut child = potamoi()
        .current_dir(folder.path())
        .args(["characterise", "--scene", "garden", "--json", "r.json"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    let done = child.wait_with_output().unwrap();
    let said = String::from_utf8_lossy(&done.stderr);
    assert!(
        done.status.success() && !said.contains("panicked"),
        "{said}"
    );
    assert!(folder.path().join("r.json").is_file());
}

/// Scenes of several algorithms in one table, and in one report.
#[test]
fn scenes_stand_side_by_side() {
    let folder = tempfile::tempdir().unwrap();
    let ngp = std::path::Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("golden/tests/fixtures/ngp/cube.ingp")
        .display()
        .to_string();
    let list = format!("garden,moons,moons:efficientnerf,{ngp}");
    let said = expect(
        folder.path(),
        0,
        &[
            "characterise",
            "--scenes",
            &list,
            "--width",
            "60",
            "--json",
            "r.json",
        ],
    );
    let r = json(&folder.path().join("r.json"));
    let scenes = r["scenes"].as_array().unwrap();
    let algorithms = ["3DGS", "stored voxels", "EfficientNeRF", "Instant-NGP"];
    assert_eq!(scenes.len(), algorithms.len());
    for (scene, algorithm) in scenes.iter().zip(algorithms) {
        assert_eq!(scene["algorithm"], algorithm);
        assert!(said.contains(algorithm), "{said}");
        assert!(!scene["traffic"].as_array().unwrap().is_empty());
        // Hashed levels, and records of which a small ray group uses few.
        let scattered = scene["traffic"][0]["scattered"].as_u64().unwrap();
        let some = ["3DGS", "Instant-NGP"].contains(&algorithm);
        assert_eq!(scattered > 0, some, "{algorithm}");
    }
    assert!(said.contains("the paper"), "{said}");
}
