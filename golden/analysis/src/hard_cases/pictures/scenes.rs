//! Scenes of splats, each made of one hard case, seen along z from the origin, y down.

use glam::{DVec2, DVec3};
use potamoi_base::camera::Camera;
use potamoi_gaussians::{Cloud, CloudError};

use super::form::Form;

/// Width and height of their pictures in pixels.
pub const SIZE: [u32; 2] = [33, 25];
/// Their focal length in pixels.
pub const FOCAL: f64 = 30.0;

/// A Gaussian as files have it.
#[derive(Debug, Clone, Copy)]
pub struct Gaussian {
    /// Place.
    pub mean: [f32; 3],
    /// Logarithms of the standard deviations.
    pub log_scale: [f32; 3],
    /// Quaternion w, x, y, z, of any length.
    pub rotation: [f32; 4],
    /// Logit of the opacity.
    pub logit: f32,
    /// Coefficients of degree 0.
    pub colour: [f32; 3],
}

/// A scene of splats made of one hard case.
#[derive(Debug, Clone)]
pub struct HardScene {
    /// A name for files and the table.
    pub name: &'static str,
    /// What is hard about it.
    pub case: &'static str,
    /// The obvious form, and the order of the file that it meets.
    pub form: Form,
    /// What it is made of.
    pub gaussians: Vec<Gaussian>,
    /// What the formats promise over its frame, in dB.
    pub promise: f64,
}

/// Their camera.
#[must_use]
pub fn camera() -> Camera {
    let [width, height] = SIZE;
    let mut camera = Camera::look_at(DVec3::ZERO, DVec3::Z, DVec3::NEG_Y, 1.0, width, height);
    camera.focal = DVec2::splat(FOCAL);
    camera
}

const BALL: Gaussian = Gaussian {
    mean: [0.0, 0.0, 3.0],
    log_scale: [-2.0; 3],
    rotation: [1.0, 0.0, 0.0, 0.0],
    logit: 1.0,
    colour: [0.8, 0.2, -0.3],
};

/// Several of one sort, each with a number of its own from 0 to 1 and another colour.
fn many(n: usize, one: impl Fn(f32) -> Gaussian) -> Vec<Gaussian> {
    let colour = |i: usize| [0, 1, 2].map(|c| ((i * 7 + c * 5) % 11) as f32 / 5.0 - 0.8);
    (0..n)
        .map(|i| Gaussian {
            colour: colour(i),
            ..one(i as f32 / n as f32)
        })
        .collect()
}

/// Turned by an angle about the view.
fn about_z(angle: f32) -> [f32; 4] {
    [(angle / 2.0).cos(), 0.0, 0.0, (angle / 2.0).sin()]
}

/// Thirty times longer than the frame is wide, and thinner than the dilation.
fn needles() -> Vec<Gaussian> {
    many(18, |u| Gaussian {
        mean: [1.2 * u - 0.6, 0.9 * (9.0 * u).sin(), 2.0 + u],
        log_scale: [4.5, -9.0, -9.0],
        rotation: about_z(3.1 * u),
        logit: 0.5,
        ..BALL
    })
}

/// Larger than the frame by thousands, their means aside.
fn giants() -> Vec<Gaussian> {
    many(14, |u| Gaussian {
        mean: [
            300.0 * (40.0 * u).sin(),
            200.0 * (23.0 * u).cos(),
            2.0 + 3.0 * u,
        ],
        log_scale: [7.0 - 2.0 * u, 5.0, -3.0],
        rotation: [(9.0 * u).sin(), (5.0 * u).cos(), 0.3, 0.8 * u],
        logit: -1.0,
        ..BALL
    })
}

/// Behind, at, on the near plane of, and just before the camera.
fn near() -> Vec<Gaussian> {
    let depths = [
        -3.0, -0.2, -1e-30, 0.0, 1e-30, 0.05, 0.199_999, 0.2, 0.201, 0.21, 0.4, 2.0,
    ];
    many(depths.len(), |u| {
        let z = depths[(u * depths.len() as f32).round() as usize];
        Gaussian {
            mean: [0.3 * z * (9.0 * u).sin(), 0.2 * z, z],
            log_scale: [-3.0, -2.0, -4.0],
            logit: 0.0,
            ..BALL
        }
    })
}

