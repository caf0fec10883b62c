//! Results of rendering methods.

use potamoi_base::camera::Camera;
use potamoi_system::path_schedule::Schedule;
use potamoi_warp::{Plan, PlanOptions, ReferenceFrom};
use schemars::JsonSchema;
use serde::Serialize;

use super::method::{Method, MethodSettings};
use super::quality::{FrameQuality, ImageQuality, Measured, Part};
use super::timetable::Timing;

/// Results for one scene.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct Warping {
    /// The scene's name.
    pub scene: String,
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Frames of the path.
    pub frames: usize,
    /// Frames a second, where the rate can be chosen.
    pub fps: Option<f64>,
    /// Quality of the model's full frames against the ground truth.
    pub model: Option<ImageQuality>,
    /// Results by method.
    pub variants: Vec<Variant>,
    /// Items that the model's file leaves open.
    pub not_checked: Vec<String>,
    /// Wall time of the study in seconds.
    pub seconds: f64,
}

/// Results of one method.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct Variant {
    /// Label that tells it from the others.
    pub name: String,
    /// Name of the method.
    pub method: &'static str,
    /// Window: frames of a reference, or of a chain.
    pub window: u32,
    /// Largest angle in degrees between the rays of a warped point; `None`: no limit.
    pub phi_degrees: Option<f64>,
    /// Source of depth.
    pub depth: String,
    /// References rendered.
    pub references: usize,
    /// Targets that fell back to full rendering.
    pub fallbacks: usize,
    /// Pixels that the model renders, references included, over the pixels of all frames.
    pub rendered_share: f64,
    /// All pixels of all frames.
    pub frame: Part,
    /// Foreground pixels of all frames: those where the model is not empty.
    pub foreground: Part,
    /// Error of predicted reference poses; `None` for methods without prediction.
    pub prediction: Option<Prediction>,
    /// Summary of the schedule, where scheduled or measured.
    pub timing: Option<Timing>,
    /// The schedule, where scheduled or measured.
    #[serde(skip)]
    pub schedule: Option<Schedule>,
    /// Quality by frame.
    pub frames: Vec<FrameQuality>,
    /// Wall time in seconds.
    pub seconds: f64,
}

/// Error of predicted reference poses against the camera's actual ones.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct Prediction {
    /// References that count.
    pub references: usize,
    /// Mean angle between both directions, in radians.
    pub mean_radians: f64,
    /// Largest angle, in radians.
    pub largest_radians: f64,
    /// Mean distance between both positions, in the scene's units.
    pub mean_distance: f64,
}

impl Variant {
    /// Results of a method whose source of depth has this name.
    pub(super) fn new(
        settings: &MethodSettings,
        depth: String,
        measured: Measured<'_>,
        plan: &Plan,
        path: &[Camera],
    ) -> Self {
        let [frame, foreground] = measured.totals();
        let pixels = frame.pixels.total() as f64;
        // References off the path are rendered beside the frames.
        let beside = plan.references.iter().filter(|r| r.target.is_none());
        let (references, extra) = match settings.method {
            Method::SpaRw => (plan.references.len(), beside.count()),
            Method::Chained => (path.len().div_ceil(settings.window as usize), 0),
            Method::HalfResolution => (0, 0),
        };
        let extra = extra as f64 * pixels / path.len().max(1) as f64;
        let rendered_share = match settings.method {
            Method::HalfResolution => 0.25,
            _ => (frame.pixels.rendered() as f64 + extra) / pixels,
        };
        Self {
            name: settings.name.clone(),
            method: settings.method.name(),
            window: settings.window,
            phi_degrees: settings.phi,
            depth,
            references,
            fallbacks: measured.frames.iter().filter(|f| f.fell_back).count(),
            rendered_share,
            frame,
            foreground,
            prediction: (settings.method == Method::SpaRw)
                .then(|| Prediction::of(&prediction_errors(plan, path)))
                .flatten(),
            timing: None,
            schedule: None,
            frames: measured.frames,
            seconds: 0.0,
        }
    }

    /// Loss of PSNR against the ground truth relative to the model's own, in dB, from means over
    /// frames.
    #[must_use]
    pub fn loss(&self, model: Option<&ImageQuality>) -> Option<f64> {
        let psnr = |l: Option<&ImageQuality>| l?.mean_psnr_db;
        Some(psnr(model)? - psnr(self.frame.truth.as_ref())?)
    }

    /// The paper's loss in dB for trained models.
    #[must_use]
    pub fn papers_loss(&self) -> Option<f64> {
        match (self.method, self.window, self.phi_degrees) {
            ("SpaRW", 6, None) => Some(1.0),
            ("SpaRW", 16, None) => Some(1.4),
            _ => None,
        }
    }
}

/// For references on the path, the errors of their poses if they were predicted.
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
    pub(super) fn of(errors: &[(f64, f64)]) -> Option<Self> {
        let count = errors.len() as f64;
        (count > 0.0).then(|| Self {
            references: errors.len(),
            mean_radians: errors.iter().map(|e| e.0).sum::<f64>() / count,
            largest_radians: errors.iter().map(|e| e.0).fold(0.0, f64::max),
            mean_distance: errors.iter().map(|e| e.1).sum::<f64>() / count,
        })
    }
}
