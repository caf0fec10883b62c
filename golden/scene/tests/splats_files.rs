//! Real splat files of different formats that hold the same Gaussians.

use std::path::{Path, PathBuf};

use potamoi_formats::config::Config;
use potamoi_gaussians::{Cloud, files};
use potamoi_reference::ReferenceUnits;
use potamoi_scene::Scene;

use crate::splats_common::shared;

/// A file of the shared data, where there is one.
fn real(name: &str) -> Option<PathBuf> {
    let found = shared().map(|data| data.join(name));
    if found.is_none() {
        println!("skipped: no shared data for {name}");
    }
    found
}

fn read(path: &Path) -> Result<Cloud, files::FileError> {
    files::read(path, None).map(|loaded| loaded.cloud)
}

/// The largest differences of two clouds with the same order.
#[derive(Debug, Default)]
struct Differences {
    mean: f64,
    log_scale: f64,
    /// Of components of unit quaternions, signs aside.
    rotation: f64,
    /// Of opacities.
    opacity: f64,
    /// Of the constant coefficient, band 1, 2 and 3.
    bands: [f64; 4],
}

/// Log scales are held at `least` first.
fn differences(a: &Cloud, b: &Cloud, least: f32) -> Differences {
    assert_eq!(a.len(), b.len());
    let mut d = Differences::default();
    let sigmoid = |x: f32| 1.0 / (1.0 + (-f64::from(x)).exp());
    let raise = |most: &mut f64, off: f64| *most = most.max(off.abs());
    for i in 0..a.len() {
        for k in 0..3 {
            raise(
                &mut d.mean,
                f64::from(a.means()[i][k]) - f64::from(b.means()[i][k]),
            );
            let [s, t] = [a, b].map(|c| f64::from(c.log_scales()[i][k].max(least)));
            raise(&mut d.log_scale, s - t);
            for (c, (x, y)) in a.sh(i).iter().zip(b.sh(i)).enumerate() {
                raise(&mut d.bands[c.isqrt()], f64::from(x[k]) - f64::from(y[k]));
            }
        }
        let [p, q] = [a, b].map(|c| {
            let q = c.rotations()[i].map(f64::from);
            q.map(|v| v / q.iter().map(|v| v * v).sum::<f64>().sqrt())
        });
        let sign = p.iter().zip(&q).map(|(a, b)| a * b).sum::<f64>().signum();
        for (x, y) in p.into_iter().zip(q) {
            raise(&mut d.rotation, x - sign * y);
        }
        let [o, p] = [a, b].map(|c| sigmoid(c.opacity_logits()[i]));
        raise(&mut d.opacity, o - p);
    }
    d
}

/// The SPZ file was made from the packed PLY file: SPZ's steps alone lie
/// between them.
#[test]
fn bikers_agree() {
    let Some(folder) = real("splats/biker") else {
        return;
    };
    let ply = read(&folder.join("biker.compressed.ply")).unwrap();
    let spz = read(&folder.join("biker.spz")).unwrap();
    assert_eq!((ply.len(), ply.degree()), (152_746, 0));
    let infinite = |c: &Cloud| {
        c.opacity_logits()
            .iter()
            .filter(|l| l.is_infinite())
            .count()
    };
    assert_eq!((infinite(&ply), infinite(&spz)), (198, 198));
    // SPZ holds scales from e^-10 on.
    let d = differences(&ply, &spz, -10.0);
    println!("{d:?}");
    let rounding = 1e-6;
    assert!(d.mean <= 0.5 / 4096.0 + rounding);
    assert!(d.log_scale <= 0.5 / 16.0 + rounding);
    // Half a step for three components, and what that makes of the largest,
    // which is at least 1/2: (a + b + c) / d times it, at most 3 times.
    assert!(d.rotation <= 3.0 * 0.5 / 511.0 / 2f64.sqrt());
    assert_eq!(d.opacity, 0.0);
    assert!(d.bands[0] <= 0.5 / 255.0 / 0.15 + rounding);
}