/// One over the other at exactly one depth.
fn ties() -> Vec<Gaussian> {
    many(10, |u| Gaussian {
        mean: [0.2 * (60.0 * u).sin(), 0.2 * (60.0 * u).cos(), 3.0],
        log_scale: [-0.8; 3],
        logit: 0.5,
        ..BALL
    })
}

/// Discs and sticks without any thickness, on edge and from above.
fn flat() -> Vec<Gaussian> {
    many(16, |u| Gaussian {
        mean: [1.6 * u - 0.8, 0.5 * (7.0 * u).cos(), 2.0 + u],
        log_scale: if u < 0.5 {
            [-0.5, -0.5, -90.0]
        } else {
            [0.3, -90.0, -90.0]
        },
        rotation: [0.7, 0.7 * (1.0 - u), 0.1 * u, 0.7 * u],
        logit: 1.5,
        ..BALL
    })
}

/// Nothing, all, and the least that counts.
fn none_and_all() -> Vec<Gaussian> {
    let logits = [
        f32::INFINITY,
        f32::NEG_INFINITY,
        -1e30,
        1e30,
        -5.538,
        -5.541,
        89.0,
        -104.0,
    ];
    many(logits.len(), |u| Gaussian {
        mean: [1.5 * u - 0.7, 0.0, 2.0 + u],
        log_scale: [-1.5; 3],
        logit: logits[(u * logits.len() as f32).round() as usize],
        ..BALL
    })
}

/// Of no length and of any: the same turns.
fn quaternions() -> Vec<Gaussian> {
    let lengths = [0.0, 1e30, 1e-30, 3e38, 1e-38, 1.0, 7.0];
    many(lengths.len(), |u| {
        let length = lengths[(u * lengths.len() as f32).round() as usize];
        Gaussian {
            mean: [1.6 * u - 0.7, 0.1, 2.5],
            log_scale: [-0.5, -2.5, -2.5],
            rotation: [0.5, 0.1, -0.2, 0.6].map(|v| v * length),
            logit: 2.0,
            ..BALL
        }
    })
}

/// Hundreds of faint layers.
fn deep() -> Vec<Gaussian> {
    many(300, |u| Gaussian {
        mean: [0.0, 0.0, 2.0 + u],
        log_scale: [3.0; 3],
        logit: -5.0,
        ..BALL
    })
}

/// All of them.
#[must_use]
pub fn all() -> Vec<HardScene> {
    let scene = |name, case, form, gaussians| HardScene {
        name,
        case,
        form,
        gaussians,
        // All of its alphas are one code, half a unit of U0.16 off to the same side.
        promise: if name == "deep" { 75.0 } else { 80.0 },
    };
    use Form::{Float32, Reversed, Transmittance16, Undilated};
    vec![
        scene("needles", "needles across the frame", Float32, needles()),
        scene(
            "giants",
            "splats thousands of frames wide, their means aside",
            Float32,
            giants(),
        ),
        scene(
            "near",
            "behind, at and just before the camera",
            Float32,
            near(),
        ),
        scene(
            "ties",
            "exact ties of depth, the file reversed",
            Reversed,
            ties(),
        ),
        scene(
            "flat",
            "no thickness: singular covariances in the world",
            Undilated,
            flat(),
        ),
        scene(
            "none-and-all",
            "alphas of 0, 1 and about 1/255",
            Float32,
            none_and_all(),
        ),
        scene(
            "quaternions",
            "quaternions of length 0 to 3e38",
            Float32,
            quaternions(),
        ),
        scene("deep", "300 faint layers", Transmittance16, deep()),
    ]
}

impl HardScene {
    /// Its Gaussians.
    ///
    /// # Errors
    /// None, unless a list of this file is wrong.
    pub fn cloud(&self) -> Result<Cloud, CloudError> {
        let all = &self.gaussians;
        Cloud::new(
            0,
            all.iter().map(|g| g.mean).collect(),
            all.iter().map(|g| g.log_scale).collect(),
            all.iter().map(|g| g.rotation).collect(),
            all.iter().map(|g| g.logit).collect(),
            all.iter().map(|g| g.colour).collect(),
        )
    }
}
