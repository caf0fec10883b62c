//! Analytic scenes by their names.

use crate::{BUILTIN, Scene};
use potamoi_analytic::Analytic;

#[test]
fn all_are_built_in_by_their_names() {
    for scene in Analytic::ALL {
        assert!(BUILTIN.contains(&scene.name()));
    }
    let scene = Scene::open("moons").unwrap();
    let path = scene.path(30.0, 31).unwrap();
    assert_eq!(path[0], *scene.camera());
    assert_eq!(path[30], scene.path(1.0, 2).unwrap()[1]);
    for (fps, frames) in [(0.0, 1), (f64::NAN, 1), (30.0, 100_001)] {
        assert!(scene.path(fps, frames).is_err());
    }
    let error = crate::tests::opened("lantern").render_truth().unwrap_err();
    assert!(error.to_string().contains("only cairn, vase"), "{error}");
}
