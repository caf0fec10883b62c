//! What was found, as JSON has it.

use potamoi_base::camera::Camera;
use potamoi_warp::{Plan, PlanOptions, ReferenceFrom};
use serde::Serialize;

use super::measure::{FrameFound, Likeness, Measured, Part};
use super::timing::Timing;
use super::ways::{Method, Way};

/// Version of the JSON report.
pub(super) const FORMAT_VERSION: u32 = 2;

#[derive(Serialize)]
pub(super) struct Report {
    pub(super) format_version: u32,
    pub(super) command: &'static str,
    #[serde(flatten)]
    pub(super) found: Found,
}

#[derive(Serialize)]
pub(super) struct Reports {
    pub(super) format_version: u32,
    pub(super) command: &'static str,
    pub(super) scenes: Vec<Found>,
}

/// What was found of one scene.
#[derive(Serialize)]
pub(super) struct Found {
    pub(super) scene: String,
    pub(super) width: u32,
    pub(super) height: u32,
    pub(super) frames: usize,
    /// Of a built-in way.
    pub(super) fps: Option<f64>,
    /// The model in full against ground truth.
    pub(super) model: Option<Likeness>,
    pub(super) variants: Vec<Variant>,
    /// What a model's file leaves open.
    pub(super) not_checked: Vec<String>,
    pub(super) seconds: f64,
}

/// One way of making the frames.
#[derive(Serialize)]
pub(super) struct Variant {
    pub(super) name: String,
    pub(super) method: &'static str,
    pub(super) window: u32,
    pub(super) phi_degrees: Option<f64>,
    /// Where depth is from.
    pub(super) depth: String,
    pub(super) references: usize,
    /// Frames that were to be warped and were rendered in full.
    pub(super) fallbacks: usize,
    /// Pixels that the model renders, references included, of those of all
    /// frames in full.
    pub(super) rendered_share: f64,
    pub(super) frame: Part,
    pub(super) foreground: Part,
    pub(super) prediction: Option<Prediction>,
    /// Of the runtime, where it was scheduled or measured.
    pub(super) timing: Option<Timing>,
    pub(super) frames: Vec<FrameFound>,
    pub(super) seconds: f64,
}

/// How far predicted references are from where the camera was.
#[derive(Serialize)]
pub(super) struct Prediction {
    pub(super) references: usize,
    pub(super) mean_radians: f64,
    pub(super) largest_radians: f64,
    /// In the scene's units.
    pub(super) mean_distance: f64,
}

impl Variant {
    pub(super) fn new(
        way: &Way,
        depth: String,
        measured: Measured<'_>,
        plan: &Plan,
        path: &[Camera],
        seconds: f64,
        timing: Option<Timing>,
    ) -> Self {
        let [frame, foreground] = measured.totals();
        let pixels = frame.pixels.total() as f64;
        // References off the path are rendered beside the frames.
        let beside = plan.references.iter().filter(|r| r.target.is_none());
        let (references, extra) = match way.method {
            Method::Sparw => (plan.references.len(), beside.count()),
            Method::Temp => (path.len().div_ceil(way.window as usize), 0),
            Method::Ds2 => (0, 0),
        };
        let extra = extra as f64 * pixels / path.len().max(1) as f64;
        let rendered_share = match way.method {
            Method::Ds2 => 0.25,
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
            prediction: (way.method == Method::Sparw)
                .then(|| Prediction::of(&prediction_errors(plan, path)))
                .flatten(),
            timing,
            frames: measured.frames,
            seconds,
        }
    }

    /// By how much the model's own PSNR to ground truth falls, in dB, means of
    /// frames.
    pub(super) fn loss(&self, model: Option<&Likeness>) -> Option<f64> {
        let psnr = |l: Option<&Likeness>| l?.mean_psnr_db;
        Some(psnr(model)? - psnr(self.frame.truth.as_ref())?)
    }

    /// The paper's loss in dB, of trained models.
    pub(super) fn papers_loss(&self) -> Option<f64> {
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
