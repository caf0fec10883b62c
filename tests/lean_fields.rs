//! The presets for fields with a fast clock, and for all scenes.

use std::path::Path;

use crate::common::run;

fn picture(folder: &Path, preset: &str, scene: &str) -> Vec<u8> {
    let picture = folder.join(format!("{preset}.png"));
    let out = picture.to_string_lossy();
    let arguments = [
        "render",
        "--config",
        preset,
        "--scene",
        scene,
        "--width",
        "24",
        "--numerics",
        "fixed",
        "--out",
        &out,
    ];
    let done = run(folder, &arguments);
    assert!(done.status.success(), "{preset}, {scene}: {done:?}");
    std::fs::read(&picture).unwrap()
}

/// Register stages, narrow multiplications and fewer steps a clock change no bit, of any field.
#[test]
fn pictures_of_lean_fields_and_lean_are_those_of_fields() {
    pictures_are_those_of_fields(&["lantern", "cairn:ngp"]);
}

#[test]
#[ignore = "exhaustive; run with make test-full"]
fn pictures_of_other_fields_are_those_of_fields_too() {
    pictures_are_those_of_fields(&["cairn:dvgo", "cairn:tensorf", "cairn:efficientnerf"]);
}

fn pictures_are_those_of_fields(scenes: &[&str]) {
    let folder = tempfile::tempdir().unwrap();
    for scene in scenes {
        let expected = picture(folder.path(), "fields", scene);
        for preset in ["lean-fields", "lean"] {
            let found = picture(folder.path(), preset, scene);
            assert!(found == expected, "{scene}: {preset} differs from fields");
        }
    }
}

/// Steps of a voxel and more have 25 bits and more, as many as the presets' second factors.
#[test]
fn long_steps_have_the_pictures_of_fields_too() {
    long_steps_have_the_pictures_of_fields("voxels", &["2.5"]);
}

#[test]
#[ignore = "exhaustive; run with make test-full"]
fn other_long_steps_have_the_pictures_of_fields_too() {
    long_steps_have_the_pictures_of_fields("voxels", &["1"]);
    long_steps_have_the_pictures_of_fields("tensorf", &["1", "2.5"]);
}

fn long_steps_have_the_pictures_of_fields(representation: &str, steps: &[&str]) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.toml");
    for step in steps {
        let text = format!(
            "[model]\nkind = \"builtin\"\nname = \"cairn\"\nrepresentation = \"{representation}\"\n\
             [render]\nstep = {step}\n"
        );
        std::fs::write(&path, text).unwrap();
        let scene = path.to_string_lossy();
        let expected = picture(folder.path(), "fields", &scene);
        for preset in ["lean-fields", "lean"] {
            let found = picture(folder.path(), preset, &scene);
            assert!(found == expected, "{representation}, step {step}: {preset}");
        }
    }
}

/// Splats are rendered by `lean` too, and refused by `lean-fields` with the field's name.
#[test]
fn lean_takes_splats_and_lean_fields_refuses_them() {
    let folder = tempfile::tempdir().unwrap();
    picture(folder.path(), "lean", "garden");
    let arguments = "render --config lean-fields --scene garden --numerics fixed --out no.png";
    let arguments: Vec<_> = arguments.split(' ').collect();
    let done = run(folder.path(), &arguments);
    let said = String::from_utf8_lossy(&done.stderr);
    assert!(!done.status.success(), "{done:?}");
    assert!(said.contains("use --config paper"), "{said}");
}
