//! Quality of warped frames.

use potamoi_analytic::Analytic;
use potamoi_base::camera::Camera;
use potamoi_base::picture::Picture;
use potamoi_base::ssim::ssim;
use potamoi_warp::{Counts, Frame, Shaded, is_void};
use schemars::JsonSchema;
use serde::Serialize;

use super::source::Source;
use crate::{ExploreError, Progress};

/// Ground truth along the last path, kept for the next representation of the same scene.
#[derive(Default)]
pub struct Truth {
    of: Option<Analytic>,
    background: [f32; 3],
    path: Vec<Camera>,
    pictures: Vec<Picture>,
}

impl Truth {
    /// The picture of frame `number`, if it was seen by this camera.
    fn frame(&self, number: usize, camera: &Camera) -> Option<&Picture> {
        (self.path.get(number) == Some(camera)).then(|| &self.pictures[number])
    }

    /// Switches to a source, and drops pictures of another scene.
    fn turn_to(&mut self, source: &Source) {
        let (of, background) = (source.analytic(), source.renderer().background());
        if self.of != of || self.background != background {
            *self = Self {
                of,
                background,
                ..Self::default()
            };
        }
    }

    fn picture(
        &mut self,
        source: &Source,
        number: usize,
        camera: &Camera,
    ) -> Result<Option<Picture>, ExploreError> {
        if let Some(known) = self.frame(number, camera) {
            return Ok(Some(known.clone()));
        }
        self.path.truncate(number);
        self.pictures.truncate(number);
        let picture = source.truth(camera)?;
        if let Some(picture) = &picture {
            self.path.push(*camera);
            self.pictures.push(picture.clone());
        }
        Ok(picture)
    }
}

/// The full frames of a path, by the model and as ground truth.
pub struct Footage {
    full: Vec<Shaded>,
    truth: Vec<Option<Picture>>,
}

impl Footage {
    /// Renders the path's frames in full, one step each, and the ground truth where it is known.
    ///
    /// # Errors
    /// As [`Renderer::shade`](potamoi_warp::Renderer::shade) and [`Source::truth`].
    pub fn new(
        source: &Source,
        path: &[Camera],
        truth: &mut Truth,
        progress: &dyn Progress,
    ) -> Result<Self, ExploreError> {
        let mut footage = Self {
            full: vec![],
            truth: vec![],
        };
        truth.turn_to(source);
        for (number, camera) in path.iter().enumerate() {
            footage.full.push(source.renderer().shade(camera, None)?);
            footage.truth.push(truth.picture(source, number, camera)?);
            progress.advance(1);
        }
        Ok(footage)
    }

    /// Width and height in pixels; 0 for an empty path.
    #[must_use]
    pub fn size(&self) -> [u32; 2] {
        self.full
            .first()
            .map_or([0, 0], |f| [f.picture.width, f.picture.height])
    }

    /// Quality of the model's full frames against the ground truth; `None` where that is not known.
    #[must_use]
    pub fn quality(&self) -> Option<ImageQuality> {
        let mut sums = Sums::default();
        for (full, truth) in self.full.iter().zip(&self.truth) {
            sums.add(&full.picture, truth.as_ref()?, |_| true);
        }
        sums.likeness()
    }
}

/// Quality of a picture or a sequence against another.
#[derive(Debug, Clone, Copy, Serialize, JsonSchema)]
pub struct ImageQuality {
    /// PSNR in dB from the mean squared error over all counted pixels, peak 1; `None` where they
    /// are equal.
    pub psnr_db: Option<f64>,
    /// Mean PSNR of frames in dB; `None` where one of them is equal.
    pub mean_psnr_db: Option<f64>,
    /// Mean SSIM of frames; `None` where no window of 11 x 11 pixels fits.
    pub ssim: Option<f64>,
}

/// Sums over frames.
#[derive(Debug, Clone, Copy, Default)]
struct Sums {
    frames: usize,
    squared: f64,
    pixels: f64,
    psnr: f64,
    ssim: f64,
    ssims: usize,
}

