#![allow(clippy::unwrap_used)]

use glam::DVec3;

use super::*;
use potamoi_base::picture::Picture;
use potamoi_fields::render_float;
use potamoi_fields::voxels::StoredField;

const SIDE: u32 = 64;

fn truth(scene: Analytic, seconds: f64) -> Truth {
    let camera = scene.camera(seconds, SIDE, SIDE);
    scene.truth(&camera, scene.background())
}

fn covered(truth: &Truth) -> f64 {
    let hit = truth.transmittance.iter().filter(|t| **t < 0.5).count();
    hit as f64 / truth.transmittance.len() as f64
}

/// The share of a frame's covered pixels that the camera `seconds` later sees
/// too: in its picture, and with nothing in front.
fn overlap(scene: Analytic, seconds: f64) -> f64 {
    let (from, to) = (truth(scene, 0.0), truth(scene, seconds));
    let [a, b] = [0.0, seconds].map(|t| scene.camera(t, SIDE, SIDE));
    let (mut all, mut seen) = (0, 0);
    for (i, distance) in from.distance.iter().enumerate() {
        if distance.is_infinite() {
            continue;
        }
        all += 1;
        let (origin, direction) = a.ray(i as u32 % SIDE, i as u32 / SIDE);
        let point = origin + direction * *distance;
        let local = b.world_to_camera.transform_point3(point);
        let pixel = local.truncate() / local.z * b.focal + b.centre;
        let inside = |v: f64| (0.0..f64::from(SIDE)).contains(&v);
        if local.z > 0.0 && inside(pixel.x) && inside(pixel.y) {
            // The surface may pass between the centres of pixels.
            let [x, y] = [pixel.x as i64, pixel.y as i64];
            let near = (-1..=1).flat_map(|dx| (-1..=1).map(move |dy| [x + dx, y + dy]));
            let hit = near
                .filter(|p| p.iter().all(|v| (0..i64::from(SIDE)).contains(v)))
                .any(|[x, y]| {
                    let there = to.distance[(y * i64::from(SIDE) + x) as usize];
                    (there - local.length()).abs() < 0.04
                });
            seen += u32::from(hit);
        }
    }
    f64::from(seen) / f64::from(all)
}

fn psnr(a: &Picture, b: &Picture) -> f64 {
    a.psnr(b, |_| true).unwrap()
}

#[test]
fn all_have_names() {
    for scene in Analytic::ALL {
        assert_eq!(Analytic::named(scene.name()), Some(scene));
    }
    assert_eq!(Analytic::named("garden"), None);
}

#[test]
fn models_are_near_the_truth() {
    for (scene, least) in [
        (Analytic::Cairn, 36.0),
        (Analytic::Vase, 27.0),
        (Analytic::Lattice, 25.0),
        (Analytic::Mist, 28.0),
        (Analytic::Moons, 34.0),
        (Analytic::Chrome, 17.0),
        (Analytic::Gallery, 33.0),
        (Analytic::City, 28.0),
    ] {
        let camera = scene.camera(0.0, SIDE, SIDE);
        let field = StoredField::from(scene.bake().unwrap());
        let float = render_float(&field, &camera, scene.background()).unwrap();
        let found = psnr(&float.picture, &truth(scene, 0.0).picture);
        println!("{}: {found:.1} dB", scene.name());
        assert!(found >= least, "{}: {found} dB", scene.name());
    }
}

#[test]
fn half_the_step_gives_the_same_picture() {
    for scene in Analytic::ALL {
        let camera = scene.camera(0.0, 48, 48);
        let [one, half] =
            [1.0, 0.5].map(|s| scene.truth_in_steps(&camera, scene.background(), s).picture);
        let found = psnr(&one, &half);
        println!("{}: {found:.1} dB", scene.name());
        assert!(found > 60.0, "{}: {found} dB", scene.name());
    }
}

#[test]
fn the_truth_does_not_depend_on_the_number_of_threads() {
    for scene in [Analytic::Chrome, Analytic::Moons] {
        let [one, three] = [1, 3].map(|threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
            pool.unwrap()
                .install(|| (truth(scene, 0.0), scene.bake().unwrap()))
        });
        assert!(one == three, "{}", scene.name());
    }
}

#[test]
fn scenes_are_what_they_claim() {
    assert!(covered(&truth(Analytic::Moons, 0.0)) < 0.2);
    assert!((0.2..0.5).contains(&covered(&truth(Analytic::Lattice, 0.0))));
    assert_eq!(covered(&truth(Analytic::Gallery, 0.0)), 1.0);
    // Fog: a good part of the light is neither all taken nor all left.
    let mist = truth(Analytic::Mist, 0.0).transmittance;
    let partly = mist.iter().filter(|t| (0.02..0.98).contains(*t)).count();
    assert!(partly * 20 > mist.len(), "{partly}");
    // A mirror's colour is its direction's, a stone's is not.
    let away = DVec3::new(0.3, 0.6, 0.7).normalize();
    let change = |scene: Analytic, p| {
        let look = scene.look(p);
        (look.along(away) - look.along(DVec3::Y))
            .abs()
            .max_element()
    };
    assert!(change(Analytic::Chrome, DVec3::new(0.02, -0.28, 0.5)) > 0.2);
    assert_eq!(change(Analytic::Cairn, DVec3::new(0.0, -0.5, 0.3)), 0.0);
    let rods = Analytic::Lattice;
    assert!(rods.density(DVec3::ZERO) > 0.0);
    assert_eq!(rods.density(DVec3::splat(0.1)), 0.0);
}

#[test]
fn thirty_frames_a_second_overlap_and_one_does_not() {
    for scene in Analytic::ALL {
        let [fast, slow] = [1.0 / 30.0, 1.0].map(|t| overlap(scene, t));
        println!("{}: {fast:.3} at 30 FPS, {slow:.3} at 1 FPS", scene.name());
        assert!(
            fast > 0.9 && slow < 0.93 && slow < fast - 0.06,
            "{}: {fast} {slow}",
            scene.name()
        );
    }
}
