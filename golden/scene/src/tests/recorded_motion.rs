//! Scenes whose camera follows a recorded motion.

use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

use glam::DVec3;

use super::*;

/// A camera that goes ahead by half a metre a second, at 20 poses a second for two seconds.
fn straight() -> String {
    (0..=40).fold(String::new(), |mut text, k| {
        let time = f64::from(k) / 20.0;
        writeln!(text, "{time} 0 0 {} 0 0 0 1", f64::from(k) / 40.0).unwrap();
        text
    })
}

fn described(folder: &Path, model: &str, camera: &str) -> Result<Scene, String> {
    let path = folder.join("scene.toml");
    let head = "[camera]\nkind = \"trajectory\"\n";
    fs::write(&path, format!("[model]\n{model}\n{head}{camera}\n")).unwrap();
    Scene::open(path.to_str().unwrap()).map_err(|e| e.to_string())
}

const GARDEN: &str = "kind = \"builtin\"\nname = \"garden\"";

/// The motion starts at the scene's own camera, and its size follows from the scene.
#[test]
fn a_motion_begins_at_the_first_view_of_any_scene() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("way.txt"), straight()).unwrap();
    let file = "path = \"way.txt\"";
    for (model, name) in [
        (GARDEN, "garden"),
        ("kind = \"builtin\"\nname = \"cairn\"", "cairn"),
        (
            "kind = \"builtin\"\nname = \"cairn\"\nrepresentation = \"ngp\"",
            "cairn:ngp",
        ),
    ] {
        let own = opened(name);
        let scene = described(folder.path(), model, file).unwrap();
        assert_eq!(scene.camera(), own.camera());
        assert!(scene.has_motion() && scene.follows_fps());
        assert_eq!(scene.path_length(30.0), Some(61));
        let path = scene.path(30.0, 61).unwrap();
        assert_eq!(path[0], *own.camera());
        // Ahead, by half of the scene's radius.
        let orbit = own.default_orbit();
        let radius = orbit.distance * (orbit.fov / 2.0).to_radians().sin();
        let way = path[60].position() - path[0].position();
        assert!(
            (way - own.camera().axis() * radius / 2.0).length() < 1e-9,
            "{name}"
        );
        let said = scene.left_open_of_files().join("; ");
        assert!(said.contains("way.txt: format: tum"), "{said}");
        assert!(said.contains("0.5 of the scene's radius"), "{said}");
        // The same seconds at another rate.
        assert_eq!(scene.path_length(90.0), Some(181));
        let fast = scene.path(90.0, 181).unwrap();
        assert!((fast[180].position() - path[60].position()).length() < 1e-9);
        assert!((fast[30].position() - path[10].position()).length() < 1e-9);
        // Its own path is beside it.
        let beside = scene.without_motion();
        assert_eq!(
            beside.path(30.0, 5).unwrap(),
            own.path(30.0, 5).unwrap(),
            "{name}"
        );
    }
}

