//! Time, energy and area of settings, by one method for all of a study.
//!
//! The default configuration's units are synthesised, most others are not. Figures of the two methods side
//! by side would show the methods' difference as that of the settings. Where a setting changes a unit,
//! formulas therefore give the change alone: the ratio of clock and area, and the difference of energy,
//! whose larger part is the GPU's and the memory's. What formulas do not cover stays unknown.

use std::cell::{OnceCell, RefCell};
use std::rc::Rc;

use potamoi_formats::config::Config;
use potamoi_scene::Scene;
use potamoi_synth::UnitKind;
use potamoi_synth::grid::is_same_unit;
use potamoi_system::system_model::work::FrameWork;
use potamoi_system::system_model::{Clock, ClockOrigin, Costs, Gathering, Model};

use crate::{ExploreError, Setup};

/// Time, energy and area of a frame among many like it.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Priced {
    /// Nanoseconds of a frame, between both bounds of the GPU's kernels.
    pub(super) frame_ns: f64,
    /// Millijoules of a frame.
    pub(super) energy_mj: Option<f64>,
    /// Cell area of the units in square millimetres.
    pub(super) area_mm2: Option<f64>,
}

/// Costs of a configuration's units, and what stands between its formulas and the default's synthesis.
pub(super) struct Basis {
    costs: Costs,
    /// The accelerator's clock.
    pub(super) clock_ghz: f64,
    /// Its origin.
    pub(super) clock_origin: ClockOrigin,
    /// Whether formulas give the change of a unit.
    pub(super) is_estimated: bool,
    beside: Rc<Beside>,
}

/// The default by its own figures beside the default with some units by formulas.
#[derive(Debug)]
struct Beside {
    clock_ratio: f64,
    area_ratio: Option<f64>,
    energy_mj: Option<f64>,
}

impl Beside {
    /// Nothing is by formulas.
    const NONE: Self = Self {
        clock_ratio: 1.0,
        area_ratio: Some(1.0),
        energy_mj: Some(0.0),
    };
}

/// Prices of settings beside a setup's configuration.
pub(super) struct Pricing {
    /// Frames that are scheduled, one like the other.
    frames: usize,
    work: OnceCell<FrameWork>,
    known: RefCell<Vec<(Vec<UnitKind>, Rc<Beside>)>>,
}

impl Pricing {
    pub(super) fn new(frames: u32) -> Self {
        Self {
            frames: frames.max(1) as usize,
            work: OnceCell::new(),
            known: RefCell::default(),
        }
    }

    /// Costs of a configuration; `setup` has the default.
    pub(super) fn basis(
        &self,
        setup: &Setup,
        scene: &Scene,
        config: &Config,
    ) -> Result<Basis, ExploreError> {
        let units = [UnitKind::Gathering, UnitKind::Vector, UnitKind::Splat];
        let changed = units.map(|unit| (unit, !is_same_unit(&setup.config, config, unit)));
        let changed = changed.into_iter().filter(|own| own.1).map(|own| own.0);
        let changed: Vec<UnitKind> = changed.collect();
        let costs = setup.costs_of((scene, config), &changed)?;
        let beside = match changed.is_empty() {
            true => Rc::new(Beside::NONE),
            false => self.beside(setup, &changed)?,
        };
        let Clock { ghz, origin, .. } = costs.clock;
        Ok(Basis {
            clock_ghz: ghz * beside.clock_ratio,
            clock_origin: origin,
            is_estimated: !changed.is_empty(),
            costs,
            beside,
        })
    }

    /// The frame that is rendered again and again.
    pub(super) fn price(
        &self,
        setup: &Setup,
        basis: &Basis,
        work: &FrameWork,
    ) -> Result<Priced, ExploreError> {
        let alone = self.modelled(&basis.model(setup), work)?;
        let beside = &basis.beside;
        Ok(Priced {
            energy_mj: alone.energy_mj.zip(beside.energy_mj).map(|(a, b)| a + b),
            area_mm2: alone.area_mm2.zip(beside.area_ratio).map(|(a, b)| a * b),
            ..alone
        })
    }

    fn modelled(&self, model: &Model<'_>, work: &FrameWork) -> Result<Priced, ExploreError> {
        let run = model.repeated(work, Gathering::Unit, self.frames)?;
        Ok(Priced {
            frame_ns: run.span_ns().mid() / self.frames as f64,
            energy_mj: run.total_mj().map(|mj| mj.mid()),
            area_mm2: model.costs.area_mm2,
        })
    }

