//! Warped frames made of one case each: surfaces at one depth that fight for a pixel, and depths
//! that are none.

use glam::{DAffine3, DVec2, DVec3};
use potamoi_base::camera::Camera;
use potamoi_base::picture::Picture;
use potamoi_warp::{Shaded, reproject};

use super::sampled::Shown;
use potamoi_analysis::hard_cases::pictures::SIZE;

/// Pixels of the reference a pixel, along each axis.
const FINER: u32 = 4;

fn camera(finer: u32, shift: DVec3) -> Camera {
    let [width, height] = SIZE.map(|pixels| pixels * finer);
    Camera {
        width,
        height,
        focal: DVec2::splat(30.0 * f64::from(finer)),
        centre: DVec2::new(f64::from(width), f64::from(height)) / 2.0,
        world_to_camera: DAffine3::from_translation(shift),
    }
}

/// Sixteen points a pixel; a chequered plane, its depth as asked for.
fn reference(depth: impl Fn(u32) -> f32) -> Shaded {
    let [width, height] = SIZE.map(|pixels| pixels * FINER);
    let mut picture = Picture::filled(width, height, [0.0; 3]);
    for (i, pixel) in (0..).zip(&mut picture.rgb) {
        let [x, y] = [i % width, i / width];
        let wave = (x as f32 / 9.0).sin() * (y as f32 / 7.0).cos();
        *pixel = match (x + y) % 2 {
            0 => [0.6 + 0.3 * wave, 0.3, 0.1],
            _ => [0.1, 0.3, 0.6 - 0.3 * wave],
        };
    }
    let depth = (0..width * height).map(depth).collect();
    Shaded { picture, depth }
}

/// Each pixel its nearest point's colour; black where none is.
fn ours(reference: &Shaded, from: &Camera, to: &Camera) -> Picture {
    let warped = reproject(reference, from, to);
    let mut picture = Picture::filled(to.width, to.height, [0.0; 3]);
    for (i, pixel) in picture.rgb.iter_mut().enumerate() {
        if let Some((point, _)) = warped.at(i) {
            *pixel = reference.picture.rgb[point as usize];
        }
    }
    picture
}

/// Points one after the other through a z-buffer; `careful` leaves out what is no surface and
/// what is behind the camera, and takes the first of equals, whatever the order.
fn one_by_one(reference: &Shaded, from: &Camera, to: &Camera, careful: bool) -> Picture {
    let mut nearest = vec![None::<(f64, usize)>; (to.width * to.height) as usize];
    let shift = to.world_to_camera.translation - from.world_to_camera.translation;
    let points = reference.depth.iter().enumerate().rev();
    for (i, depth) in points {
        if careful && !(depth.is_finite() && *depth > 0.0) {
            continue;
        }
        let pixel = DVec2::new(
            (i % from.width as usize) as f64 + 0.5,
            (i / from.width as usize) as f64 + 0.5,
        );
        let ray = ((pixel - from.centre) / from.focal).extend(1.0);
        let point = ray * f64::from(*depth) + shift;
        if careful && point.z <= 0.0 {
            continue;
        }
        let at = point.truncate() / point.z * to.focal + to.centre;
        // A cast takes NaN and what is below 0 to 0.
        let [x, y] = [at.x as usize, at.y as usize];
        let inside = !careful || (at.x >= 0.0 && at.y >= 0.0);
        if !inside || x >= to.width as usize || y >= to.height as usize {
            continue;
        }
        let own = &mut nearest[y * to.width as usize + x];
        // The careful form rounds depths as pictures hold them; points come backwards, and of
        // equals the first of the reference is to stay.
        let z = f64::from(point.z as f32);
        let wins = match own {
            None => true,
            Some((least, _)) if careful => z <= *least,
            Some((least, _)) => z < *least,
        };
        if wins {
            *own = Some((z, i));
        }
    }
    let mut picture = Picture::filled(to.width, to.height, [0.0; 3]);
    for (pixel, point) in picture.rgb.iter_mut().zip(nearest) {
        if let Some((_, i)) = point {
            *pixel = reference.picture.rgb[i];
        }
    }
    picture
}

fn row([scene, case, form]: [&'static str; 3], reference: &Shaded, shift: DVec3) -> Shown {
    let (from, to) = (camera(FINER, DVec3::ZERO), camera(1, shift));
    let float = one_by_one(reference, &from, &to, true);
    let ours = ours(reference, &from, &to);
    Shown {
        scene,
        case,
        form,
        naive: one_by_one(reference, &from, &to, false),
        // Nothing is rounded: every pixel is a point of the reference, and the right one.
        farthest: super::sampled::farthest(&ours, &float, std::iter::repeat(0.0)),
        bound: 0.0,
        ours,
        float,
    }
}

pub(crate) fn shown() -> Vec<Shown> {
    let odd = [0.0, -0.0, f32::INFINITY, f32::NEG_INFINITY, f32::NAN, -1.0];
    let [width, _] = SIZE.map(|pixels| pixels * FINER);
    let patchy = |i: u32| {
        let [x, y] = [i % width, i / width];
        match (x / 12 + y / 12) % 3 {
            0 => odd[(x + 5 * y) as usize % odd.len()],
            _ => 3.0,
        }
    };
    vec![
        row(
            [
                "fighting",
                "surfaces at one depth, 16 points a pixel",
                "a z-buffer in the order of points, run backwards",
            ],
            &reference(|_| 3.0),
            DVec3::ZERO,
        ),
        row(
            [
                "no-depth",
                "warped depths of 0, infinity, NaN and below 0",
                "the equations as they stand, casts to pixels",
            ],
            &reference(patchy),
            DVec3::new(0.02, -0.01, 0.3),
        ),
    ]
}