#[test]
fn a_motion_is_cut_scaled_placed_and_sized() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("way.txt"), straight()).unwrap();
    fs::write(
        folder.path().join("camera.json"),
        r#"[{"width": 40, "height": 20, "fx": 30, "fy": 31, "position": [1, 2, 3],
            "rotation": [[1, 0, 0], [0, 1, 0], [0, 0, 1]]},
            {"width": 40, "height": 20, "fx": 30, "fy": 31, "position": [4, 2, 3],
            "rotation": [[1, 0, 0], [0, 1, 0], [0, 0, 1]]}]"#,
    )
    .unwrap();
    fs::write(
        folder.path().join("transforms.json"),
        r#"{"camera_angle_x": 0.69, "w": 40, "frames": [{"file_path": "a",
            "transform_matrix": [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 4], [0, 0, 0, 1]]}]}"#,
    )
    .unwrap();
    let open = |camera: &str| {
        let file = format!("path = \"way.txt\"\n{camera}");
        described(folder.path(), GARDEN, &file)
    };
    let scene = open(
        "rate_hz = 10\nstart_s = 0.5\nduration_s = 1\nscale = 3\nat = \"camera.json\"\nindex = 1\nwidth = 20",
    )
    .unwrap();
    assert!(scene.has_motion() && !scene.follows_fps());
    assert_eq!(
        (scene.path_rate(30.0), scene.path_length(90.0)),
        (Some(10.0), Some(10))
    );
    let path = scene.path(90.0, 10).unwrap();
    assert_eq!(
        (path[0].width, path[0].height, path[0].focal.x),
        (20, 10, 15.0)
    );
    for (k, camera) in path.iter().enumerate() {
        let expected = DVec3::new(4.0, 2.0, 3.0 + 3.0 * 0.05 * k as f64);
        assert!((camera.position() - expected).length() < 1e-12, "{k}");
    }
    assert_eq!(scene.camera(), &path[0]);
    assert!(
        scene
            .left_open_of_files()
            .iter()
            .all(|s| !s.contains("scale"))
    );
    let scene = open("at = \"transforms.json\"").unwrap();
    assert!((scene.camera().position() - DVec3::Z * 4.0).length() < 1e-12);
    // A camera of another file takes its place.
    let mut other = scene;
    other
        .set_camera_file(&folder.path().join("camera.json"), 0)
        .unwrap();
    assert!(!other.has_motion());
    assert_eq!(other.path_length(30.0), Some(2));
    for (camera, expected) in [
        (
            "format = \"tumm\"",
            "camera.format is tumm: expected one of tum, euroc, kitti, replica, poses",
        ),
        (
            "format = \"kitti\"",
            "way.txt, line 1: the number of values is 8: expected 12",
        ),
        ("rate_hz = 0", "camera.rate_hz is 0: expected 0.001 to 1000"),
        ("start_s = 2", "camera.start_s is 2: expected 0 to below 2"),
        ("start_s = -1", "camera.start_s is -1"),
        (
            "start_s = 1.5\nduration_s = 0.6",
            "camera.duration_s is 0.6: expected above 0 to 0.5",
        ),
        ("duration_s = 0", "camera.duration_s is 0"),
        ("scale = 0", "camera.scale is 0: expected above 0"),
        ("scale = 1e99", "camera.scale is"),
        ("index = 1", "camera.index is 1: expected it left out"),
        (
            "at = \"camera.json\"\nindex = 2",
            "camera.index is 2: expected 0 to 1",
        ),
        ("at = \"none.json\"", "none.json"),
        (
            "times = \"camera.json\"",
            "camera.times is given for the dialect tum",
        ),
        ("t_bs = [1]", "`camera.t_bs`: found 1 values, expected 16"),
        ("speed = 2", "`camera.speed`: no such field"),
    ] {
        let error = open(camera).unwrap_err();
        assert!(error.contains(expected), "{camera}: {error}");
    }
    let error = open("rate_hz = 10").unwrap().path(30.0, 22).unwrap_err();
    let expected = "frames is 22: expected at most 21, as its trajectory has at 10 frames a second";
    assert!(error.to_string().contains(expected), "{error}");
}

/// A camera that only turns has no extent to take a scale from.
#[test]
fn a_motion_on_the_spot_has_no_scale() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(
        folder.path().join("way.txt"),
        "0 1 2 3 0 0 0 1\n1 1 2 3 0 0.6 0 0.8\n",
    )
    .unwrap();
    let scene = described(folder.path(), GARDEN, "path = \"way.txt\"").unwrap();
    let path = scene.path(10.0, 11).unwrap();
    let [first, last] = [0, 10].map(|k: usize| path[k]);
    assert!((first.position() - last.position()).length() < 1e-12);
    assert!((first.axis().dot(last.axis()) - (2.0 * 0.8f64.acos()).cos()).abs() < 1e-12);
    let said = scene.left_open_of_files().join("; ");
    assert!(said.contains("the camera does not move"), "{said}");
}

/// The path that was made of ten seconds of TUM's `freiburg2_desk` by another program.
#[test]
fn a_placed_motion_is_that_of_another_program() {
    let shared = std::env::var_os("POTAMOI_SHARED").map_or_else(
        || PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared")),
        PathBuf::from,
    );
    let data = shared.join("data/trajectories");
    let placed = data.join("lego_fr2_desk_30fps.json");
    if !placed.exists() {
        println!("skipped: no trajectories (set POTAMOI_SHARED)");
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let camera = format!(
        "path = {:?}\nat = {placed:?}\nstart_s = 10\nduration_s = 10\nscale = 1",
        data.join("fr2_desk_groundtruth.txt")
    );
    let scene = described(folder.path(), GARDEN, &camera).unwrap();
    let found = scene.path(30.0, 300).unwrap();
    assert_eq!(scene.path_length(30.0), Some(300));
    let expected = crate::transforms::read(&placed, &mut Notes::default()).unwrap();
    // The other file was computed from times of 64 bits and written in 32.
    let (mut apart, mut turned) = (0.0f64, 0.0f64);
    for (a, b) in found.iter().zip(&expected) {
        apart = apart.max((a.position() - b.camera.position()).length());
        let off = a.world_to_camera.matrix3 - b.camera.world_to_camera.matrix3;
        let off = off
            .to_cols_array()
            .iter()
            .fold(0.0f64, |m, v| m.max(v.abs()));
        turned = turned.max(off);
    }
    assert!(apart < 1e-6 && turned < 1e-5, "{apart} {turned}");
}
