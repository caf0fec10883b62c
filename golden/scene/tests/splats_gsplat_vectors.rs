//! gsplat's own renders of 4 and 16 Gaussians, matched to 1e-5.

use std::path::PathBuf;

use glam::{DAffine3, DVec2, DVec3};
use potamoi_base::camera::Camera;
use potamoi_gaussians::Cloud;
use potamoi_splats::{FloatOptions, Profile, render_float};
use safetensors::{Dtype, SafeTensors};

fn vectors() -> Option<PathBuf> {
    let shared = std::env::var_os("POTAMOI_SHARED").map_or_else(
        || PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared")),
        PathBuf::from,
    );
    let folder = shared.join("data/golden_vectors");
    folder.is_dir().then_some(folder)
}

fn floats(file: &SafeTensors<'_>, name: &str) -> Vec<f32> {
    let tensor = file.tensor(name).unwrap();
    assert_eq!(tensor.dtype(), Dtype::F32, "{name}");
    tensor
        .data()
        .chunks_exact(4)
        .map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]]))
        .collect()
}

fn group<const N: usize>(flat: &[f32]) -> Vec<[f32; N]> {
    flat.chunks_exact(N)
        .map(|c| c.try_into().unwrap())
        .collect()
}

/// gsplat computes in 32-bit floats: its own rounding is some 1e-6 of values
/// up to 1, and so is the file's; 1e-5 is the tolerance its users check to.
const TOLERANCE: f64 = 1e-5;

fn check(name: &str) {
    let Some(folder) = vectors() else {
        println!("skipped: {name}: no shared data (set POTAMOI_SHARED)");
        return;
    };
    let bytes = std::fs::read(folder.join(name)).unwrap();
    let file = SafeTensors::deserialize(&bytes).unwrap();
    let cloud = Cloud::new(
        3,
        group(&floats(&file, "means")),
        group(&floats(&file, "scales")),
        group(&floats(&file, "quats")),
        floats(&file, "opacities"),
        group(&floats(&file, "coeffs")),
    )
    .unwrap();
    let expected = floats(&file, "out_img");
    let (height, width) = (82, 123);
    assert_eq!(expected.len(), height * width * 4);
    let camera = Camera {
        width: width as u32,
        height: height as u32,
        // A horizontal field of view of 90 degrees.
        focal: DVec2::splat(width as f64 / 2.0),
        centre: DVec2::new(width as f64, height as f64) / 2.0,
        world_to_camera: DAffine3::from_translation(-DVec3::new(0.123, 0.456, -8.0)),
    };
    let off = |camera: &Camera, profile| {
        let frame = render_float(&cloud, camera, profile, &FloatOptions::default()).unwrap();
        let mut worst = 0.0f64;
        for (i, pixel) in expected.chunks_exact(4).enumerate() {
            for c in 0..3 {
                let d = f64::from(pixel[c]) - f64::from(frame.picture.rgb[i][c]);
                worst = worst.max(d.abs());
            }
            let alpha = 1.0 - frame.transmittance[i];
            worst = worst.max((f64::from(pixel[3]) - alpha).abs());
        }
        worst
    };
    let worst = off(&camera, Profile::Gsplat);
    println!("{name}: largest difference {worst:.2e}");
    assert!(worst < TOLERANCE, "{name}: {worst}");
    // No opacity here reaches either cap.
    assert!(off(&camera, Profile::GsplatCap99) < TOLERANCE);
    // The test bites: half a pixel aside is far off.
    let aside = Camera {
        centre: camera.centre - 0.5,
        ..camera
    };
    assert!(off(&aside, Profile::Gsplat) > 100.0 * TOLERANCE);
}

#[test]
fn tiny_case() {
    check("gsplat_tiny_case.safetensors");
}

#[test]
fn basic_case() {
    check("gsplat_basic_case.safetensors");
}
