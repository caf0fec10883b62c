//! A frame with knobs set: what it shows, and what it takes.

use std::cell::RefCell;

use potamoi_base::effects::Choices;
use potamoi_base::picture::Picture;
use potamoi_base::ssim::ssim;
use potamoi_explore::{Setup, store};
use potamoi_formats::config::{Config, Layer};
use potamoi_reference::Twins;
use potamoi_scene::Scene;
use potamoi_system::soc::work::{Counted, FrameWork, PathOptions};
use potamoi_system::soc::{Frames, Gathering, Model, Scenario, Variant};
use potamoi_warp::Profile;
use serde::Serialize;

use super::Price;
use super::front::Place;
use super::knobs::{Change, Look, Setting, Way};
use super::units::{Known, UnitErrors};
use crate::failure::Failure;

/// Peak and frame rate of built-in paths.
const FPS: f64 = 30.0;

/// How like a picture is to another.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub(super) struct Likeness {
    /// Decibels of the mean squared error, peak 1, over all pixels; none where they are equal.
    pub(super) db: Option<f64>,
    /// Structural similarity, in pictures of 11 x 11 pixels or more.
    pub(super) ssim: Option<f64>,
}

impl Likeness {
    fn of(shown: &Picture, other: &Picture) -> Self {
        Self {
            db: shown.psnr(other, |_| true).filter(|db| db.is_finite()),
            ssim: ssim(shown, other, |_| true),
        }
    }

    /// Of a path's frames beside the model's, compared in floating point, as the hardware's formats
    /// show them: squared errors of the formats, on a frame in full, come to those of the path.
    fn path(of: [Option<f64>; 2], formats: Self) -> Self {
        let error = |db: Option<f64>| db.map_or(0.0, |db| 10f64.powf(-0.1 * db));
        let sum = error(of[0]) + error(formats.db);
        Self {
            db: (sum > 0.0).then(|| -10.0 * sum.log10()),
            ssim: of[1].zip(formats.ssim).map(|(own, formats)| own * formats),
        }
    }

    /// Of a frame in full, by as much more or less as a path's frames are beside it than the same
    /// path's in full.
    fn moved(self, of: [Option<f64>; 2], full: [Option<f64>; 2]) -> Self {
        let moved = |own: Option<f64>, i: usize| Some(own? + of[i]? - full[i]?);
        Self {
            db: moved(self.db, 0),
            ssim: moved(self.ssim, 1),
        }
    }
}

/// Errors of a picture's pixels beside the float model's, and what they cannot exceed.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub(super) struct PixelError {
    /// The largest of a channel.
    pub(super) measured: f64,
    /// The largest bound, by analysis; none where none is derived, or where the scene is not
    /// rendered as the float model is.
    pub(super) bound: Option<f64>,
    /// The largest part of its own bound that a pixel takes.
    pub(super) part_of_bound: Option<f64>,
    /// Decibels that all pixels at their bounds would have.
    pub(super) bound_db: Option<f64>,
}

impl PixelError {
    fn new(shown: &Picture, model: &Picture, bounds: Option<&[f64]>) -> Self {
        let off: Vec<f64> = (shown.rgb.iter().zip(&model.rgb))
            .map(|(a, b)| {
                let channels = a.iter().zip(b);
                channels.fold(0.0, |m, (a, b)| {
                    f64::max(m, (f64::from(*a) - f64::from(*b)).abs())
                })
            })
            .collect();
        let most = |all: &[f64]| all.iter().copied().fold(0.0, f64::max);
        let part = |bounds: &[f64]| {
            off.iter()
                .zip(bounds)
                .map(|(o, b)| o / b)
                .fold(0.0, f64::max)
        };
        let mean =
            |bounds: &[f64]| bounds.iter().map(|b| b * b).sum::<f64>() / bounds.len().max(1) as f64;
        Self {
            measured: most(&off),
            bound: bounds.map(most),
            part_of_bound: bounds.map(part),
            bound_db: bounds.map(|b| -10.0 * mean(b).log10()),
        }
    }
}

/// What was found of a setting.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct Point {
    pub(super) knob: String,
    pub(super) setting: String,
    /// What the operations of the units are off by.
    pub(super) units: UnitErrors,
    /// Beside the float model.
    pub(super) model: Likeness,
    /// Beside what the model was sampled from, where that is known.
    pub(super) truth: Option<Likeness>,
    /// Largest error of a channel of a pixel beside the float model; not measured over paths.
    pub(super) worst: Option<PixelError>,
    /// Of a frame in full.
    pub(super) gather_cycles: u64,
    pub(super) vector_cycles: u64,
    pub(super) array_cycles: u64,
    /// Nanoseconds of a frame, of a path its mean.
    pub(super) frame_ns: f64,
    /// Millijoules of a frame; none where no formulas are of the units.
    pub(super) energy_mj: Option<f64>,
    /// Square millimetres of both units' cells at 12 nm, by formulas; likewise.
    pub(super) area_mm2: Option<f64>,
}

