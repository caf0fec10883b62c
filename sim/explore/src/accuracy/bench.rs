//! Trial of settings on one frame: quality, time, energy and area.

use std::cell::RefCell;

use potamoi_base::picture::Picture;
use potamoi_formats::config::{Config, Layer};
use potamoi_reference::ReferenceUnits;
use potamoi_scene::Scene;
use potamoi_system::system_model::work::{Counted, FrameWork, PathOptions, PathParts};
use potamoi_system::system_model::{ClockOrigin, Frames, Gathering, Model, Scenario, Variant};
use potamoi_warp::Profile;

use super::image_quality::{ImageQuality, PixelError};
use super::knobs::{Change, PathVariant, RenderChange, Setting};
use super::local_search::Paths;
use super::pareto_front::CostQuality;
use super::point::{Point, priced};
use super::price::Price;
use super::pricing::{Priced, Pricing};
use super::references::References;
use super::units::{UnitErrorCache, UnitErrors};
use crate::rendering::whole_float;
use crate::{ExploreError, Setup, store};

/// Frame rate of built-in paths.
const FPS: f64 = 30.0;

/// A frame rendered with settings, and its modelled cost.
struct Tried {
    config: Config,
    scene: Scene,
    picture: Picture,
    work: FrameWork,
    truth: Option<ImageQuality>,
    converged: ImageQuality,
    clock: (f64, ClockOrigin),
    is_estimated: bool,
    price: Priced,
}

/// A scene on which settings are tried.
pub struct Bench {
    /// The scene and its system, with every knob at its default.
    pub setup: Setup,
    /// Pictures that quality is measured against.
    pub references: References,
    /// The picture in floating point, which error bounds are derived beside.
    float: Picture,
    frames: u32,
    pricing: Pricing,
    known: UnitErrorCache,
    /// Results of path variants that were tried alone.
    alone: RefCell<Vec<(PathVariant, Moved)>>,
}

impl Bench {
    /// Renders what settings are compared with: the references of the scene, and its picture in
    /// floating point. Paths have `frames` frames.
    ///
    /// # Errors
    /// A scene that cannot be rendered.
    pub fn new(setup: Setup, frames: u32) -> Result<Self, ExploreError> {
        Ok(Self {
            references: References::of(&setup.scene)?,
            float: whole_float(&setup.scene)?.picture,
            frames,
            pricing: Pricing::new(frames),
            known: UnitErrorCache::default(),
            alone: RefCell::default(),
            setup,
        })
    }

    /// A configuration and a scene with settings applied.
    ///
    /// # Errors
    /// Settings that the configuration's rules or the scene's model refuse.
    pub fn apply(&self, settings: &[&Setting]) -> Result<(Config, Scene), ExploreError> {
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

    /// Cost and quality of settings, without unit errors; `None` where the price is not known.
    ///
    /// # Errors
    /// As [`Bench::point`].
    pub fn place(
        &self,
        settings: &[&Setting],
        paths: Paths,
        price: Price,
    ) -> Result<Option<CostQuality>, ExploreError> {
        let tried = self.tried(settings, paths)?;
        let own = &tried.price;
        let costs = [Some(own.frame_ns), own.energy_mj, own.area_mm2];
        Ok(priced(tried.converged, tried.truth, costs, price))
    }

    /// All measurements of settings, under the name of a knob and a label.
    ///
    /// # Errors
    /// Settings that do not fit the scene or each other.
    pub fn point(
        &self,
        knob: &str,
        label: &str,
        settings: &[&Setting],
    ) -> Result<Point, ExploreError> {
        let tried = self.tried(settings, Paths::Counted)?;
        let (scene, config) = (&tried.scene, &tried.config);
        let all = |holds: fn(&Change) -> bool| settings.iter().all(|s| holds(&s.change));
        let worst = match all(is_bounded) {
            false => None,
            true => {
                let bounds = self.bounds(scene, config)?;
                let (shown, float) = (&tried.picture, &self.float);
                Some(PixelError::new(shown, float, bounds.as_deref()))
            }
        };
        let total = tried.work.total();
        Ok(Point {
            knob: knob.to_owned(),
            setting: label.to_owned(),
            units: UnitErrors::of(scene, config, &self.known),
            truth: tried.truth,
            converged: tried.converged,
            float: all(keeps_float).then(|| ImageQuality::of(&tried.picture, &self.float)),
            worst,
            gather_cycles: total.gather_cycles,
            vector_cycles: total.vector_cycles,
            array_cycles: total.array_cycles,
            clock_ghz: tried.clock.0,
            clock_origin: tried.clock.1,
            frame_ns: tried.price.frame_ns,
            energy_mj: tried.price.energy_mj,
            area_mm2: tried.price.area_mm2,
            is_estimated: tried.is_estimated,
        })
    }

    /// Error bounds of pixels beside the picture in floating point, where they are derived.
    fn bounds(&self, scene: &Scene, config: &Config) -> Result<Option<Vec<f64>>, ExploreError> {
        let float = self.setup.scene.precision();
        let powers = self.known.vector_bounds(scene, config);
        Ok(scene.error_bounds_beside(config, float, &powers)?)
    }

    /// Renders with settings. Of several path variants the last counts.
    fn tried(&self, settings: &[&Setting], paths: Paths) -> Result<Tried, ExploreError> {
        let (config, scene) = self.apply(settings)?;
        let way = settings.iter().rev().find_map(|s| match s.change {
            Change::Path(way) => Some(way),
            _ => None,
        });
        let system = &self.setup.system;
        let (array, cache) = (system.array(), system.gpu.cache_bytes());
        let mut twins = ReferenceUnits::new(&config);
        let Counted { work, rendered, .. } =
            FrameWork::rendered(&scene, &config, array, cache, None, &mut twins)?;
        let basis = self.pricing.basis(&self.setup, &scene, &config)?;
        let price = self.pricing.price(&self.setup, &basis, &work)?;
        let mut tried = Tried {
            truth: self.references.truth(&rendered.picture),
            converged: self.references.converged(&rendered.picture),
            picture: rendered.picture,
            work,
            clock: (basis.clock_ghz, basis.clock_origin),
            is_estimated: basis.is_estimated,
            price,
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
                None => self.moved(&tried, way, &basis.model(&self.setup))?,
            };
            if settings.len() == 1 && known.is_none() {
                self.alone.borrow_mut().push((way, moved));
            }
            tried.move_by(&moved);
        }
        Ok(tried)
    }

