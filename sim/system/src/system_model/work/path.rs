//! Work of a camera path: frames in full, warped from references, warped from one another, and at
//! half the resolution.

use potamoi_base::effects::Effect;
use potamoi_cycles::batch::Batch;
use potamoi_cycles::mac_array::MacArray;
use potamoi_scene::{Scene, SceneError};
use potamoi_warp::{Profile, Rule, WarpError};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::frame::FrameWork;

/// Why a path could not be counted.
#[derive(Debug, Error)]
pub enum PathError {
    /// The scene cannot be rendered.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// Its frames cannot be warped.
    #[error(transparent)]
    Warp(#[from] WarpError),
    /// The path has no frames.
    #[error("frames is 0: expected a path of 1 or more frames")]
    NoFrames,
}

/// Parts of a path that are counted.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum PathParts {
    /// Frames in full, warped, chained and at half the resolution, and the quality of each.
    #[default]
    All,
    /// Frames in full alone, without their quality: variants that warp or scale are refused.
    FullFrames,
}

/// Options of a counted path.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct PathOptions {
    /// Frames of the path.
    pub frames: u32,
    /// Frames a second on the scene's built-in path.
    pub fps: f64,
    /// Window: targets of a reference.
    pub window: u32,
    /// Largest angle between the rays of reference and target at a point, in degrees; `None`: no
    /// limit.
    pub phi: Option<f64>,
    /// Rules that classify pixels as warped or rendered.
    #[serde(default, skip_serializing_if = "super::is_default")]
    pub profile: Profile,
    /// Rows and columns of the MAC array.
    pub array: [u64; 2],
    /// Whether each unit of the array holds a second operand.
    pub is_double_buffered: bool,
    /// Bytes of the GPU's cache.
    pub cache: u32,
    /// Parts that are counted.
    #[serde(default, skip_serializing_if = "super::is_default")]
    pub parts: PathParts,
}

impl PathOptions {
    /// The rule that classifies a target's pixels.
    pub(super) fn rule(&self, scene: &Scene) -> Rule {
        Rule {
            phi: self.phi.map(f64::to_radians),
            warps_still: scene.choices().forces(Effect::Warping),
            ..self.profile.rule()
        }
    }
}

/// Pixels of a target by origin.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Classes {
    /// Warped from the reference.
    pub warped: u64,
    /// Background.
    pub void: u64,
    /// Rendered.
    pub rendered: u64,
}

impl Classes {
    /// Pixels in all.
    #[must_use]
    pub const fn pixels(&self) -> u64 {
        self.warped + self.void + self.rendered
    }
}

/// A target frame; `B` as of [`FrameWork`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TargetWork<B = Batch> {
    /// The reference that it is warped from; `None` where it shows a reference.
    pub reference: Option<usize>,
    /// Its pixels.
    pub classes: Classes,
    /// Work of rendering the remaining pixels; `None` where nothing is rendered.
    pub work: Option<FrameWork<B>>,
}

/// Quality of a path's frames in floating point. PSNR in dB, from the mean squared error over all frames, peak 1;
/// `None` where they are equal. SSIM, as mean over frames; `None` for frames smaller than 11 x 11
/// pixels.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Quality {
    /// PSNR against the scene's own full frames.
    pub full_db: Option<f64>,
    /// PSNR against the ground truth that the model was sampled from, where it is known.
    pub truth_db: Option<f64>,
    /// SSIM against the scene's own full frames.
    #[serde(default)]
    pub full_ssim: Option<f64>,
    /// SSIM against the ground truth, where it is known.
    #[serde(default)]
    pub truth_ssim: Option<f64>,
}

/// Work of a path; `B` as of [`FrameWork`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PathWork<B = Batch> {
    /// The scene.
    pub scene: String,
    /// Name of the algorithm.
    pub algorithm: String,
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Options it was counted with.
    pub options: PathOptions,
    /// Full frames, at the poses of references.
    pub references: Vec<FrameWork<B>>,
    /// For each reference the frame that shows it, if any, and the frame at whose time its pose is
    /// known.
    pub reference_frames: Vec<(Option<usize>, usize)>,
    /// Frames warped from references (SpaRW), one for each frame of the path.
    pub targets: Vec<TargetWork<B>>,
    /// Frames warped from the frame before; the first of each window is rendered in full (Temp-N).
    pub chained: Vec<TargetWork<B>>,
    /// Frames at half width and height (DS-2), at the poses of references.
    pub halves: Vec<FrameWork<B>>,
    /// Quality of full frames.
    pub full_quality: Quality,
    /// Quality of frames warped from references.
    pub warped_quality: Quality,
    /// Quality of frames warped from one another.
    pub chained_quality: Quality,
    /// Quality of frames at half the resolution.
    pub half_quality: Quality,
}

impl PathWork {
    /// The full frame that stands for a frame of the path: that of its reference.
    ///
    /// # Panics
    /// Never: a counted path has a reference.
    #[must_use]
    pub fn full(&self, number: usize) -> &FrameWork {
        self.standing_for(&self.references, number)
    }

    /// The half-resolution frame that stands for a frame of the path.
    ///
    /// # Panics
    /// Never: a counted path has a reference.
    #[must_use]
    pub fn half(&self, number: usize) -> &FrameWork {
        self.standing_for(&self.halves, number)
    }

    /// The array that the options have.
    pub(super) const fn array(options: &PathOptions) -> MacArray {
        let [rows, columns] = options.array;
        MacArray {
            rows,
            columns,
            is_double_buffered: options.is_double_buffered,
            ..MacArray::PAPER
        }
    }

    fn standing_for<'a>(&self, works: &'a [FrameWork], number: usize) -> &'a FrameWork {
        let window = self.options.window.max(1) as usize;
        &works[(number / window).min(works.len() - 1)]
    }

    /// Steps that [`PathWork::count`] reports.
    #[must_use]
    pub fn steps(options: &PathOptions) -> u64 {
        let references = u64::from(options.frames.div_ceil(options.window.max(1)));
        if options.parts == PathParts::FullFrames {
            return 2 * references;
        }
        // Each frame is rendered in full and warped in two ways; those that are counted are read once more.
        7 * u64::from(options.frames) + 4 * references
    }
}