impl Point {
    pub(super) fn place(&self) -> Place {
        place(self.model, self.truth, self.frame_ns)
    }

    /// With another cost than time; none where that is not known.
    pub(super) fn priced(&self, price: Price) -> Option<Place> {
        let costs = [Some(self.frame_ns), self.energy_mj, self.area_mm2];
        priced(self.model, self.truth, costs, price)
    }
}

/// Quality beside the truth where that is known, else beside the model. Equal pictures are
/// as good as any.
fn place(model: Likeness, truth: Option<Likeness>, cost: f64) -> Place {
    Place {
        cost,
        quality: truth.unwrap_or(model).db.unwrap_or(f64::INFINITY),
    }
}

/// [`place`] by one of time, energy and area, where that is known.
fn priced(
    model: Likeness,
    truth: Option<Likeness>,
    costs: [Option<f64>; 3],
    price: Price,
) -> Option<Place> {
    price.of(costs).map(|cost| place(model, truth, cost))
}

/// A frame with settings, as it is shown and what it takes.
struct Tried {
    config: Config,
    scene: Scene,
    picture: Picture,
    work: FrameWork,
    model: Likeness,
    truth: Option<Likeness>,
    frame_ns: f64,
    energy_mj: Option<f64>,
    area_mm2: Option<f64>,
    is_path: bool,
}

/// Where what a path's frames are beside the same in full comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Paths {
    /// From the path with all settings.
    Counted,
    /// From the path with the default's, where it was counted.
    AsAlone,
}

/// A scene to try settings on.
pub(super) struct Bench {
    pub(super) setup: Setup,
    model: Picture,
    truth: Option<Picture>,
    frames: u32,
    known: Known,
    /// Of ways that were tried by themselves.
    alone: RefCell<Vec<(Way, Moved)>>,
}

impl Bench {
    pub(super) fn new(setup: Setup, frames: u32) -> Result<Self, Failure> {
        let scene = &setup.scene;
        // What pictures are compared with leaves nothing out.
        let mut whole = scene.clone();
        whole.set_choices(Choices::default());
        Ok(Self {
            model: whole.render_float()?.picture,
            truth: match scene.analytic() {
                Some(_) => Some(scene.render_truth()?.picture),
                None => None,
            },
            frames,
            known: Known::default(),
            alone: RefCell::default(),
            setup,
        })
    }

    /// A configuration and a scene with settings applied.
    pub(super) fn apply(&self, settings: &[&Setting]) -> Result<(Config, Scene), Failure> {
        let mut scene = self.setup.scene.clone();
        let mut layers = vec![];
        for setting in settings {
            match &setting.change {
                Change::Config { derived, toml } => layers.push(Layer { derived, toml }),
                Change::Scene(look) => look.apply(&mut scene)?,
                Change::Path(_) => {}
            }
        }
        let config = match layers.is_empty() {
            true => self.setup.config.clone(),
            false => self.setup.config.with(&layers, "knobs")?,
        };
        Ok((config, scene))
    }

    /// Where settings lie, without what their results are off by; none where the price is not known.
    ///
    /// # Errors
    /// As [`Bench::point`].
    pub(super) fn place(
        &self,
        settings: &[&Setting],
        paths: Paths,
        price: Price,
    ) -> Result<Option<Place>, Failure> {
        let tried = self.tried(settings, paths)?;
        let costs = [Some(tried.frame_ns), tried.energy_mj, tried.area_mm2];
        Ok(priced(tried.model, tried.truth, costs, price))
    }

    /// All that is said of settings.
    ///
    /// # Errors
    /// Settings that do not fit the scene or each other.
    pub(super) fn point(
        &self,
        knob: &str,
        label: &str,
        settings: &[&Setting],
    ) -> Result<Point, Failure> {
        let tried = self.tried(settings, Paths::Counted)?;
        let (scene, config) = (&tried.scene, &tried.config);
        let worst = match tried.is_path {
            true => None,
            false => {
                let bounds = self.bounds(settings, scene, config)?;
                let (shown, model) = (&tried.picture, &self.model);
                Some(PixelError::new(shown, model, bounds.as_deref()))
            }
        };
        let total = tried.work.total();
        Ok(Point {
            knob: knob.to_owned(),
            setting: label.to_owned(),
            units: UnitErrors::of(scene, config, &self.known),
            model: tried.model,
            truth: tried.truth,
            worst,
            gather_cycles: total.gather_cycles,
            vector_cycles: total.vector_cycles,
            array_cycles: total.array_cycles,
            frame_ns: tried.frame_ns,
            energy_mj: tried.energy_mj,
            area_mm2: tried.area_mm2,
        })
    }

