//! A trained DirectVoxGO model of a real scene, against the figures that its
//! own training run reports.

use std::path::{Path, PathBuf};

use potamoi_base::file_keys::Notes;
use potamoi_base::picture::Picture;
use potamoi_fields::algorithms::dvgo::Dvgo;
use potamoi_fields::{FixedField, FixedOptions, render_float};
use potamoi_formats::config::Config;
use potamoi_march::tiling::Halo;
use potamoi_reference::ReferenceUnits;
use potamoi_scene::transforms;

fn shared() -> Option<PathBuf> {
    let path = std::env::var_os("POTAMOI_SHARED").map_or_else(
        || Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared"),
        PathBuf::from,
    );
    let data = path.join("data");
    if !data.join("lego_dvgo/fine_last.tar").is_file() {
        println!("skipped: no trained model in {}", data.display());
        return None;
    }
    Some(data)
}

/// A picture over white, box-filtered to one of `factor` pixels a side less.
fn reference(path: &Path, factor: u32) -> Picture {
    let image = image::open(path).unwrap().to_rgba32f();
    let (width, height) = (image.width() / factor, image.height() / factor);
    let mut out = Picture::filled(width, height, [0.0; 3]);
    let share = 1.0 / (factor * factor) as f32;
    for (x, y, pixel) in image.enumerate_pixels() {
        let [r, g, b, a] = pixel.0;
        let to = &mut out.rgb[(y / factor * width + x / factor) as usize];
        for (sum, v) in to.iter_mut().zip([r, g, b]) {
            *sum += share * (v * a + 1.0 - a);
        }
    }
    out
}

#[test]
fn test_pose_0_of_lego_is_as_far_from_the_truth_as_its_training_says() {
    let Some(data) = shared() else {
        return;
    };
    let field = Dvgo::load(&data.join("lego_dvgo/fine_last.tar"), 0.5).unwrap();
    let path = transforms::read(
        &data.join("lego_orbit/transforms.json"),
        &mut Notes::default(),
    )
    .unwrap();
    let report = std::fs::read(data.join("lego_dvgo/result.json")).unwrap();
    let report: serde_json::Value = serde_json::from_slice(&report).unwrap();
    let stated = report["test_psnr_200"][0].as_f64().unwrap();
    let frame = &path[0];
    let rendered = render_float(&field, &frame.camera.resized(200, 200), [1.0; 3]).unwrap();
    let mut picture = data.join("lego_orbit").join(&frame.picture);
    picture.set_extension("png");
    let psnr = rendered.picture.psnr(&reference(&picture, 4), |_| true);
    let psnr = psnr.unwrap();
    println!(
        "lego, test pose 0, 200 x 200: {psnr:.3} dB against the truth, stated {stated:.3} dB; \
         {} samples, {} gathered, {} coloured",
        rendered.samples, rendered.gathered, rendered.coloured
    );
    assert!((psnr - stated).abs() < 0.1, "{psnr} dB, stated {stated} dB");
    assert!(rendered.coloured < rendered.gathered && rendered.gathered < rendered.samples);
}

/// The same bits with both halos, for ray groups of any size.
#[test]
fn a_split_halo_changes_no_bit_of_lego() {
    let Some(data) = shared() else {
        return;
    };
    let field = Dvgo::load(&data.join("lego_dvgo/fine_last.tar"), 0.5).unwrap();
    let path = transforms::read(
        &data.join("lego_orbit/transforms.json"),
        &mut Notes::default(),
    )
    .unwrap();
    let camera = path[0].camera.resized(48, 48);
    let config =
        Config::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../../configs/fields.toml"));
    let config = config.unwrap();
    let mut first = None;
    for halo in [Halo::Shared, Halo::Split] {
        let made = FixedField::with_halo(&field, &config, halo).unwrap();
        for side in [16, 48] {
            let options = FixedOptions {
                background: [1.0; 3],
                group_side: Some(side),
                ..FixedOptions::default()
            };
            let mut units = ReferenceUnits::new(&config);
            let frame = made.render(&camera, &options, &mut units).unwrap();
            assert_eq!(frame.stats.split_entries > 0, halo == Halo::Split);
            let bits = (frame.picture, frame.transmittance);
            let expected = first.get_or_insert_with(|| bits.clone());
            assert!(bits == *expected, "{halo:?}, {side}");
        }
    }
}

#[test]
fn the_fixed_picture_holds_80_decibels_to_the_float_one() {
    fixed_against_float(80);
}

#[test]
#[ignore = "exhaustive; run with make test-full"]
fn the_fixed_picture_at_full_size() {
    fixed_against_float(200);
}

fn fixed_against_float(side: u32) {
    let Some(data) = shared() else {
        return;
    };
    let field = Dvgo::load(&data.join("lego_dvgo/fine_last.tar"), 0.5).unwrap();
    let path = transforms::read(
        &data.join("lego_orbit/transforms.json"),
        &mut Notes::default(),
    )
    .unwrap();
    let camera = path[0].camera.resized(side, side);
    let float = render_float(&field, &camera, [1.0; 3]).unwrap();
    let config =
        Config::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../../configs/fields.toml"));
    let config = config.unwrap();
    let made = FixedField::new(&field, &config).unwrap();
    let options = FixedOptions {
        background: [1.0; 3],
        ..FixedOptions::default()
    };
    let fixed = made
        .render(&camera, &options, &mut ReferenceUnits::new(&config))
        .unwrap();
    let psnr = fixed.picture.psnr(&float.picture, |_| true).unwrap();
    let covered = fixed
        .picture
        .psnr(&float.picture, |i| float.transmittance[i] < 1.0)
        .unwrap();
    println!(
        "fixed against float: {psnr:.1} dB over the frame, {covered:.1} dB covered; {:?}",
        fixed.stats
    );
    // What was measured, less 6 dB: a step that skips what it should not, or ends rays early, costs
    // more.
    assert!(psnr > 80.0, "{psnr} dB");
    // Outputs beyond what the calibration set reached are rare.
    assert!(
        fixed.stats.held < 1000,
        "{} sums were held",
        fixed.stats.held
    );
}
