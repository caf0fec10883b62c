//! What was found of each way of making the frames.

use potamoi_base::camera::Camera;
use potamoi_system::runtime::Schedule;
use potamoi_warp::{Plan, PlanOptions, ReferenceFrom};
use serde::Serialize;

use super::quality::{FrameQuality, Likeness, Measured, Part};
use super::timetable::Timing;
use super::way::{Method, Way};

/// What was found of one scene.
#[derive(Debug, Clone, Serialize)]
pub struct Warping {
    /// The scene's name.
    pub scene: String,
    /// Pixels of a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Frames of the path.
    pub frames: usize,
    /// Frames a second, of a path whose rate may be chosen.
    pub fps: Option<f64>,
    /// The model in full against ground truth.
    pub model: Option<Likeness>,
    /// A way each.
    pub variants: Vec<Variant>,
    /// What a model's file leaves open.
    pub not_checked: Vec<String>,
    /// Seconds that all of it took.
    pub seconds: f64,
}

/// One way of making the frames.
#[derive(Debug, Clone, Serialize)]
pub struct Variant {
    /// What tells it from the others.
    pub name: String,
    /// How frames are made.
    pub method: &'static str,
    /// Frames of a reference, or of a chain.
    pub window: u32,
    /// Degrees between the rays of a point beyond which it is rendered; none: no limit.
    pub phi_degrees: Option<f64>,
    /// Where depth is from.
    pub depth: String,
    /// References that were rendered.
    pub references: usize,
    /// Frames that were to be warped and were rendered in full.
    pub fallbacks: usize,
    /// Pixels that the model renders, references included, of those of all
    /// frames in full.
    pub rendered_share: f64,
    /// All pixels of all frames.
    pub frame: Part,
    /// Those where the model shows something.
    pub foreground: Part,
    /// How far predicted references are off; none of ways without.
    pub prediction: Option<Prediction>,
    /// Of the runtime, where it was scheduled or measured.
    pub timing: Option<Timing>,
    /// The schedule itself, likewise.
    #[serde(skip)]
    pub schedule: Option<Schedule>,
    /// Frame by frame.
    pub frames: Vec<FrameQuality>,
    /// Seconds that it took.
    pub seconds: f64,
}

/// How far predicted references are from where the camera was.
#[derive(Debug, Clone, Serialize)]
pub struct Prediction {
    /// References that count.
    pub references: usize,
    /// The angle between both directions, on average.
    pub mean_radians: f64,
    /// The largest of them.
    pub largest_radians: f64,
    /// Between both places, on average, in the scene's units.
    pub mean_distance: f64,
}

impl Variant {
    /// Of a way whose depth has this name.
    pub(super) fn new(
        way: &Way,
        depth: String,
        measured: Measured<'_>,
        plan: &Plan,
        path: &[Camera],
    ) -> Self {
        let [frame, foreground] = measured.totals();
        let pixels = frame.pixels.total() as f64;
        // References off the path are rendered beside the frames.
        let beside = plan.references.iter().filter(|r| r.target.is_none());
        let (references, extra) = match way.method {
            Method::SpaRw => (plan.references.len(), beside.count()),
            Method::Chained => (path.len().div_ceil(way.window as usize), 0),
            Method::HalfResolution => (0, 0),
        };
        let extra = extra as f64 * pixels / path.len().max(1) as f64;
        let rendered_share = match way.method {
            Method::HalfResolution => 0.25,
            _ => (frame.pixels.rendered() as f64 + extra) / pixels,
        };
        Self {
            name: way.name.clone(),
            method: way.method.name(),
            window: way.window,
            phi_degrees: way.phi,
            depth,
            references,
            fallbacks: measured.frames.iter().filter(|f| f.fell_back).count(),
            rendered_share,
            frame,
            foreground,
            prediction: (way.method == Method::SpaRw)
                .then(|| Prediction::of(&prediction_errors(plan, path)))
                .flatten(),
            timing: None,
            schedule: None,
            frames: measured.frames,
            seconds: 0.0,
        }
    }

    /// By how much the model's own PSNR to ground truth falls, in dB, means of
    /// frames.
    #[must_use]
    pub fn loss(&self, model: Option<&Likeness>) -> Option<f64> {
        let psnr = |l: Option<&Likeness>| l?.mean_psnr_db;
        Some(psnr(model)? - psnr(self.frame.truth.as_ref())?)
    }

    /// The paper's loss in dB, of trained models.
    #[must_use]
    pub fn papers_loss(&self) -> Option<f64> {
        match (self.method, self.window, self.phi_degrees) {
            ("SpaRW", 6, None) => Some(1.0),
            ("SpaRW", 16, None) => Some(1.4),
            _ => None,
        }
    }
}

/// Of references that are taken on the path, how far off they would be if they
/// were predicted.
fn prediction_errors(plan: &Plan, path: &[Camera]) -> Vec<(f64, f64)> {
    if plan.references.iter().any(|r| r.predicted_for.is_some()) {
        return plan.prediction_errors(path);
    }
    let first = |reference| {
        plan.targets
            .iter()
            .filter(|t| t.reference == reference)
            .count()
    };
    let options = PlanOptions {
        window: (0..plan.references.len()).map(first).max().unwrap_or(1) as u32,
        reference: ReferenceFrom::Predicted,
        lead: None,
    };
    let other = Plan::new(path, &options);
    other.map_or_else(|_| vec![], |other| other.prediction_errors(path))
}

impl Prediction {
    fn of(errors: &[(f64, f64)]) -> Option<Self> {
        let count = errors.len() as f64;
        (count > 0.0).then(|| Self {
            references: errors.len(),
            mean_radians: errors.iter().map(|e| e.0).sum::<f64>() / count,
            largest_radians: errors.iter().map(|e| e.0).fold(0.0, f64::max),
            mean_distance: errors.iter().map(|e| e.1).sum::<f64>() / count,
        })
    }
}
