//! Files that were read wrongly once, of the shared data: each by the camera that
//! it tells, or the words with which it is refused.

use std::path::PathBuf;

use super::*;

fn cases() -> Option<PathBuf> {
    let shared = std::env::var_os("POTAMOI_SHARED").map_or_else(
        || PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared")),
        PathBuf::from,
    );
    let cases = shared.join("cases");
    if cases.join("base.ply").exists() {
        return Some(cases);
    }
    println!("skipped: no shared data (set POTAMOI_SHARED)");
    None
}

fn opened(path: &std::path::Path) -> Result<Scene, String> {
    Scene::open(path.to_str().unwrap()).map_err(|e| e.to_string())
}

/// Whether two cameras are one, but for the rounding of a rotation.
fn is_same(a: &Camera, b: &Camera) -> bool {
    let off = a.world_to_camera.matrix3 - b.world_to_camera.matrix3;
    let near = off.to_cols_array().iter().all(|v| v.abs() < 1e-12);
    let apart = (a.position() - b.position()).length();
    let lens = |c: &Camera| (c.width, c.height, c.focal, c.centre);
    near && apart < 1e-12 && lens(a) == lens(b)
}

#[test]
fn cameras_of_the_shared_cases_are_right_or_refused_by_name() {
    let Some(cases) = cases() else {
        return;
    };
    let cam = cases.join("cam");
    let mut base = opened(&cases.join("base.ply")).unwrap();
    base.set_camera_file(&cam.join("cameras.json"), 0).unwrap();
    let base = base.camera;
    for file in ["cameras_bom.json", "cameras_float_width.json"] {
        let mut scene = opened(&cases.join("base.ply")).unwrap();
        scene.set_camera_file(&cam.join(file), 0).unwrap();
        assert!(is_same(&scene.camera, &base), "{file}");
    }
    let described = |case: &str| opened(&cam.join(case).join("s.toml"));
    for case in ["bom", "perframe", "perframe_size", "nowh_cxcy"] {
        let scene = described(case).unwrap();
        assert!(is_same(&scene.camera, &base), "{case}: {:?}", scene.camera);
    }
    let mixed = described("perframe_mixed").unwrap().camera;
    let truth = described("perframe_mixed_truth").unwrap().camera;
    assert!(is_same(&mixed, &truth) && !is_same(&mixed, &base));
    for (case, key) in [
        ("dist", "`k1`"),
        ("fisheye", "`camera_model` is \"OPENCV_FISHEYE\""),
        ("equirect", "`camera_model` is \"EQUIRECTANGULAR\""),
        ("latlong", "`latlong`"),
        ("ortho", "`orthographic`"),
    ] {
        let error = described(case).unwrap_err();
        assert!(
            error.contains(key) && error.contains("transforms.json"),
            "{case}: {error}"
        );
    }
    let said = described("unsorted").unwrap().left_open().join("; ");
    assert!(said.contains("order of frames: the file's"), "{said}");
    let poses = described("c_noblank1").unwrap();
    assert_eq!(poses.path_length(30.0), Some(4));
    assert!(is_same(&poses.camera, &base));
}

#[test]
fn a_density_grid_of_no_numbers_is_refused() {
    let Some(cases) = cases() else {
        return;
    };
    let file = cases.join("repro/density_nan.ingp");
    let error = opened(&file).unwrap_err();
    assert!(
        error.contains("`snapshot.density_grid_binary` is NaN at number"),
        "{error}"
    );
}