#[test]
fn bikers_look_the_same() {
    let Some(folder) = real("splats/biker") else {
        return;
    };
    let camera = real("cameras/camera_biker_800.json").unwrap();
    let [ply, spz] = ["biker.compressed.ply", "biker.spz"].map(|file| {
        let mut scene = Scene::open(folder.join(file).to_str().unwrap()).unwrap();
        scene.set_camera_file(&camera, 0).unwrap();
        scene.set_size(Some(400), Some(400)).unwrap();
        scene.render_float().unwrap()
    });
    let covered = ply.picture.psnr(&spz.picture, |i| ply.covered[i]).unwrap();
    let all = ply.picture.psnr(&spz.picture, |_| true).unwrap();
    let share = ply.covered.iter().filter(|c| **c).count() as f64 / 160_000.0;
    println!(
        "{all:.2} dB, {covered:.2} dB over the {:.0} % covered",
        100.0 * share
    );
    assert!(all > 40.0 && covered > 40.0 && share > 0.1);
    if let Some(out) = std::env::var_os("POTAMOI_PICTURES") {
        let out = PathBuf::from(out);
        ply.picture.write_png(&out.join("biker_ply.png")).unwrap();
        spz.picture.write_png(&out.join("biker_spz.png")).unwrap();
    }
}

/// Opacities of exactly 1, which packed files hold, pass through the units,
/// held at the largest that a record has.
#[test]
fn opacities_of_one_pass_through_the_units() {
    let Some(folder) = real("splats/biker") else {
        return;
    };
    let camera = real("cameras/camera_biker_800.json").unwrap();
    let mut scene = Scene::open(folder.join("biker.spz").to_str().unwrap()).unwrap();
    scene.set_camera_file(&camera, 0).unwrap();
    scene.set_size(Some(100), None).unwrap();
    let config = Config::paper();
    let float = scene.render_float().unwrap();
    let fixed = scene.render_fixed(&config, &mut ReferenceUnits::new(&config));
    let fixed = fixed.unwrap();
    assert_eq!(fixed.counts.splats.unwrap().saturated, 198);
    let decibels = fixed.picture.psnr(&float.picture, |_| true).unwrap();
    println!("{decibels:.1} dB over the frame");
    assert!(decibels >= 80.0);
}

#[test]
fn three_points_agree() {
    let Some(folder) = real("splats/three_points") else {
        return;
    };
    let [ply, splat, spz] = ["ply", "splat", "spz"]
        .map(|ending| read(&folder.join(format!("three_points.{ending}"))).unwrap());
    let rounding = 1e-6;

    // Floats for means and scales; bytes, cut, of the rest.
    let d = differences(&ply, &splat, f32::MIN);
    println!("{d:?}");
    assert_eq!(d.mean, 0.0);
    assert!(d.log_scale <= rounding);
    assert!(d.rotation <= 1.0 / 128.0 + rounding);
    assert!(d.opacity <= 1.0 / 255.0 && d.bands[0] <= 1.0 / 255.0 / 0.282);

    let d = differences(&ply, &spz, -10.0);
    println!("{d:?}");
    assert!(d.mean <= 0.5 / 4096.0 + rounding && d.log_scale <= 0.5 / 16.0 + rounding);
    assert!(d.rotation <= 3.0 * 0.5 / 511.0 / 2f64.sqrt());
    assert!(d.opacity <= 0.5 / 255.0 + rounding);
    assert!(d.bands[0] <= 0.5 / 255.0 / 0.15 + rounding);
    // 5 bits for band 1 and 4 for the others, after rounding to 8.
    assert!(d.bands[1] <= 4.5 / 128.0 + rounding);
    assert!(d.bands[2] <= 8.5 / 128.0 + rounding && d.bands[3] <= 8.5 / 128.0 + rounding);
    assert!(d.bands[3] > 0.0 && spz.degree() == 3);
}

/// The PLY file was made from the SOG folder by another reader: not a bit
/// apart, but for the rounding of its exponential and its square root.
#[test]
fn playbots_agree() {
    let Some(folder) = real("splats") else {
        return;
    };
    let ply = read(&folder.join("playbot_8k.ply")).unwrap();
    let sog = read(&folder.join("playbot_8k_sog")).unwrap();
    assert_eq!((ply.len(), ply.degree()), (8406, 2));
    let d = differences(&ply, &sog, f32::MIN);
    println!("{d:?}");
    assert!(
        d.mean <= 1e-6 && d.rotation <= 1e-6 && d.opacity <= 2e-6,
        "{d:?}"
    );
    assert!(d.log_scale == 0.0 && d.bands == [0.0; 4], "{d:?}");
}
