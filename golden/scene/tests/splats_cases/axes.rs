//! Axes stated by files, implied by formats, or requested.

use glam::{DAffine3, DMat3, DVec3};
use potamoi_base::camera::Camera;
use potamoi_gaussians::Axes;
use potamoi_scene::Scene;

use super::write::{Ply, Shape, Spz, axes_extension};
use super::*;

/// Where x, y and z of a file point, in right, down, front: by the words alone.
fn matrix(axes: Axes) -> DMat3 {
    let name = axes.to_string();
    let columns: Vec<DVec3> = (name.split('-'))
        .map(|word| match word {
            "right" => DVec3::X,
            "left" => DVec3::NEG_X,
            "down" => DVec3::Y,
            "up" => DVec3::NEG_Y,
            "front" => DVec3::Z,
            "back" => DVec3::NEG_Z,
            other => panic!("{other}"),
        })
        .collect();
    DMat3::from_cols(columns[0], columns[1], columns[2])
}

/// What `camera` would see of a scene that lies in a file's axes, with the camera turned in place of
/// the scene. A camera is not mirrored: of mirrored axes its picture is.
fn seen_in_axes(scene: &Scene, camera: Camera, axes: Axes) -> Picture {
    let matrix = matrix(axes);
    let mirror = DMat3::from_diagonal(DVec3::new(matrix.determinant(), 1.0, 1.0));
    let own = Camera {
        world_to_camera: DAffine3::from_mat3(mirror)
            * camera.world_to_camera
            * DAffine3::from_mat3(matrix),
        ..camera
    };
    let mut picture = seen(scene, own);
    if mirror.x_axis.x < 0.0 {
        let rows = picture.rgb.chunks_exact_mut(camera.width as usize);
        rows.for_each(<[[f32; 3]]>::reverse);
    }
    picture
}

/// Turned by the reader, or seen by a camera that is turned: the same picture, centres, ellipsoids and harmonics of degree 3 alike. That of the file as it
/// lies is another.
#[test]
fn a_turned_model_is_what_a_turned_camera_sees() {
    let folder = tempfile::tempdir().unwrap();
    let path = Ply::of(&Shape::new(-3.2)).write(folder.path(), "a.ply");
    let plain = open(&path);
    for axes in Axes::all() {
        let turned = Scene::open_in(path.to_str().unwrap(), Some(axes)).unwrap();
        let truth = seen_in_axes(&plain, camera(), axes);
        let found = seen(&turned, camera());
        if axes == Axes::RIGHT_DOWN_FRONT {
            assert_eq!(found.rgb, truth.rgb);
            continue;
        }
        tells_apart(&found, &truth, &seen(&plain, camera()), LOSSLESS);
    }
}

/// A model of a colour field is asked where it was fitted, in whatever axes it is shown.
#[test]
fn colours_of_a_field_turn_with_the_axes() {
    let path = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../tests/fixtures/compact/tiny.npz"
    );
    let plain = Scene::open(path).unwrap();
    for axes in ["LUF", "front-right-up"].map(|own| own.parse().unwrap()) {
        let turned = Scene::open_in(path, Some(axes)).unwrap();
        let camera = *turned.camera();
        let truth = seen_in_axes(&plain, camera, axes);
        tells_apart(
            &seen(&turned, camera),
            &truth,
            &seen(&plain, camera),
            LOSSLESS,
        );
    }
}