    /// What pixels cannot be off by more than, where settings leave the float model as it is.
    fn bounds(
        &self,
        settings: &[&Setting],
        scene: &Scene,
        config: &Config,
    ) -> Result<Option<Vec<f64>>, Failure> {
        let is_same_float = |s: &&Setting| match s.change {
            Change::Scene(Look::Precision(_)) | Change::Config { .. } | Change::Path(_) => true,
            Change::Scene(_) => false,
        };
        if !settings.iter().all(is_same_float) {
            return Ok(None);
        }
        let float = self.setup.scene.precision();
        let powers = self.known.vector_bounds(scene, config);
        Ok(scene.error_bounds_beside(config, float, &powers)?)
    }

    /// Renders with settings; of those of paths the last counts.
    fn tried(&self, settings: &[&Setting], paths: Paths) -> Result<Tried, Failure> {
        let (config, scene) = self.apply(settings)?;
        let way = settings.iter().rev().find_map(|s| match s.change {
            Change::Path(way) => Some(way),
            _ => None,
        });
        let system = &self.setup.system;
        let (array, cache) = (system.array(), system.gpu.cache_bytes);
        let mut twins = Twins::new(&config);
        let Counted { work, rendered, .. } =
            FrameWork::rendered(&scene, &config, array, cache, None, &mut twins)?;
        let own = self.setup.costs_of(&scene, &config).ok();
        let used = own.as_ref().unwrap_or(self.setup.costs());
        let model = self.setup.model_of(&config, used);
        let run = model.frame(&work, Gathering::Unit)?;
        let mut tried = Tried {
            model: Likeness::of(&rendered.picture, &self.model),
            truth: (self.truth.as_ref()).map(|truth| Likeness::of(&rendered.picture, truth)),
            picture: rendered.picture,
            work,
            frame_ns: run.span_ns,
            energy_mj: own.as_ref().map(|_| run.energy.total_mj()),
            area_mm2: own.as_ref().map(|own| own.area_mm2),
            is_path: way.is_some(),
            config,
            scene,
        };
        if let Some(way) = way {
            let known = self
                .alone
                .borrow()
                .iter()
                .find(|own| own.0 == way)
                .map(|own| own.1);
            let moved = match known.filter(|_| paths == Paths::AsAlone) {
                Some(moved) => moved,
                None => self.moved(&tried, way, &model)?,
            };
            if settings.len() == 1 && known.is_none() {
                self.alone.borrow_mut().push((way, moved));
            }
            tried.move_by(&moved);
        }
        Ok(tried)
    }

    /// What a way's frames are beside the same path's in full, with the settings that were tried.
    fn moved(&self, tried: &Tried, way: Way, model: &Model<'_>) -> Result<Moved, Failure> {
        let system = &self.setup.system;
        let (frames, window, phi) = match way {
            Way::Warped { window, phi: None } | Way::Chained { window } if window > self.frames => {
                return Err(Failure::Usage(format!(
                    "a window of {window} in a path of {}: --frames {window} or more shows it",
                    self.frames
                )));
            }
            Way::Warped { window, phi } => (Frames::Warped, window, phi),
            Way::Chained { window } => (Frames::Chained, window, None),
            Way::Half => (Frames::Half, self.frames, None),
        };
        let options = PathOptions {
            frames: self.frames,
            fps: FPS,
            window: window.min(self.frames),
            phi,
            profile: Profile::Potamoi,
            array: [system.array_rows.into(), system.array_columns.into()],
            is_double_buffered: system.array_double_buffered,
            cache: system.gpu.cache_bytes,
        };
        let (path, _) = store()?.path(&tried.scene, &tried.config, &options, &|| ())?;
        let run = |frames| {
            let variant = Variant {
                name: "",
                frames,
                gathering: Gathering::Unit,
            };
            model.run(&path, variant, Scenario::Local)
        };
        let (outcome, full) = (run(frames)?.0, run(Frames::Full)?.0);
        let own = outcome.quality;
        Ok(Moved {
            time: outcome.run.span_ns / full.run.span_ns,
            energy: outcome.run.energy.total_mj() / full.run.energy.total_mj(),
            model: [own.model_db, own.model_ssim],
            truth: [own, full.quality].map(|of| [of.truth_db, of.truth_ssim]),
        })
    }
}

/// What a path's frames are beside the same path's in full.
#[derive(Debug, Clone, Copy)]
struct Moved {
    /// Shares of time and energy.
    time: f64,
    energy: f64,
    /// Decibels and similarity beside the model's.
    model: [Option<f64>; 2],
    /// The same beside the truth, of the way and in full.
    truth: [[Option<f64>; 2]; 2],
}

impl Tried {
    /// Time and energy become the frame's times the way's shares; the likeness moves as the path's.
    fn move_by(&mut self, moved: &Moved) {
        let [way, full] = moved.truth;
        self.model = Likeness::path(moved.model, self.model);
        self.truth = self.truth.map(|frame| frame.moved(way, full));
        self.frame_ns *= moved.time;
        self.energy_mj = self.energy_mj.map(|own| own * moved.energy);
    }
}
