//! Frames of Gaussians in floating point, from the model to the picture, beside the machine's peak.
//!
//! An *evaluation* is one Gaussian at one pixel: [`OPERATIONS`] additions and multiplications of 64 bits.
//! The limit is the time that the evaluations of a frame take at the peak of the same vectors
//! ([`peak`]), measured just before. Comparisons, selections, projection, sorting, finding spans and
//! moving data do not count. `dense`, whose Gaussians each fill the frame, shows the cost without the
//! last four.

use glam::DVec3;
use potamoi_base::camera::Camera;
use potamoi_base::vectors::Vectors;
use potamoi_gaussians::Cloud;
use potamoi_scene::{Model, Scene, garden};
use potamoi_splats::{FloatOptions, Profile, render_float};

use crate::error::SpeedError;
use crate::frame_name;
use crate::peak::peak;
use crate::row::{Beside, Figure, Kind, Row, Section};
use crate::sizes::Sizes;
use crate::time::Meter;

/// Additions and multiplications of an evaluation: 7 for the square, 32 for the exponential, 4 for
/// alpha and transmittance, 6 for the colour.
const OPERATIONS: u64 = 49;
/// Number of Gaussians in `dense`.
const LAYERS: usize = 100;

/// A cloud that a camera sees.
struct View {
    name: String,
    cloud: Cloud,
    camera: Camera,
    profile: Profile,
}

impl View {
    /// Gaussians that each fill the frame.
    fn dense(side: u32) -> Result<Self, SpeedError> {
        let depth = |i| 1.0 + i as f32 / LAYERS as f32;
        let cloud = Cloud::new(
            0,
            (0..LAYERS).map(|i| [0.0, 0.0, depth(i)]).collect(),
            vec![[8.0; 3]; LAYERS],
            vec![[1.0, 0.0, 0.0, 0.0]; LAYERS],
            vec![-4.5; LAYERS],
            vec![[0.5; 3]; LAYERS],
        )?;
        Ok(Self {
            name: "dense".to_owned(),
            cloud,
            camera: Camera::look_at(DVec3::ZERO, DVec3::Z, DVec3::NEG_Y, 0.9, side, side),
            profile: Profile::Inria,
        })
    }

    fn garden(side: u32) -> Self {
        Self {
            name: "garden".to_owned(),
            cloud: garden::cloud(),
            camera: garden::camera().resized(side, side),
            profile: Profile::Inria,
        }
    }

    /// A scene that the user named; `None` where it is of no Gaussians.
    fn of(scene: &Scene) -> Option<Self> {
        let Model::Splats(cloud) = scene.model() else {
            return None;
        };
        Some(Self {
            name: scene.name().to_owned(),
            cloud: cloud.clone(),
            camera: *scene.camera(),
            profile: scene.profile(),
        })
    }
}

/// Number of steps of [`rows`].
pub(crate) fn steps(own: Option<&Scene>) -> u64 {
    let own = own.is_some_and(|scene| matches!(scene.model(), Model::Splats(_)));
    Vectors::here().count() as u64 + 2 + u64::from(own)
}

/// Each scene with each of the processor's vectors, the widest first.
///
/// # Errors
/// A scene that cannot be rendered.
pub(crate) fn rows(
    sizes: &Sizes,
    runs: u32,
    own: Option<&Scene>,
    meter: &mut Meter,
    begin: &mut dyn FnMut(&str),
) -> Result<Vec<Row>, SpeedError> {
    let mut levels: Vec<(Vectors, Figure)> = vec![];
    for vectors in Vectors::here() {
        begin(&format!("peak of {vectors}"));
        let peak = peak(vectors, sizes, meter);
        let missing = || format!("this processor has no {vectors}");
        levels.push((vectors, peak.ok_or_else(missing)));
    }
    levels.reverse();
    let mut views = vec![View::dense(sizes.dense)?, View::garden(sizes.garden)];
    views.extend(own.and_then(View::of));
    let mut found = vec![];
    for view in &views {
        begin(&view.name);
        for (vectors, peak) in &levels {
            found.push(row(view, *vectors, peak, runs, meter)?);
        }
    }
    Ok(found)
}

fn row(
    view: &View,
    vectors: Vectors,
    peak: &Figure,
    runs: u32,
    meter: &mut Meter,
) -> Result<Row, SpeedError> {
    let View { cloud, camera, .. } = view;
    let options = FloatOptions {
        vectors: Some(vectors),
        ..FloatOptions::default()
    };
    let logged = FloatOptions {
        log_decisions: true,
        ..options
    };
    let stats = render_float(cloud, camera, view.profile, &logged)?.stats;
    let stats = stats.unwrap_or_default();
    let threads = rayon::current_num_threads();
    let frame = || render_float(cloud, camera, view.profile, &options);
    let (ms, _) = meter.fastest(runs, threads, frame)?;
    let limit = peak.clone().map(|peak| limit(stats.evaluated, peak));
    let origin = match peak {
        Ok(peak) => format!(
            "a frame, from the model to the picture; beside: evaluations x {OPERATIONS} additions and \
             multiplications of 64 bits at {:.1} G a second, as measured on one core from registers, \
             not fused",
            1e-9 * peak
        ),
        Err(_) => "a frame, from the model to the picture".to_owned(),
    };
    let what = format!("{}, {vectors}", frame_name::of(&view.name, camera));
    let beside = Beside::new(Kind::Limit, format!("peak of {vectors}"), &limit);
    Ok(
        Row::new(Section::Splats, what, &Ok(ms), beside, origin).with_counts([
            ("Gaussians in view", stats.visible),
            ("evaluations", stats.evaluated),
            ("evaluations drawn", stats.drawn),
        ]),
    )
}

/// Milliseconds that evaluations take at a peak of operations a second.
fn limit(evaluated: u64, peak: f64) -> f64 {
    1e3 * (evaluated * OPERATIONS) as f64 / peak
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn a_limit_is_the_time_of_the_evaluations_at_the_peak() {
        // 49 million operations at 49 million a second.
        assert!((limit(1_000_000, 49e6) - 1e3).abs() < 1e-9);
        assert!((limit(2_000_000, 49e6) - 2e3).abs() < 1e-9);
        assert!((limit(1_000_000, 98e6) - 500.0).abs() < 1e-9);
    }

    #[test]
    fn every_gaussian_of_dense_fills_the_frame() {
        let view = View::dense(16).unwrap();
        let options = FloatOptions {
            log_decisions: true,
            ..FloatOptions::default()
        };
        let frame = render_float(&view.cloud, &view.camera, view.profile, &options).unwrap();
        let stats = frame.stats.unwrap();
        assert_eq!(stats.visible, LAYERS as u64);
        assert!(stats.evaluated >= 16 * 16 * LAYERS as u64 / 2, "{stats:?}");
    }
}