/// SPZ in all its versions, packed or bare: as it usually lies, and as its extension says. Without
/// the flag of extensions the same bytes say nothing, as in the format's own reader, and are listed.
#[test]
fn spz_lies_as_its_extension_says() {
    let folder = tempfile::tempdir().unwrap();
    let shape = Shape::new(-3.2);
    let truth = picture(&Ply::of(&shape).write(folder.path(), "a.ply"));
    let upside_down = picture(&write(
        folder.path(),
        "wrong.spz",
        &Spz::new(3).bytes(&shape, false),
    ));
    for version in 1..=4 {
        for packed in [true, false] {
            for flags in [0, 2] {
                let mut spz = Spz::new(version);
                (spz.packed, spz.flags) = (packed, flags);
                let is_said = flags == 2;
                for (flip, tail) in [
                    (true, vec![]),
                    (true, axes_extension(4)),
                    (!is_said, axes_extension(6)),
                ] {
                    spz.tail = tail;
                    let path = write(folder.path(), "a.spz", &spz.bytes(&shape, flip));
                    tells_apart(&picture(&path), &truth, &upside_down, ROUNDED);
                    let notes = notes(&path);
                    let assumed = notes.assumed().join(" ");
                    let is_assumed = spz.tail.is_empty() || !is_said;
                    let says = assumed.contains("axes right-up-back");
                    assert_eq!(says, is_assumed, "{assumed}");
                    let listed = notes.not_used().join(" ").contains("bytes after");
                    assert_eq!(listed, !spz.tail.is_empty() && !is_said);
                }
            }
        }
    }
}

/// Requested axes have precedence over those of the file, which are then listed.
#[test]
fn axes_that_are_given_go_first() {
    let folder = tempfile::tempdir().unwrap();
    let shape = Shape::new(-3.2);
    let mut spz = Spz::new(3);
    (spz.flags, spz.tail) = (2, axes_extension(4));
    let path = write(folder.path(), "a.spz", &spz.bytes(&shape, false));
    let loaded = files::read(&path, Some(Axes::RIGHT_DOWN_FRONT)).unwrap();
    assert!(loaded.notes.not_used().join(" ").contains("its axes"));
    let toml = |model: &str| {
        let text = format!("[model]\nkind = \"splats\"\npath = \"a.spz\"\n{model}\n");
        write(folder.path(), "scene.toml", text.as_bytes())
    };
    let truth = picture(&Ply::of(&shape).write(folder.path(), "a.ply"));
    let as_it_says = picture(&toml(""));
    let given = picture(&toml("axes = \"right-down-front\""));
    tells_apart(&given, &truth, &as_it_says, ROUNDED);
    let said = Scene::open(toml("axes = \"right-left-up\"").to_str().unwrap());
    let said = said.unwrap_err().to_string();
    assert!(
        said.contains("model.axes") && said.contains("right-down-front"),
        "{said}"
    );
    let said = Scene::open_in("garden", Some(Axes::RIGHT_UP_BACK)).unwrap_err();
    assert!(said.to_string().contains("axes"), "{said}");
}

/// The vertical axis of a file is up in the default view; what names none is listed.
#[test]
fn the_vertical_axis_is_up() {
    let folder = tempfile::tempdir().unwrap();
    let ply = Ply::of(&Shape::new(-3.2));
    let up = |line: &str, axes: Option<Axes>| {
        let path = ply
            .clone()
            .line(line.as_bytes())
            .write(folder.path(), "a.ply");
        let scene = Scene::open_in(path.to_str().unwrap(), axes).unwrap();
        let turn = scene.camera().world_to_camera.matrix3;
        [DVec3::X, DVec3::Y, DVec3::Z, DVec3::NEG_Y].map(|axis| {
            let tip = turn * axis;
            tip.y < -0.9 && tip.x.abs() < 1e-9
        })
    };
    assert_eq!(
        up("comment Vertical axis: z", None),
        [false, false, true, false]
    );
    assert_eq!(
        up("comment vertical axis = Y", None),
        [false, true, false, false]
    );
    assert_eq!(
        up("comment Vertical axis: -y", None),
        [false, false, false, true]
    );
    // In the file's axes: its z is up.
    let axes = "right-front-up".parse().ok();
    assert_eq!(
        up("comment Vertical axis: z", axes),
        [false, false, false, true]
    );
    assert_eq!(
        up("comment Vertical axis: north", None),
        [false, false, false, true]
    );
    let path = folder.path().join("a.ply");
    assert!(
        notes(&path)
            .not_used()
            .contains(&"comment Vertical axis".to_owned())
    );
}
