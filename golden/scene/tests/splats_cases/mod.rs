//! Settings of splat files in all their forms: each case against the correct picture, and against
//! that of a reader that drops the setting. The two must differ by 10 dB.

mod antialiased;
mod axes;
mod dialects;
mod keys;
mod shared;
mod types;
mod write;

use std::path::{Path, PathBuf};

use glam::DVec3;
use potamoi_base::camera::Camera;
use potamoi_base::file_keys::Notes;
use potamoi_base::picture::Picture;
use potamoi_gaussians::{Loaded, files};
use potamoi_scene::Scene;

/// Minimum PSNR of pictures from lossless files.
const LOSSLESS: f64 = 60.0;
/// Minimum PSNR of pictures from SPZ and SOG files, which round.
const ROUNDED: f64 = 45.0;
/// Minimum difference in PSNR between the two readings.
const APART: f64 = 10.0;

fn camera() -> Camera {
    Camera::look_at(
        DVec3::new(0.3, 0.1, -3.0),
        DVec3::new(0.0, 0.0, 0.1),
        DVec3::NEG_Y,
        0.7,
        96,
        80,
    )
}

/// The picture of a scene through a camera.
fn seen(scene: &Scene, camera: Camera) -> Picture {
    let mut scene = scene.clone();
    scene.set_camera(camera);
    scene.render_float().unwrap().picture
}

fn open(path: &Path) -> Scene {
    Scene::open(path.to_str().unwrap()).unwrap()
}

fn picture(path: &Path) -> Picture {
    seen(&open(path), camera())
}

fn decibels(a: &Picture, b: &Picture) -> f64 {
    a.psnr(b, |_| true).unwrap()
}

/// Checks that a picture has this PSNR against the correct one and not against the other.
#[track_caller]
fn tells_apart(found: &Picture, truth: &Picture, otherwise: &Picture, least: f64) {
    let [right, wrong] = [found, otherwise].map(|own| decibels(own, truth));
    assert!(right >= least, "{right:.1} dB");
    assert!(wrong <= least - APART, "the other reading is {wrong:.1} dB");
}

fn write(folder: &Path, name: &str, bytes: &[u8]) -> PathBuf {
    let path = folder.join(name);
    std::fs::write(&path, bytes).unwrap();
    path
}

fn load(path: &Path) -> Loaded {
    files::read(path, None).unwrap()
}

fn notes(path: &Path) -> Notes {
    load(path).notes
}

/// The refusal of a file: one line that names it.
#[track_caller]
fn refusal(path: &Path) -> String {
    let text = match files::read(path, None) {
        Ok(_) => panic!("{} is read", path.display()),
        Err(error) => error.to_string(),
    };
    let file = path.file_name().unwrap().to_str().unwrap();
    assert!(text.contains(file) && !text.contains('\n'), "{text}");
    text
}
