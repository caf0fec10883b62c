//! How good frames are.

use potamoi_analytic::Analytic;
use potamoi_base::camera::Camera;
use potamoi_base::picture::Picture;
use potamoi_base::ssim::ssim;
use potamoi_warp::{Counts, Frame, Shaded, is_void};
use serde::Serialize;

use super::source::Source;
use crate::{ExploreError, Progress};

/// What was really there along the last path, for the next representation of the
/// same scene.
#[derive(Default)]
pub struct Truth {
    of: Option<Analytic>,
    background: [f32; 3],
    path: Vec<Camera>,
    pictures: Vec<Picture>,
}

impl Truth {
    /// Whether frame `number` of it is of this camera.
    fn frame(&self, number: usize, camera: &Camera) -> Option<&Picture> {
        (self.path.get(number) == Some(camera)).then(|| &self.pictures[number])
    }

    /// Goes on to a source; what does not belong to it is forgotten.
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

/// Of a path, what the model shows in full, and what is there.
pub struct Footage {
    full: Vec<Shaded>,
    truth: Vec<Option<Picture>>,
}

impl Footage {
    /// Renders the path's frames in full, a step each, and what is there, where that is known.
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

    /// Pixels of a row, and rows; 0 of an empty path.
    #[must_use]
    pub fn size(&self) -> [u32; 2] {
        self.full
            .first()
            .map_or([0, 0], |f| [f.picture.width, f.picture.height])
    }

    /// How like the model in full is to the truth; none where that is not known.
    #[must_use]
    pub fn quality(&self) -> Option<Likeness> {
        let mut sums = Sums::default();
        for (full, truth) in self.full.iter().zip(&self.truth) {
            sums.add(&full.picture, truth.as_ref()?, |_| true);
        }
        sums.likeness()
    }
}

/// How like two pictures are, or two sequences.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct Likeness {
    /// Of the mean squared error over all pixels that count, in dB, peak 1;
    /// none where they are equal.
    pub psnr_db: Option<f64>,
    /// The mean over frames of each one's PSNR; none where one is equal.
    pub mean_psnr_db: Option<f64>,
    /// Mean structural similarity over frames; none where no window of 11 x 11
    /// fits.
    pub ssim: Option<f64>,
}

/// Likenesses, frame by frame.
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

    fn likeness(&self) -> Option<Likeness> {
        let finite = |v: f64| v.is_finite().then_some(v);
        (self.frames > 0).then(|| Likeness {
            psnr_db: finite(decibels(self.squared / self.pixels)),
            mean_psnr_db: finite(self.psnr / self.frames as f64),
            ssim: (self.ssims > 0).then(|| self.ssim / self.ssims as f64),
        })
    }
}

fn decibels(mse: f64) -> f64 {
    -10.0 * mse.log10()
}

/// Pixels of the frame, or of its foreground: those where the model shows something.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct Part {
    /// Where they come from.
    pub pixels: Counts,
    /// Against the model in full.
    pub model: Option<Likeness>,
    /// Against ground truth.
    pub truth: Option<Likeness>,
}

/// One frame.
#[derive(Debug, Clone, Serialize)]
pub struct FrameQuality {
    /// From 0.
    pub number: usize,
    /// The reference that it was warped from.
    pub reference: Option<usize>,
    /// Whether it was rendered in full though it was to be warped.
    pub fell_back: bool,
    /// All of its pixels.
    pub frame: Part,
    /// Those where the model shows something.
    pub foreground: Part,
}

/// Frames of one way, as they come.
pub struct Measured<'a> {
    footage: &'a Footage,
    /// Those that came.
    pub frames: Vec<FrameQuality>,
    all: [Totals; 2],
}

/// Over all frames.
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
    /// Of no frame yet.
    #[must_use]
    pub fn new(footage: &'a Footage) -> Self {
        Self {
            footage,
            frames: vec![],
            all: Default::default(),
        }
    }

    /// Takes a frame of the footage's path.
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

    /// Of all frames, and of their foregrounds.
    #[must_use]
    pub fn totals(&self) -> [Part; 2] {
        self.all.map(|totals| totals.part())
    }
}
