#![allow(clippy::unwrap_used)]

use std::fs::File;
use std::io::{Read as _, Write as _};
use std::path::{Path, PathBuf};

use serde::Deserialize;
use zip::write::{SimpleFileOptions, ZipWriter};
use zip::{CompressionMethod, ZipArchive};

use super::*;
use crate::render_float;
use potamoi_base::camera::Camera;

/// Content by PyTorch and NumPy (tools/torch-fixtures).
pub(super) fn fixture(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../tests/fixtures/tensorf")
        .join(name)
}

#[derive(Deserialize)]
struct View {
    eye: [f64; 3],
    target: [f64; 3],
    up: [f64; 3],
    fov_y: f64,
    width: u32,
    height: u32,
}

#[derive(Deserialize)]
struct Shown {
    camera: View,
    step: f64,
    /// Red, green, blue over black, and the final transmittance.
    pixels: Vec<[f64; 4]>,
    points: Vec<[f64; 3]>,
    directions: Vec<[f64; 3]>,
    sigma: Vec<f64>,
    colour: Vec<[f64; 3]>,
}

fn shown() -> (Shown, Camera) {
    let text = std::fs::read(fixture("tiny.json")).unwrap();
    let shown: Shown = serde_json::from_slice(&text).unwrap();
    let v = &shown.camera;
    let camera = Camera::look_at(
        v.eye.into(),
        v.target.into(),
        v.up.into(),
        v.fov_y,
        v.width,
        v.height,
    );
    (shown, camera)
}

/// Features at a place of the world, if something may be there.
pub(super) fn gathered(field: &Tensorf, at: DVec3) -> Option<Vec<f64>> {
    let mut places = [DVec3::ZERO; 6];
    let mut features = vec![0.0; field.channels()];
    if !field.index(at, &mut places) {
        return None;
    }
    let mut rest = &mut features[..];
    for (table, place) in field.tables().iter().zip(places) {
        let (own, other) = rest.split_at_mut(table.channels());
        table.gather(place, own);
        rest = other;
    }
    Some(features)
}

#[test]
fn a_checkpoint_shows_what_numpy_says() {
    let field = Tensorf::load(&fixture("tiny.th")).unwrap();
    assert_eq!(field.points(), [9, 8, 7]);
    assert_eq!(field.channels(), 2 * (10 + 8 + 6));
    let (shown, camera) = shown();
    assert!((field.sampling().step - shown.step).abs() < 1e-12);
    let frame = render_float(&field, &camera, [0.0; 3]).unwrap();
    let (mut worst, mut part) = (0f64, 0);
    let found = frame.picture.rgb.iter().zip(&frame.transmittance);
    for ((rgb, left), [r, g, b, expected]) in found.zip(&shown.pixels) {
        for (a, b) in rgb.iter().zip([r, g, b]) {
            worst = worst.max((f64::from(*a) - b).abs());
        }
        worst = worst.max((left - expected).abs());
        part += u32::from((0.01..0.99).contains(expected));
    }
    println!("at most {worst:.1e} off; {part} pixels part covered");
    assert_eq!(shown.pixels.len(), frame.transmittance.len());
    assert!(worst < 1e-5, "{worst}");
    assert!(part > 20, "the blob's rim is in view: {part}");
}

#[test]
fn densities_and_colours_are_numpys() {
    let field = Tensorf::load(&fixture("tiny.th")).unwrap();
    let (shown, _) = shown();
    let scale = field.sampling().step * field.rules().distance_scale;
    let (mut seen, mut scratch) = (0, vec![]);
    for (i, at) in shown.points.iter().map(|p| DVec3::from(*p)).enumerate() {
        let Some(features) = gathered(&field, at) else {
            assert_eq!(shown.sigma[i], 0.0);
            continue;
        };
        seen += 1;
        let density = field.depth(&features) / scale;
        let off = (density - shown.sigma[i]).abs();
        assert!(off < 1e-9 * (1.0 + density), "{at}: {off}");
        let colour = field.colour(&features, shown.directions[i].into(), &mut scratch);
        assert!((colour - DVec3::from(shown.colour[i])).abs().max_element() < 1e-9);
    }
    assert!((6..shown.points.len()).contains(&seen), "{seen}");
}

/// The fixture with bytes of its description replaced by as many others.
fn patched(from: &[u8], to: &[u8]) -> tempfile::NamedTempFile {
    assert_eq!(from.len(), to.len());
    let mut archive = ZipArchive::new(File::open(fixture("tiny.th")).unwrap()).unwrap();
    let file = tempfile::NamedTempFile::new().unwrap();
    let mut zip = ZipWriter::new(file.reopen().unwrap());
    let options = SimpleFileOptions::default().compression_method(CompressionMethod::Stored);
    for i in 0..archive.len() {
        let mut member = archive.by_index(i).unwrap();
        let mut bytes = vec![];
        member.read_to_end(&mut bytes).unwrap();
        if member.name().ends_with("data.pkl") {
            let mut places = bytes.windows(from.len());
            let at = places.position(|w| w == from).unwrap();
            bytes[at..at + to.len()].copy_from_slice(to);
        }
        zip.start_file(member.name(), options).unwrap();
        zip.write_all(&bytes).unwrap();
    }
    zip.finish().unwrap();
    file
}

