//! Switching activity for the power of units.

use std::collections::BTreeMap;

use potamoi_formats::config::Config;
use potamoi_reference::ReferenceUnits;
use potamoi_reference::observer::Observed;
use potamoi_scene::Scene;
use potamoi_synth::{
    Extent, Order, POWER_STEPS, STEPS, Sampler, SynthError, SynthesisedUnit, UnitKind, Windows,
    estimate,
};

use super::flow::Flow;
use crate::ExploreError;

/// Default scenes for the gathering unit and the vector unit: voxels of eight vertices, and the
/// exponentials of splats.
const SCENES: [&str; 2] = ["lantern", "garden"];

/// Scene whose work drives the netlists for power.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum ActivityScene {
    /// `lantern` for the gathering unit, `garden` for the vector unit.
    Default,
    /// One scene for both units.
    Named(String),
    /// None: power is left out.
    None,
}

/// Activity for power estimates.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Activity {
    /// Scene whose work is used.
    pub scene: ActivityScene,
    /// Whether netlists are simulated as a whole, which is slower, rather than in slices.
    pub whole: bool,
}

/// Scenes whose work is used, each once.
pub struct ActivityScenes(Vec<(String, Scene)>);

impl ActivityScenes {
    /// Opens the scenes of the units.
    ///
    /// # Errors
    /// A scene that cannot be opened.
    pub fn open(activity: &Activity, units: &[UnitKind]) -> Result<Self, ExploreError> {
        let mut scenes: Vec<(String, Scene)> = vec![];
        for name in units.iter().filter_map(|unit| activity.scene(*unit)) {
            if scenes.iter().all(|(known, _)| known != name) {
                scenes.push((name.to_owned(), Scene::open(name)?));
            }
        }
        Ok(Self(scenes))
    }

    /// The scenes.
    pub fn scenes(&self) -> impl Iterator<Item = &Scene> {
        self.0.iter().map(|(_, scene)| scene)
    }

    /// Renders the scenes with all operations that they use; a unit that lacks some is given its
    /// part of the work.
    ///
    /// # Errors
    /// A scene that cannot be rendered.
    pub fn work(self, config: &Config) -> Result<ActivityWork, ExploreError> {
        let mut config = config.clone();
        for op in Config::default().vu.ops {
            if !config.vu.ops.contains(&op) {
                config.vu.ops.push(op);
            }
        }
        // The vector unit's work on splats is what it is without a splat unit.
        let plain = Config {
            su: None,
            ..config.clone()
        };
        let sampled = |scene: &Scene, config: &Config| -> Result<Sampler, ExploreError> {
            let mut sampler = Sampler::new(config);
            let mut twins = ReferenceUnits::new(config);
            let mut units = Observed::new(&mut twins, config).by(&mut sampler);
            scene.render_fixed(config, &mut units)?;
            Ok(sampler)
        };
        let mut work = BTreeMap::new();
        for (name, scene) in self.0 {
            let splats = match config.su.is_some() && scene.model().is_splats() {
                true => Some(sampled(&scene, &config)?),
                false => None,
            };
            let others = sampled(&scene, &plain)?;
            work.insert(name, SampledScene { others, splats });
        }
        Ok(ActivityWork(work))
    }
}

/// Rendered work, by scene.
pub struct ActivityWork(BTreeMap<String, SampledScene>);

/// Sampled work of a scene.
struct SampledScene {
    /// Of gathering unit and vector unit.
    others: Sampler,
    /// Of the splat unit.
    splats: Option<Sampler>,
}

impl Activity {
    /// Steps of a unit: synthesis, and power where it is estimated.
    #[must_use]
    pub fn steps(&self) -> u64 {
        match (&self.scene, self.whole) {
            (ActivityScene::None, _) => STEPS,
            (_, false) => STEPS + POWER_STEPS,
            // Both runs of the whole netlist.
            (_, true) => STEPS + 2,
        }
    }

    fn scene(&self, unit: UnitKind) -> Option<&str> {
        let default = match unit {
            UnitKind::Gathering | UnitKind::ArrayMac => SCENES[0],
            UnitKind::Vector | UnitKind::Splat => SCENES[1],
        };
        match &self.scene {
            ActivityScene::Default => Some(default),
            ActivityScene::Named(name) => Some(name),
            ActivityScene::None => None,
        }
    }

    /// Adds the power of a synthesised unit.
    ///
    /// # Errors
    /// As [`estimate`]; a netlist with wrong results is a failed check.
    pub fn add(
        &self,
        (config, unit): (&Config, UnitKind),
        made: &mut SynthesisedUnit,
        work: &ActivityWork,
        flow: &Flow<'_>,
        step: &dyn Fn(),
    ) -> Result<(), ExploreError> {
        let Some(scene) = self.scene(unit) else {
            return Ok(());
        };
        let sampled = work.0.get(scene);
        let gather = sampled.and_then(|own| own.others.gather_window());
        let vector = sampled.and_then(|own| own.others.vector_window());
        let splat = sampled.and_then(|own| own.splats.as_ref()?.splat_window());
        let order = Order {
            config,
            unit,
            library: flow.library,
            tools: flow.tools,
            made,
            scene,
            windows: Windows {
                gather: gather.as_ref(),
                vector: vector.as_ref(),
                splat: splat.as_ref(),
            },
            extent: match self.whole {
                true => Extent::Whole,
                false => Extent::Slices,
            },
            step,
        };
        let found = estimate(&order, flow.cache).map_err(wrong)?;
        if let Some(remade) = found.remade {
            *made = remade;
        }
        made.report.power = Some(found.power);
        Ok(())
    }
}

/// Turns a netlist's wrong results into a failed check.
fn wrong(error: SynthError) -> ExploreError {
    match error {
        SynthError::Rtl(error) => ExploreError::Rtl(*error),
        other => ExploreError::Synth(other),
    }
}
