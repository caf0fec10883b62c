//! Antialiased training, and the filters of Mip-Splatting.

use glam::{DMat2, DMat3, DQuat, DVec2, DVec3};
use potamoi_base::sh;
use potamoi_formats::config::Config;
use potamoi_reference::ReferenceUnits;

use super::write::{Ply, Shape, Spz, archive, members};
use super::*;

/// Log scales of Gaussians below a pixel, of which antialiasing takes most.
const THIN: f64 = -6.0;

/// A renderer of its own: every Gaussian at every pixel, covariances and determinants as matrices.
fn plain(shape: &Shape, camera: &Camera, antialiased: bool) -> Picture {
    let turn = camera.world_to_camera;
    let mut all = vec![];
    for i in 0..shape.centres.len() {
        let world = DVec3::from(shape.centres[i]);
        let view = turn.transform_point3(world);
        let [w, x, y, z] = shape.rotations[i];
        let axes = DMat3::from_quat(DQuat::from_xyzw(x, y, z, w).normalize())
            * DMat3::from_diagonal(DVec3::from(shape.scales[i].map(f64::exp)));
        let axes = turn.matrix3 * axes;
        let covariance = axes * axes.transpose();
        let [fx, fy] = camera.focal.to_array();
        let rows = [
            DVec3::new(fx / view.z, 0.0, -fx * view.x / view.z.powi(2)),
            DVec3::new(0.0, fy / view.z, -fy * view.y / view.z.powi(2)),
        ];
        let at = |a: usize, b: usize| rows[a].dot(covariance * rows[b]);
        let own = DMat2::from_cols(
            DVec2::new(at(0, 0), at(1, 0)),
            DVec2::new(at(0, 1), at(1, 1)),
        );
        let dilated = own + DMat2::from_diagonal(DVec2::splat(0.3));
        let mut opacity = 1.0 / (1.0 + (-shape.opacities[i]).exp());
        if antialiased {
            opacity *= (own.determinant() / dilated.determinant()).sqrt();
        }
        let towards = (world - camera.position()).normalize();
        let basis = sh::basis(towards);
        let colour = shape.colours[i].map(|own| {
            let sum: f64 = own.iter().zip(basis).map(|(c, b)| c * b).sum();
            (sum + 0.5).max(0.0)
        });
        let mean = DVec2::new(fx * view.x / view.z, fy * view.y / view.z) + camera.centre - 0.5;
        all.push((view.z, mean, dilated.inverse(), opacity, colour));
    }
    all.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut picture = Picture::filled(camera.width, camera.height, [0.0; 3]);
    for (at, rgb) in picture.rgb.iter_mut().enumerate() {
        let pixel = DVec2::new(
            (at as u32 % camera.width).into(),
            (at as u32 / camera.width).into(),
        );
        let (mut light, mut sum) = (1.0, [0.0; 3]);
        for (_, mean, inverse, opacity, colour) in &all {
            let off = pixel - *mean;
            let alpha = (opacity * (-0.5 * off.dot(*inverse * off)).exp()).min(0.99);
            if alpha < 1.0 / 255.0 {
                continue;
            }
            for (sum, colour) in sum.iter_mut().zip(colour) {
                *sum += light * alpha * colour;
            }
            light *= 1.0 - alpha;
        }
        *rgb = sum.map(|v| v as f32);
    }
    picture
}

#[test]
fn opacities_fall_by_what_the_pixel_filter_adds() {
    let folder = tempfile::tempdir().unwrap();
    let shape = Shape::new(THIN);
    let [without, truth] = [false, true].map(|aa| plain(&shape, &camera(), aa));
    let ply = Ply::of(&shape);
    let dull = picture(&ply.write(folder.path(), "dull.ply"));
    tells_apart(&dull, &without, &truth, LOSSLESS);
    for line in [
        "comment SplatRenderMode: mip",
        "comment splatrendermode:MIP",
        "comment antialiased 1",
        "comment antialiased: true",
        "obj_info antialiased=1",
    ] {
        let path = ply
            .clone()
            .line(line.as_bytes())
            .write(folder.path(), "a.ply");
        tells_apart(&picture(&path), &truth, &without, LOSSLESS);
        assert!(notes(&path).not_used().is_empty(), "{line}");
    }
    for line in ["comment SplatRenderMode: default", "comment antialiased 0"] {
        let path = ply
            .clone()
            .line(line.as_bytes())
            .write(folder.path(), "a.ply");
        assert_eq!(picture(&path).rgb, dull.rgb, "{line}");
    }
    for lines in [
        &["comment SplatRenderMode: other"][..],
        &["comment antialiased 2"],
        &["comment antialiased"],
        &["comment antialiased 1", "comment SplatRenderMode: default"],
    ] {
        let all = lines
            .iter()
            .fold(ply.clone(), |ply, line| ply.line(line.as_bytes()));
        let said = refusal(&all.write(folder.path(), "a.ply"));
        assert!(said.contains("`comment "), "{said}");
    }
    // Words that only begin alike say nothing of it.
    let line = b"comment antialiasedness 1";
    let path = ply.clone().line(line).write(folder.path(), "a.ply");
    assert_eq!(picture(&path).rgb, dull.rgb);
    assert_eq!(notes(&path).not_used(), ["comment antialiasedness 1"]);

    for version in 1..=4 {
        let mut spz = Spz::new(version);
        spz.flags = 1;
        let path = write(folder.path(), "a.spz", &spz.bytes(&shape, true));
        tells_apart(&picture(&path), &truth, &without, ROUNDED);
    }
    // What a description says goes first.
    for (file, says, expected) in [("a.spz", false, &without), ("dull.ply", true, &truth)] {
        let text = format!(
            "[model]\nkind = \"splats\"\npath = \"{file}\"\n[render]\nantialiased = {says}\n"
        );
        let other = if says { &without } else { &truth };
        let path = write(folder.path(), "scene.toml", text.as_bytes());
        tells_apart(&picture(&path), expected, other, ROUNDED);
    }
}