/// Every missing name that the loader needs is named in the error.
#[test]
fn what_is_missing_is_named() {
    for name in [
        "aabb",
        "gridSize",
        "density_n_comp",
        "appearance_n_comp",
        "app_dim",
        "density_shift",
        "distance_scale",
        "rayMarch_weight_thres",
        "fea2denseAct",
        "near_far",
        "step_ratio",
        "shadingMode",
        "view_pe",
        "fea_pe",
        "featureC",
        "density_plane.0",
        "density_line.1",
        "app_plane.2",
        "app_line.0",
        "basis_mat.weight",
        "renderModule.mlp.0.weight",
        "renderModule.mlp.4.bias",
        "alphaMask.shape",
        "alphaMask.mask",
        "alphaMask.aabb",
    ] {
        // With its length before it, so that no longer name is meant.
        let from = [&[b'X', name.len() as u8, 0, 0, 0], name.as_bytes()].concat();
        let mut to = from.clone();
        *to.last_mut().unwrap() = b'_';
        let file = patched(&from, &to);
        let error = Tensorf::load(file.path()).unwrap_err().to_string();
        assert!(error.contains(&format!("{name}`")), "{error}");
    }
}

#[test]
fn what_does_not_fit_is_refused_by_field() {
    let cases: [(&[u8], &[u8], &str); 6] = [
        (b"MLP_Fea", b"MLP_Sea", "MLP_Sea; expected MLP_Fea"),
        (b"softplus", b"hardplus", "kwargs/fea2denseAct` is hardplus"),
        // gridSize 9, 8, 7
        (b"K\x09K\x08K\x07", b"K\x09K\x08K\x01", "kwargs/gridSize"),
        (
            b"K\x09K\x08K\x07",
            b"K\x08K\x08K\x07",
            "state_dict/density_plane.0` is of shape [1, 4, 8, 9]; expected a tensor of shape [1, 4, 8, 8]",
        ),
        // density_n_comp 4, 3, 2
        (
            b"K\x04K\x03K\x02",
            b"K\x04K\x02K\x02",
            "state_dict/density_plane.1",
        ),
        (
            b"K\x04K\x03K\x02",
            b"K\x04K\x00K\x02",
            "kwargs/density_n_comp",
        ),
    ];
    for (from, to, expected) in cases {
        let error = Tensorf::load(patched(from, to).path())
            .unwrap_err()
            .to_string();
        assert!(error.contains(expected), "{error}");
    }
    // The number behind a name.
    for (name, wrong, expected) in [
        ("app_dim", 9u8, "state_dict/basis_mat.weight"),
        ("app_dim", 0, "kwargs/app_dim` is 0"),
        ("distance_scale", 0, "kwargs/distance_scale` is 0"),
        ("view_pe", 3, "state_dict/renderModule.mlp.0.weight"),
        ("fea_pe", 17, "kwargs/fea_pe` is 17"),
        ("featureC", 15, "state_dict/renderModule.mlp.0.weight"),
    ] {
        let mut archive = ZipArchive::new(File::open(fixture("tiny.th")).unwrap()).unwrap();
        let mut text = vec![];
        archive
            .by_name("tiny/data.pkl")
            .unwrap()
            .read_to_end(&mut text)
            .unwrap();
        let at = text
            .windows(name.len())
            .position(|w| w == name.as_bytes())
            .unwrap();
        // The name, where it is kept, and a small number.
        let from = &text[at..at + name.len() + 4];
        assert_eq!((from[name.len()], from[name.len() + 2]), (b'q', b'K'));
        let mut to = from.to_vec();
        to[name.len() + 3] = wrong;
        let error = Tensorf::load(patched(from, &to).path())
            .unwrap_err()
            .to_string();
        assert!(error.contains(expected), "{error}");
    }
}

#[test]
fn a_longer_step_is_a_deeper_sample() {
    let field = Tensorf::load(&fixture("tiny.th")).unwrap();
    let features = gathered(&field, DVec3::new(0.05, 0.0, -0.05)).unwrap();
    let (depth, step) = (field.depth(&features), field.sampling().step);
    let field = field.with_step(1.5);
    assert!((field.depth(&features) / depth - 3.0).abs() < 1e-12);
    assert!((field.sampling().step / step - 3.0).abs() < 1e-12);
}
