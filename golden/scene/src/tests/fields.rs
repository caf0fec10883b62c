//! Fields of ready-made scenes, seen by every renderer.

use glam::DVec3;

use crate::{Model, Scene};
use potamoi_base::file_keys::{Fate, Format, Notes};
use potamoi_fields::algorithms::efficient::{CHANNELS, EfficientNerf};
use potamoi_fields::{
    AnyField, FieldFile, FileOptions, LoadedField, RayLengths, RayStages, render_float,
};

/// The stages make the picture, to the order of its sums.
#[test]
fn stages_make_the_picture() {
    for name in ["cairn:ngp", "moons:efficientnerf"] {
        let mut scene = crate::tests::opened(name);
        scene.set_size(Some(24), None).unwrap();
        let Model::Field(field) = scene.model() else {
            panic!("a field")
        };
        let frame = render_float(&**field, scene.camera(), [0.0; 3]).unwrap();
        let stops = RayLengths::find(&**field, scene.camera()).unwrap();
        let mut rays = RayStages::new(&stops);
        let mut lit = 0;
        for (i, expected) in (0..).zip(&frame.picture.rgb) {
            rays.aim([i % 24, i / 24]);
            rays.index();
            rays.gather();
            let found = rays.compute();
            let off = found - DVec3::from(expected.map(f64::from));
            assert!(off.abs().max_element() < 1e-6, "{name} {i}: {found}");
            lit += u32::from(found != DVec3::ZERO);
        }
        assert!(lit > 50, "{lit}");
    }
}

/// As many samples as the renderer counts, each where a gathered one lies.
#[test]
fn rays_stop_where_the_renderer_stops_them() {
    let mut scene = crate::tests::opened("moons:efficientnerf");
    scene.set_size(Some(40), Some(30)).unwrap();
    let Model::Field(field) = scene.model() else {
        panic!("a field")
    };
    let frame = render_float(&**field, scene.camera(), [0.0; 3]).unwrap();
    let stops = RayLengths::find(&**field, scene.camera()).unwrap();
    let (mut told, mut kept, mut samples) = (0, 0, 0);
    let mut places = vec![DVec3::ZERO; field.tables().len()];
    for pixel in (0..30).flat_map(|y| (0..40).map(move |x| [x, y])) {
        let before = told;
        stops.samples(pixel, 1, &mut places, |places| {
            let mut rows = 0;
            field.tables()[0].corners(places[0], |_, _| rows += 1);
            assert_eq!(rows, 1);
            told += 1;
        });
        assert_eq!(told - before, u64::from(stops.gathered(pixel)));
        kept += u64::from(stops.gathered(pixel));
        samples += stops.passed(pixel);
    }
    assert_eq!([told, kept], [frame.gathered; 2]);
    assert_eq!(samples, frame.samples);
    assert!(told > 1000, "{told}");
    let mut finer = 0;
    stops.samples([20, 15], 3, &mut places, |_| finer += 1);
    let own = stops.gathered([20, 15]);
    assert!(own > 2 && (2 * own..=4 * own).contains(&finer), "{finer}");
}

/// Files that a field of one's own registers.
static ADDED: FieldFile = FieldFile {
    kind: "added",
    endings: &["added"],
    format: &Format {
        name: "Added",
        files: "`.added`: what its coarse cells hold",
        keys: &[],
        others: Fate::Listed,
    },
    keys: &["path"],
    background: [0.25; 3],
    load: |path, _| {
        let filled = std::fs::read(path).unwrap();
        let fill = |at: DVec3, values: &mut [f32; CHANNELS]| {
            values[0] = 3.0;
            filled[(at.x / 3.0) as usize] == b'x'
        };
        let mut notes = Notes::default();
        notes.list("the end of the line");
        let field = EfficientNerf::sampled([filled.len(), 1, 1], DVec3::ZERO, 1.0, fill)?;
        Ok(LoadedField {
            field: AnyField::new(field),
            notes,
        })
    },
};

/// A file that is read as docs/adding/field.md says is a scene like the others.
#[test]
fn a_file_of_an_added_field_is_a_scene() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("row.added");
    std::fs::write(&path, "x-xx").unwrap();
    let mut scene = Scene::field_file(&path, &ADDED, &FileOptions::default()).unwrap();
    scene.set_size(Some(24), None).unwrap();
    assert_eq!(scene.name(), path.to_str().unwrap());
    assert_eq!(scene.model().algorithm(), "EfficientNeRF");
    assert!(scene.left_open().join("; ").contains("the end of the line"));
    let frame = scene.render_float().unwrap();
    assert!(frame.covered.contains(&true) && frame.covered.contains(&false));
    for (pixel, covered) in frame.picture.rgb.iter().zip(&frame.covered) {
        assert!(*covered || *pixel == [0.25; 3]);
    }
}

/// Stages are in world coordinates, the picture in units of vertices.
#[test]
fn a_grid_is_the_same_in_its_own_units() {
    let mut scene = crate::tests::opened("lantern");
    scene.set_size(Some(60), None).unwrap();
    let Model::Field(field) = scene.model() else {
        panic!("a field")
    };
    let expected = render_float(&**field, scene.camera(), [0.0; 3]).unwrap();
    let stops = RayLengths::find(&**field, scene.camera()).unwrap();
    let mut rays = RayStages::new(&stops);
    let mut found = expected.picture.clone();
    let mut samples = 0;
    for (i, pixel) in (0..).zip(&mut found.rgb) {
        let at = [i % 60, i / 60];
        rays.aim(at);
        rays.index();
        rays.gather();
        *pixel = rays.compute().to_array().map(|v| v as f32);
        samples += stops.passed(at);
    }
    let psnr = found.psnr(&expected.picture, |_| true).unwrap();
    assert!(psnr > 100.0, "{psnr} dB");
    assert!(samples > 10_000 && expected.coloured < samples / 2);
}