#[test]
fn sog_says_it_by_two_fields() {
    let folder = tempfile::tempdir().unwrap();
    let fixture = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../tests/fixtures/splats/cloud.sog"
    );
    let all = members(&std::fs::read(fixture).unwrap());
    let with = |fields: &str| {
        let mut all = all.clone();
        let meta = &mut all.iter_mut().find(|(n, _)| n == "meta.json").unwrap().1;
        let text = String::from_utf8(meta.clone()).unwrap();
        *meta = text.replacen('{', &format!("{{{fields}"), 1).into_bytes();
        write(folder.path(), "a.sog", &archive(&all))
    };
    for (fields, expected) in [
        ("", false),
        ("\"antialias\":false,", false),
        ("\"antialias\":true,", true),
        ("\"model\":\"antialiased\",", true),
        ("\"model\":\"default\",", false),
        ("\"antialias\":true,\"model\":\"antialiased\",", true),
    ] {
        let path = with(fields);
        assert_eq!(open(&path).is_antialiased(), expected, "{fields}");
        assert_eq!(
            notes(&path).not_used(),
            notes(Path::new(fixture)).not_used()
        );
    }
    for fields in [
        "\"antialias\":1,",
        "\"model\":\"other\",",
        "\"antialias\":false,\"model\":\"antialiased\",",
    ] {
        let said = refusal(&with(fields));
        assert!(
            said.contains("field `antialias`") || said.contains("field `model`"),
            "{said}"
        );
    }
}

/// In the hardware's formats too, within the bounds that are derived for them.
#[test]
fn records_hold_what_is_left_of_opacities() {
    let folder = tempfile::tempdir().unwrap();
    let shape = Shape::new(THIN);
    let path = (Ply::of(&shape).line(b"comment antialiased 1")).write(folder.path(), "a.ply");
    let mut scene = open(&path);
    scene.set_camera(camera());
    let config = Config::paper();
    let bounds = scene.error_bounds(&config).unwrap().unwrap();
    let float = scene.render_float().unwrap().picture;
    let fixed = scene.render_fixed(&config, &mut ReferenceUnits::new(&config));
    let fixed = fixed.unwrap().picture;
    for ((a, b), bound) in fixed.rgb.iter().zip(&float.rgb).zip(&bounds) {
        for (a, b) in a.iter().zip(b) {
            let off = f64::from((a - b).abs());
            assert!(off <= *bound, "{off} {bound}");
        }
    }
    let [without, truth] = [false, true].map(|aa| plain(&shape, &camera(), aa));
    tells_apart(&fixed, &truth, &without, LOSSLESS);
}

/// The filter in space of Mip-Splatting is fused: variances grow by its square, and opacities fall
/// by the ratio of the volumes.
#[test]
fn filters_in_space_are_fused() {
    let folder = tempfile::tempdir().unwrap();
    let shape = Shape::new(-4.0);
    let widths: Vec<f64> = (0..shape.centres.len())
        .map(|i| 0.01 + 0.0005 * i as f64)
        .collect();
    let mut fused = shape.clone();
    for (i, width) in widths.iter().enumerate() {
        let mut volumes = 1.0;
        for scale in &mut fused.scales[i] {
            let own = (2.0 * *scale).exp();
            volumes *= own / (own + width * width);
            *scale = 0.5 * (own + width * width).ln();
        }
        let opacity = volumes.sqrt() / (1.0 + (-shape.opacities[i]).exp());
        fused.opacities[i] = (opacity / (1.0 - opacity)).ln();
    }
    let truth = picture(&Ply::of(&fused).write(folder.path(), "truth.ply"));
    let dropped = picture(&Ply::of(&shape).write(folder.path(), "dropped.ply"));
    let mut ply = Ply::of(&shape);
    ply.columns.push(("float", "filter_3D".to_owned(), widths));
    let path = ply.write(folder.path(), "a.ply");
    tells_apart(&picture(&path), &truth, &dropped, LOSSLESS);
    for (value, says) in [(-0.1, "-0.1"), (f64::NAN, "NaN")] {
        ply.column("filter_3D").2[7] = value;
        let said = refusal(&ply.write(folder.path(), "a.ply"));
        assert!(
            said.contains("vertex 7, property `filter_3D` is") && said.contains(says),
            "{said}"
        );
    }
    ply.column("filter_3D").0 = "uchar";
    let said = refusal(&ply.write(folder.path(), "a.ply"));
    assert!(said.contains("`filter_3D` is uchar"), "{said}");
}