    /// The default with units of these kinds by formulas.
    fn beside(&self, setup: &Setup, units: &[UnitKind]) -> Result<Rc<Beside>, ExploreError> {
        let known = self.known.borrow();
        if let Some((_, found)) = known.iter().find(|own| own.0 == units) {
            return Ok(Rc::clone(found));
        }
        drop(known);
        let work = match self.work.get() {
            Some(work) => work,
            None => {
                let found = setup.frame()?;
                self.work.get_or_init(|| found)
            }
        };
        let (scene, config) = (&setup.scene, &setup.config);
        let costs = setup.costs_of((scene, config), units)?;
        let own = self.modelled(&setup.model(), work)?;
        let estimated = self.modelled(&setup.model_of(&costs), work)?;
        let minus = |a: Option<f64>, b: Option<f64>| Some(a? - b?);
        let over = |a: Option<f64>, b: Option<f64>| Some(a? / b?);
        let found = Rc::new(Beside {
            clock_ratio: setup.costs().clock.ghz / costs.clock.ghz,
            area_ratio: over(own.area_mm2, estimated.area_mm2),
            energy_mj: minus(own.energy_mj, estimated.energy_mj),
        });
        self.known
            .borrow_mut()
            .push((units.to_vec(), Rc::clone(&found)));
        Ok(found)
    }
}

impl Basis {
    /// The system with these units.
    pub(super) fn model<'a>(&'a self, setup: &'a Setup) -> Model<'a> {
        Model {
            clock_ghz: self.clock_ghz,
            ..setup.model_of(&self.costs)
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use potamoi_formats::config::Layer;
    use potamoi_system::system_model::System;

    use super::*;
    use crate::ConfigChoice;

    fn setup(scene: &str) -> Setup {
        let scene = Scene::open(scene).unwrap();
        let chosen = ConfigChoice::for_scene(&scene).unwrap();
        Setup::new(chosen, &System::default(), scene, None).unwrap()
    }

    /// Areas of 22 to 26 lanes: priced, and each by the best that is known of it.
    fn areas(setup: &Setup) -> [Vec<f64>; 2] {
        let pricing = Pricing::new(2);
        let work = setup.frame().unwrap();
        let both = (22..=26).map(|lanes| {
            let toml = format!("vu.lanes = {lanes}");
            let layer = Layer {
                derived: &[],
                toml: &toml,
            };
            let config = setup.config.with(&[layer], "test").unwrap();
            let basis = pricing.basis(setup, &setup.scene, &config).unwrap();
            let priced = pricing.price(setup, &basis, &work).unwrap();
            let best = setup.costs_of((&setup.scene, &config), &[]).unwrap();
            [priced.area_mm2.unwrap(), best.area_mm2.unwrap()]
        });
        let both: Vec<_> = both.collect();
        [0, 1].map(|of| both.iter().map(|own| own[of]).collect())
    }

    /// Each lane adds the same. The best that is known of 24 lanes is a synthesis, of the others formulas,
    /// whose difference looks like that of a lane.
    #[test]
    fn every_lane_adds_the_same_area() {
        let setup = setup("lantern");
        let spread = |areas: &[f64]| {
            let steps: Vec<f64> = areas.windows(2).map(|two| two[1] - two[0]).collect();
            let low = steps.iter().copied().fold(f64::INFINITY, f64::min);
            let high = steps.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            (high - low) / (areas[4] - areas[0]) * 4.0
        };
        let [priced, best] = areas(&setup);
        assert!(spread(&priced) < 1e-6, "{priced:?}");
        assert!(spread(&best) > 0.05, "{best:?}");
        assert_eq!(Some(priced[2]), setup.costs().area_mm2);
    }

    /// A default is priced as the model of its system has it, and a unit that no setting changes too.
    #[test]
    fn the_default_is_as_modelled() {
        let setup = setup("lantern");
        let pricing = Pricing::new(3);
        let work = setup.frame().unwrap();
        let basis = pricing.basis(&setup, &setup.scene, &setup.config).unwrap();
        let priced = pricing.price(&setup, &basis, &work).unwrap();
        let run = setup.model().repeated(&work, Gathering::Unit, 3).unwrap();
        assert_eq!(priced.frame_ns, run.span_ns().mid() / 3.0);
        assert_eq!(priced.energy_mj, run.total_mj().map(|mj| mj.mid()));
        assert_eq!(priced.area_mm2, setup.costs().area_mm2);
        assert_eq!(basis.clock_origin, setup.costs().clock.origin);
    }
}
