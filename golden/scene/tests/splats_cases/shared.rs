//! The inputs of the shared data, where there are any, through its own cameras.

use image::RgbImage;

use super::*;

/// Peak signal to noise of two pictures as they are written, in 8 bits.
fn written(a: &RgbImage, b: &RgbImage) -> f64 {
    assert_eq!(a.dimensions(), b.dimensions());
    let pairs = a.as_raw().iter().zip(b.as_raw());
    let sum: f64 = pairs
        .map(|(a, b)| ((f64::from(*a) - f64::from(*b)) / 255.0).powi(2))
        .sum();
    -10.0 * (sum / a.as_raw().len() as f64).log10()
}

fn cases() -> Option<PathBuf> {
    let folder = std::env::var_os("POTAMOI_SHARED").map_or_else(
        || PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared")),
        PathBuf::from,
    );
    let folder = folder.join("cases");
    if !folder.is_dir() {
        println!("skipped: no shared cases (set POTAMOI_SHARED)");
        return None;
    }
    Some(folder)
}

#[test]
fn shared_cases_are_right() {
    let Some(cases) = cases() else { return };
    let folder = tempfile::tempdir().unwrap();
    let rendered = |file: &str, camera: &str| -> RgbImage {
        let mut scene = open(&cases.join(file));
        scene
            .set_camera_file(&cases.join("cam").join(camera), 0)
            .unwrap();
        scene.set_size(Some(200), None).unwrap();
        let png = folder.path().join("a.png");
        scene
            .render_float()
            .unwrap()
            .picture
            .write_png(&png)
            .unwrap();
        image::open(png).unwrap().into_rgb8()
    };
    let usual = |file: &str| rendered(file, "cameras.json");
    let base = usual("base.ply");
    let truth = |name: &str| {
        image::open(cases.join("truth").join(name))
            .unwrap()
            .into_rgb8()
    };
    for (file, truth, other, least) in [
        (
            "ply/aa_thin.ply",
            truth("ref_thin_1.png"),
            Some(truth("ref_thin_0.png")),
            LOSSLESS,
        ),
        (
            "spz/aa_thin.spz",
            truth("ref_thin_1.png"),
            Some(truth("ref_thin_0.png")),
            ROUNDED,
        ),
        (
            "ply/aa_base.ply",
            truth("ref_base_1.png"),
            Some(truth("ref_base_0.png")),
            LOSSLESS,
        ),
        (
            "ply/mip_comment.ply",
            truth("ref_base_1.png"),
            Some(truth("ref_base_0.png")),
            LOSSLESS,
        ),
        (
            "ply/postshot_aa.ply",
            truth("ref_base_1.png"),
            Some(truth("ref_base_0.png")),
            LOSSLESS,
        ),
        ("spz/aa_base.spz", truth("ref_base_1.png"), None, ROUNDED),
        ("sog/aa.sog", truth("ref_base_1.png"), None, ROUNDED),
        (
            "ply/filter3d.ply",
            usual("ply/filter3d_fused.ply"),
            Some(base.clone()),
            LOSSLESS,
        ),
        (
            "ply/2dgs.ply",
            usual("ply/2dgs_truth.ply"),
            Some(base.clone()),
            LOSSLESS,
        ),
        ("ply/latin1.ply", base.clone(), None, LOSSLESS),
        ("ply/bigheader.ply", base.clone(), None, LOSSLESS),
        ("ply/cr_bin.ply", base.clone(), None, LOSSLESS),
        ("ply/vertical.ply", base.clone(), None, LOSSLESS),
        ("ply/scale_neginf.ply", base.clone(), None, 0.0),
    ] {
        let found = usual(file);
        let right = written(&found, &truth);
        assert!(right >= least, "{file}: {right:.1} dB");
        if let Some(other) = other {
            let wrong = written(&other, &truth);
            assert!(wrong < least - APART, "{file}: {wrong:.1} dB otherwise");
        }
    }
    assert!(open(&cases.join("sog/aa.sog")).is_antialiased());
    let far = rendered("ply/utm_double.ply", "cameras_utm.json");
    assert!(written(&far, &base) >= LOSSLESS);
    assert_eq!(usual("sog/folder"), usual("sog/folder/meta.json"));
    for (file, words) in [
        ("dc_uchar.ply", "`f_dc_0` is uchar"),
        ("opacity_uchar.ply", "`opacity` is uchar"),
        ("half_ushort.ply", "`x` is ushort"),
        ("half_half.ply", "type `half`"),
    ] {
        let said = refusal(&cases.join("ply").join(file));
        assert!(said.contains(words), "{said}");
    }
}
