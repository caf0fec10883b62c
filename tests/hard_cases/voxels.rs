//! Voxels seen so that rays are parallel to axes, in faces, and samples lie on faces.

use glam::DVec3;
use potamoi_base::camera::Camera;
use potamoi_base::picture::Picture;
use potamoi_fields::voxels::{Formats, Grid, Layout, STOP_BELOW, StoredField, error_bounds};
use potamoi_fields::{AnyField, FixedField, FixedOptions, render_float};
use potamoi_formats::config::Config;
use potamoi_march::FixedFrame;
use potamoi_reference::bounds::VectorBounds;
use potamoi_reference::{ReferenceUnits, Units};
use potamoi_rtl::RtlUnits;
use potamoi_scene::Model;

use super::modelled::Case;
use super::sampled::farthest;

const POINTS: [usize; 3] = [9, 16, 15];
const SIDE: u32 = 17;

fn grid() -> Grid {
    Grid::bake(POINTS, DVec3::ZERO, 1.0, Layout::Constant, |at, out| {
        out[0] = (0.2 + 0.15 * (at.x + 0.7 * at.z).sin()) as f32;
        for (c, v) in out[1..].iter_mut().enumerate() {
            *v = (0.5 + 0.4 * (at.y * 0.5 + c as f64).cos()) as f32;
        }
    })
    .unwrap()
}

/// Along z; the middle column's rays lie in the volume's first face, in a face of MVoxels, or in
/// one of voxels, and the middle ray is parallel to the axis.
fn cameras() -> [Camera; 3] {
    [0.0, 7.0, 4.0].map(|x| {
        let eye = DVec3::new(x, 7.0, -3.0);
        Camera::look_at(eye, eye + DVec3::Z, DVec3::NEG_Y, 0.5, SIDE, SIDE)
    })
}

/// Steps of whole voxels from the first face: every sample of the middle ray is on a face.
const STEP: f64 = 1.0;

fn fixed(camera: &Camera, units: &mut dyn Units) -> FixedFrame {
    let (field, config) = (field(), Config::paper());
    let made = FixedField::new(&field, &config).unwrap();
    made.render(camera, &FixedOptions::default(), units)
        .unwrap()
}

fn field() -> StoredField {
    StoredField::new(grid(), STEP)
}

/// What each camera sees, to be modelled.
pub(crate) fn cases() -> Vec<Case> {
    let one = |camera: Camera| Case {
        name: "voxels",
        picture: fixed(&camera, &mut ReferenceUnits::new(&Config::paper())).picture,
        camera,
        step: Some(STEP),
        config: Config::paper(),
        model: Model::Field(AnyField::new(field())),
    };
    cameras().map(one).to_vec()
}

/// What a sample counts for, by where it is.
type Owners = fn(DVec3) -> f64;

/// Slabs by division, compared as they come; then the samples, each as often as it has owners.
fn obvious(camera: &Camera, owners: Owners, careful: bool) -> Picture {
    let grid = grid();
    let last = DVec3::from(POINTS.map(|p| (p - 1) as f64));
    let mut picture = Picture::filled(SIDE, SIDE, [0.0; 3]);
    for (i, pixel) in picture.rgb.iter_mut().enumerate() {
        let (origin, direction) = camera.ray(i as u32 % SIDE, i as u32 / SIDE);
        let (mut near, mut far) = (0f64, f64::INFINITY);
        for axis in 0..3 {
            if careful && direction[axis] == 0.0 {
                continue;
            }
            let a = -origin[axis] / direction[axis];
            let b = (last[axis] - origin[axis]) / direction[axis];
            let (a, b) = if a < b { (a, b) } else { (b, a) };
            near = if a > near { a } else { near };
            far = if b < far { b } else { far };
        }
        let mut left = 1.0;
        let mut values = [0.0; 4];
        let samples = if far >= near && far.is_finite() {
            ((far - near) / STEP) as u32 + 1
        } else {
            0
        };
        for k in 0..samples {
            let at = origin + direction * (near + f64::from(k) * STEP);
            grid.sample(at, &mut values);
            let alpha = -(-values[0].max(0.0) * STEP * owners(at)).exp_m1();
            for (sum, v) in pixel.iter_mut().zip(&values[1..]) {
                *sum += (left * alpha * v) as f32;
            }
            left *= 1.0 - alpha;
            if left < 1e-3 {
                break;
            }
        }
    }
    picture
}

/// A sample that is in several MVoxels, faces included, counts in each.
fn each(at: DVec3) -> f64 {
    let along = |v: f64| if v > 0.0 && v % 7.0 == 0.0 { 2.0 } else { 1.0 };
    along(at.x) * along(at.y) * along(at.z)
}

pub(crate) struct Measured {
    pub(crate) divided: f64,
    pub(crate) owned_twice: f64,
    pub(crate) fixed: f64,
    /// The largest difference of a pixel of ours, and what it may be.
    pub(crate) farthest: f64,
    pub(crate) bound: f64,
}

pub(crate) fn measure() -> Measured {
    let mut least = Measured {
        divided: f64::INFINITY,
        owned_twice: f64::INFINITY,
        fixed: f64::INFINITY,
        farthest: 0.0,
        bound: 0.0,
    };
    let config = Config::paper();
    let formats = Formats::new(&grid(), &config).unwrap();
    for camera in cameras() {
        let float = render_float(&field(), &camera, [0.0; 3]).unwrap().picture;
        let psnr = |p: &Picture| p.psnr(&float, |_| true).unwrap();
        // With owners counted rightly and parallel rays told apart it is the same picture.
        let same = psnr(&obvious(&camera, |_| 1.0, true));
        assert!(same > 120.0, "{same}");
        least.divided = least.divided.min(psnr(&obvious(&camera, |_| 1.0, false)));
        least.owned_twice = least.owned_twice.min(psnr(&obvious(&camera, each, true)));
        let mut twins = ReferenceUnits::new(&config);
        let ours = fixed(&camera, &mut twins).picture;
        least.fixed = least.fixed.min(psnr(&ours));
        let bounds = error_bounds(
            &field(),
            &formats,
            &VectorBounds::by_formula(&config.vu.exp),
            &camera,
            &FixedOptions::default(),
            STOP_BELOW,
        );
        let bounds = bounds.iter().map(|[colour, _]| *colour);
        least.farthest = f64::max(least.farthest, farthest(&ours, &float, bounds.clone()));
        least.bound = bounds.fold(least.bound, f64::max);
        assert_eq!(twins.gather_flags(), 0);
    }
    least
}

#[test]
fn rays_in_faces_and_samples_on_them_keep_their_promise() {
    let Measured {
        divided,
        owned_twice,
        fixed,
        farthest,
        bound,
    } = measure();
    println!("{fixed:.1} dB; by division {divided:.1}, owned twice {owned_twice:.1}");
    assert!(fixed >= 80.0, "{fixed}");
    assert!(farthest <= bound);
    assert!(
        divided < 70.0 && owned_twice < 70.0,
        "{divided} {owned_twice}"
    );
}

#[test]
fn the_hardware_samples_the_same_faces() {
    let mut rtl = RtlUnits::new(&Config::paper());
    for camera in cameras() {
        assert_eq!(
            fixed(&camera, &mut rtl),
            fixed(&camera, &mut ReferenceUnits::new(&Config::paper()))
        );
    }
    assert_eq!(rtl.gather_flags(), 0);
}
