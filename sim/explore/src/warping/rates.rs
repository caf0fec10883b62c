//! One path at several rates: quality, work, prediction and deadlines.

use potamoi_base::camera::Camera;
use potamoi_warp::{Counts, Plan, PlanOptions};
use schemars::JsonSchema;
use serde::Serialize;

use super::timetable::{GivenTimes, Timetable, late_frames};
use super::variant::{Prediction, Variant, Warping};
use crate::ExploreError;

/// Bisections of a frame's time: enough for three digits of any.
const BISECTIONS: u32 = 24;

/// A path at a rate.
#[derive(Debug, Clone, Copy)]
pub struct Pace<'a> {
    /// Its name: trajectory or orbit.
    pub path: &'static str,
    /// Frames a second.
    pub fps: f64,
    /// Cameras of the frames that are warped.
    pub frames: &'a [Camera],
    /// Cameras of the whole motion, which begins with those frames; only poses are predicted from
    /// the rest.
    pub motion: &'a [Camera],
}

/// Error of predicted reference poses against the camera's actual ones.
#[derive(Debug, Clone, Copy, Serialize, JsonSchema)]
pub struct PredictionError {
    /// References that count.
    pub references: usize,
    /// Mean angle between both directions.
    pub mean_degrees: f64,
    /// Largest angle.
    pub largest_degrees: f64,
    /// Mean angle if the last known pose were taken instead of the predicted one.
    pub still_degrees: f64,
    /// Mean distance between both positions, in the scene's units.
    pub mean_distance: f64,
}

impl PredictionError {
    /// Of a path's plan; `None` without predicted references within the path.
    fn of(plan: &Plan, path: &[Camera]) -> Option<Self> {
        let own = Prediction::of(&plan.prediction_errors(path))?;
        let still = plan.references.iter().filter_map(|reference| {
            let truth = path.get(reference.predicted_for?)?;
            let known = path.get(reference.known)?;
            Some(turn(known, truth))
        });
        Some(Self {
            references: own.references,
            mean_degrees: own.mean_radians.to_degrees(),
            largest_degrees: own.largest_radians.to_degrees(),
            still_degrees: still.sum::<f64>().to_degrees() / own.references as f64,
            mean_distance: own.mean_distance,
        })
    }
}

/// Angle in radians between the directions of two cameras, also small ones.
fn turn(from: &Camera, to: &Camera) -> f64 {
    let [a, b] = [from, to].map(|camera| camera.world_to_camera.matrix3);
    let m = b * a.transpose();
    let skew = [
        m.y_axis.z - m.z_axis.y,
        m.z_axis.x - m.x_axis.z,
        m.x_axis.y - m.y_axis.x,
    ];
    let sin = skew.map(|v| v * v).iter().sum::<f64>().sqrt() / 2.0;
    let cos = (m.x_axis.x + m.y_axis.y + m.z_axis.z - 1.0) / 2.0;
    sin.atan2(cos)
}

/// A method on a path at a rate.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct RateRow {
    /// The path: trajectory or orbit.
    pub path: &'static str,
    /// Frames a second.
    pub fps: f64,
    /// The method.
    pub method: String,
    /// Frames that were warped.
    pub frames: usize,
    /// PSNR to the model's full frames in dB; `None` where they are equal.
    pub psnr_to_model_db: Option<f64>,
    /// Mean PSNR to ground truth in dB, where that is known.
    pub psnr_to_truth_db: Option<f64>,
    /// Pixels that the model renders, references included, over the pixels of all frames.
    pub rendered_share: f64,
    /// Frames of the whole motion.
    pub motion_frames: usize,
    /// Error of the reference poses predicted along the whole motion; `None` for methods without
    /// prediction.
    pub prediction: Option<PredictionError>,
    /// Frames that were not shown within a frame's time of their pose, where times are given.
    pub deadline_misses: Option<usize>,
    /// The longest render time of a full frame, in milliseconds, with which no frame behind the first
    /// window misses its deadline; `None` for methods without references, and without such a frame.
    /// The first window has to wait for its first frame, which no reference shows.
    pub no_miss_up_to_ms: Option<f64>,
}

/// Rows of one scene.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct Rates {
    /// The scene's name.
    pub scene: String,
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// The rows, by rate, path and method.
    pub rates: Vec<RateRow>,
    /// Items that the model's file leaves open.
    pub not_checked: Vec<String>,
}

impl RateRow {
    /// The row of a method that warped the frames of a path, without lost references.
    ///
    /// # Errors
    /// An invalid plan, or times beyond 64 bits.
    pub fn of(
        pace: &Pace<'_>,
        found: &Warping,
        variant: &Variant,
        plan: &PlanOptions,
        timetable: &Timetable,
    ) -> Result<Self, ExploreError> {
        let predicts = variant.method == super::Method::SpaRw.name();
        let (mut prediction, mut longest) = (None, None);
        if predicts {
            let whole = Plan::new(pace.motion, plan)?;
            prediction = PredictionError::of(&whole, pace.motion);
            let plan = Plan::new(pace.frames, plan)?;
            longest = longest_without_miss(pace, &plan, &counts(variant), timetable)?;
        }
        let model = variant.frame.model.as_ref();
        let truth = variant.frame.truth.as_ref();
        Ok(Self {
            path: pace.path,
            fps: pace.fps,
            method: variant.name.clone(),
            frames: found.frames,
            psnr_to_model_db: model.and_then(|m| m.psnr_db),
            psnr_to_truth_db: truth.and_then(|t| t.mean_psnr_db),
            rendered_share: variant.rendered_share,
            motion_frames: pace.motion.len(),
            prediction,
            deadline_misses: variant.timing.as_ref().and_then(|t| t.deadline_misses),
            no_miss_up_to_ms: longest,
        })
    }
}

fn counts(variant: &Variant) -> Vec<Counts> {
    variant.frames.iter().map(|f| f.frame.pixels).collect()
}

/// The longest render time of a full frame with which no frame behind the first window misses its
/// deadline, by bisection, with the timetable's time of warping. Where references are shared with targets that fall back, a
/// longer time may serve again, as in any list scheduling; the first bound is taken.
fn longest_without_miss(
    pace: &Pace<'_>,
    plan: &Plan,
    counts: &[Counts],
    timetable: &Timetable,
) -> Result<Option<f64>, ExploreError> {
    let first = plan.targets.iter().take_while(|t| t.reference == 0).count();
    let Some(camera) = pace.frames.first().filter(|_| first < plan.targets.len()) else {
        return Ok(None);
    };
    let warp = match &timetable.times {
        super::Times::Given(times) => times.warp,
        _ => None,
    };
    let misses = |frame: f64| -> Result<bool, ExploreError> {
        let times = GivenTimes {
            frame,
            warp,
            server: None,
            timeout: 0.0,
        };
        let fps = Some(pace.fps);
        let schedule = timetable.schedule(&times, plan, counts, camera, fps, &[])?;
        Ok(late_frames(&schedule, pace.fps).any(|frame| frame >= first))
    };
    if misses(0.0)? {
        return Ok(None);
    }
    // A frame that takes longer than the path is late.
    let path_ms = (plan.targets.len() + 1) as f64 * 1e3 / pace.fps;
    let (mut fits, mut late) = (0.0, path_ms);
    for _ in 0..BISECTIONS {
        let middle = f64::midpoint(fits, late);
        match misses(middle)? {
            true => late = middle,
            false => fits = middle,
        }
    }
    Ok(Some(fits))
}