    /// Quality and cost of a path variant relative to the same path in full, with the tried
    /// settings.
    fn moved(
        &self,
        tried: &Tried,
        way: PathVariant,
        model: &Model<'_>,
    ) -> Result<Moved, ExploreError> {
        let system = &self.setup.system;
        let (frames, window, phi) = match way {
            PathVariant::Warped { window, phi: None } | PathVariant::Chained { window }
                if window > self.frames =>
            {
                return Err(ExploreError::Refused(format!(
                    "a window of {window} in a path of {}: --frames {window} or more shows it",
                    self.frames
                )));
            }
            PathVariant::Warped { window, phi } => (Frames::Warped, window, phi),
            PathVariant::Chained { window } => (Frames::Chained, window, None),
            PathVariant::Half => (Frames::Half, self.frames, None),
        };
        let options = PathOptions {
            frames: self.frames,
            fps: FPS,
            window: window.min(self.frames),
            phi,
            profile: Profile::Potamoi,
            array: [system.array_rows.into(), system.array_columns.into()],
            is_double_buffered: system.array_double_buffered,
            cache: system.gpu.cache_bytes(),
            parts: PathParts::All,
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
        let own = outcome.float_quality;
        Ok(Moved {
            time: outcome.run.span_ns().mid() / full.run.span_ns().mid(),
            energy: (outcome.run.total_mj().zip(full.run.total_mj()))
                .map(|(own, full)| own.mid() / full.mid()),
            full: [own.full_db, own.full_ssim],
            truth: [own, full.float_quality].map(|of| [of.truth_db, of.truth_ssim]),
        })
    }
}

/// Whether a setting leaves the picture in floating point as it is.
fn keeps_float(change: &Change) -> bool {
    match change {
        Change::Config { .. } => true,
        Change::Scene(RenderChange::Precision(own)) => {
            own.stop_below.is_none() && own.alpha_min.is_none()
        }
        // That picture is in exact order, and leaves nothing out.
        Change::Scene(RenderChange::Order(_) | RenderChange::Without(_)) => true,
        Change::Scene(RenderChange::Profile(_) | RenderChange::Step(_)) | Change::Path(_) => false,
    }
}

/// Whether errors beside the picture in floating point may be bounded: where that stays as it is,
/// or differs by thresholds, whose decisions bounds include.
fn is_bounded(change: &Change) -> bool {
    keeps_float(change) || matches!(change, Change::Scene(RenderChange::Precision(_)))
}

/// Quality and cost of a path's frames relative to the same path in full.
#[derive(Debug, Clone, Copy)]
struct Moved {
    /// Ratio of time.
    time: f64,
    /// Ratio of energy, where known.
    energy: Option<f64>,
    /// PSNR in dB and SSIM against full frames.
    full: [Option<f64>; 2],
    /// PSNR and SSIM against the ground truth, of the variant and of full frames.
    truth: [[Option<f64>; 2]; 2],
}

impl Tried {
    /// Scales time and energy by the path's ratios, and shifts the quality as the path's.
    fn move_by(&mut self, moved: &Moved) {
        let [way, full] = moved.truth;
        self.converged = ImageQuality::path(moved.full, self.converged);
        self.truth = self.truth.map(|frame| frame.moved(way, full));
        let price = &mut self.price;
        price.frame_ns *= moved.time;
        price.energy_mj = price.energy_mj.zip(moved.energy).map(|(own, by)| own * by);
    }
}