impl Sums {
    fn add(&mut self, a: &Picture, b: &Picture, counts: impl Fn(usize) -> bool) {
        let Some(mse) = a.mean_squared_error(b, &counts) else {
            return;
        };
        let pixels = (0..a.rgb.len()).filter(|i| counts(*i)).count() as f64;
        self.frames += 1;
        self.squared += mse * pixels;
        self.pixels += pixels;
        self.psnr += decibels(mse);
        if let Some(ssim) = ssim(a, b, counts) {
            self.ssim += ssim;
            self.ssims += 1;
        }
    }

    fn likeness(&self) -> Option<ImageQuality> {
        let finite = |v: f64| v.is_finite().then_some(v);
        (self.frames > 0).then(|| ImageQuality {
            psnr_db: finite(decibels(self.squared / self.pixels)),
            mean_psnr_db: finite(self.psnr / self.frames as f64),
            ssim: (self.ssims > 0).then(|| self.ssim / self.ssims as f64),
        })
    }
}

fn decibels(mse: f64) -> f64 {
    -10.0 * mse.log10()
}

/// Quality of all pixels, or of the foreground: pixels where the model is not empty.
#[derive(Debug, Clone, Copy, Serialize, JsonSchema)]
pub struct Part {
    /// Pixels by origin.
    pub pixels: Counts,
    /// Quality against the model's full frames.
    pub model: Option<ImageQuality>,
    /// Quality against the ground truth.
    pub truth: Option<ImageQuality>,
}

/// Quality of one frame.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct FrameQuality {
    /// Number of the frame, from 0.
    pub number: usize,
    /// The reference that it was warped from.
    pub reference: Option<usize>,
    /// Whether a target fell back to full rendering.
    pub fell_back: bool,
    /// All of its pixels.
    pub frame: Part,
    /// Foreground pixels: those where the model is not empty.
    pub foreground: Part,
}

/// Quality of one method's frames, collected frame by frame.
pub struct Measured<'a> {
    footage: &'a Footage,
    /// Frames so far.
    pub frames: Vec<FrameQuality>,
    all: [Totals; 2],
}

/// Sums over all frames.
#[derive(Debug, Clone, Copy, Default)]
struct Totals {
    pixels: Counts,
    model: Sums,
    truth: Sums,
}

impl Totals {
    fn add(
        &mut self,
        frame: &Frame,
        full: &Picture,
        truth: Option<&Picture>,
        counts: impl Fn(usize) -> bool,
    ) -> Part {
        let picture = &frame.target.shaded.picture;
        let mut own = Self {
            pixels: Counts::of(&frame.target.classes, &counts),
            ..Self::default()
        };
        for sums in [&mut own.model, &mut self.model] {
            sums.add(picture, full, &counts);
        }
        if let Some(truth) = truth {
            for sums in [&mut own.truth, &mut self.truth] {
                sums.add(picture, truth, &counts);
            }
        }
        self.pixels = self.pixels + own.pixels;
        own.part()
    }

    fn part(&self) -> Part {
        Part {
            pixels: self.pixels,
            model: self.model.likeness(),
            truth: self.truth.likeness(),
        }
    }
}

impl<'a> Measured<'a> {
    /// Starts without frames.
    #[must_use]
    pub fn new(footage: &'a Footage) -> Self {
        Self {
            footage,
            frames: vec![],
            all: Default::default(),
        }
    }

    /// Adds a frame of the footage's path.
    pub fn add(&mut self, frame: &Frame) {
        let full = &self.footage.full[frame.number];
        let truth = self.footage.truth[frame.number].as_ref();
        let shows = |i: usize| !is_void(full.depth[i]);
        let [whole, foreground] = &mut self.all;
        self.frames.push(FrameQuality {
            number: frame.number,
            reference: frame.reference,
            fell_back: frame.fell_back(),
            frame: whole.add(frame, &full.picture, truth, |_| true),
            foreground: foreground.add(frame, &full.picture, truth, shows),
        });
    }

    /// Quality over all frames, and over their foregrounds.
    #[must_use]
    pub fn totals(&self) -> [Part; 2] {
        self.all.map(|totals| totals.part())
    }
}
