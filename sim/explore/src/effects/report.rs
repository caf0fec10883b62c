//! Effects that a scene and a path call for, with the cost of each.

use potamoi_analysis::{Analysis, Finding, Hardware, LeftOut, Surroundings};
use potamoi_base::camera::Camera;
use potamoi_base::effects::{Choices, Effect};
use potamoi_cycles::effect_meter::EffectMeter;
use potamoi_reference::ReferenceUnits;
use potamoi_reference::observer::Observed;
use potamoi_scene::Scene;
use potamoi_system::system_model::System;
use potamoi_system::system_model::work::{Counted, FrameWork};
use schemars::JsonSchema;
use serde::Serialize;

use super::compare::{Forced, Without};
use super::hardware::{HardwareSaving, Savings};
use super::wall_time::{Pairs, RtlWall, Stopwatch, Wall};
use super::work::{Work, work_of};
use crate::{ConfigChoice, ExploreError, Progress};

/// A study of effects: scene, configuration, path and options.
pub struct EffectsStudy<'a> {
    /// The scene, with its default choices, seen by the path's first camera.
    pub scene: &'a Scene,
    /// Configuration that renders it.
    pub chosen: &'a ConfigChoice,
    /// Cameras of the path.
    pub path: &'a [Camera],
    /// Parts of the system around the units.
    pub around: Surroundings,
    /// Effects to force, and effects to leave out.
    pub choices: Choices,
    /// Pairs of timed runs, with and without an effect; wall times are their medians. 0: no timing.
    pub pairs: u32,
    /// Whether to run the frame on the Verilated units.
    pub rtl: bool,
}

/// Report of a study of effects.
#[derive(Debug, Serialize, JsonSchema)]
pub struct Effects {
    /// The scene's name.
    pub scene: String,
    /// The model's algorithm.
    pub algorithm: &'static str,
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Frames of the path.
    pub frames: usize,
    /// Hash of the configuration, 12 hexadecimal digits.
    pub configuration: String,
    /// Name of the preset, if it is one.
    pub preset: Option<&'static str>,
    /// Timed pairs of runs for each wall time.
    pub pairs: u32,
    /// All effects, required or not.
    pub effects: Vec<FoundEffect>,
    /// What leaving out all hardware saves that no camera of the scene needs.
    pub all_saved: HardwareSaving,
    /// Use of both units.
    pub units: Vec<UnitUse>,
    /// Results with effects forced, if any are.
    pub forced: Option<Forced>,
    /// Results with each effect left out.
    pub without: Vec<Without>,
    /// Wall time on the Verilated units, if requested.
    pub rtl: Option<RtlWall>,
}

impl EffectsStudy<'_> {
    /// Detects all effects and measures the cost of each.
    ///
    /// # Errors
    /// A scene that the configuration cannot render, or Verilog that cannot be built or run.
    pub fn run(&self, progress: &dyn Progress) -> Result<Effects, ExploreError> {
        let (scene, path) = (self.scene, self.path);
        let ConfigChoice { config, preset } = self.chosen;
        let analysis = Analysis::of(scene, path, config, self.around)?;
        let hardware = Hardware::of(scene, config)?;
        let watch = Stopwatch {
            scene,
            config,
            path,
            pairs: self.pairs,
        };
        let (effects, all_saved) = self.effects(&analysis, &hardware, &watch, progress)?;
        let choices = self.choices;
        let forced = match Effect::ALL.iter().any(|effect| choices.forces(*effect)) {
            true => {
                progress.now("forcing effects");
                let is_remote = self.around.is_remote;
                Some(Forced::find(&watch, &hardware, choices, is_remote)?)
            }
            false => None,
        };
        let mut without = vec![];
        for finding in &analysis.findings {
            if choices.leaves_out(finding.effect) {
                progress.now(&format!("leaving out {}", finding.effect));
                without.push(Without::find(&watch, finding)?);
            }
        }
        let rtl = match self.rtl {
            true => {
                progress.now("building and running the Verilated units");
                Some(watch.rtl(&hardware)?)
            }
            false => None,
        };
        Ok(Effects {
            scene: scene.name().to_owned(),
            algorithm: scene.model().algorithm(),
            width: scene.camera().width,
            height: scene.camera().height,
            frames: path.len(),
            configuration: config.hash(),
            preset: *preset,
            pairs: self.pairs,
            effects,
            all_saved,
            units: UnitUse::of(&hardware, &analysis),
            forced,
            without,
            rtl,
        })
    }

    /// Cost of each effect.
    fn effects(
        &self,
        analysis: &Analysis,
        hardware: &Hardware,
        watch: &Stopwatch<'_>,
        progress: &dyn Progress,
    ) -> Result<(Vec<FoundEffect>, HardwareSaving), ExploreError> {
        let (scene, config) = (self.scene, &self.chosen.config);
        progress.now("counting cycles");
        let mut meter = EffectMeter::new(config);
        let Counted { work, rendered, .. } = {
            let mut twins = ReferenceUnits::new(config);
            let mut units = Observed::new(&mut twins, config).by(&mut meter);
            let system = System::default();
            let (array, cache) = (system.array(), system.gpu.cache_bytes());
            FrameWork::rendered(scene, config, array, cache, None, &mut units)?
        };
        let (cycles, counts) = (meter.cycles(), rendered.counts);
        let done = work.total();
        let savings = Savings::new(scene, config, hardware, &done)?;
        let left = match analysis.calls_for(Effect::Disocclusion) {
            true => watch.pixels_left()?,
            false => 0,
        };
        let mut effects = vec![];
        for finding in &analysis.findings {
            progress.now(&format!("measuring {}", finding.effect));
            let wall = watch.wall(finding.effect, finding.is_called_for)?;
            let work = work_of(finding.effect, &cycles, &counts, left, scene);
            let is_there = watch.is_there(finding.effect);
            let mut found = FoundEffect::new(finding, work, wall, is_there, scene);
            if !finding.is_called_for {
                found.saving.hardware = Some(savings.of(finding.effect)?);
            }
            effects.push(found);
        }
        Ok((effects, savings.of_all()?))
    }
}

/// An effect with its cost.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct FoundEffect {
    /// Its name.
    pub name: &'static str,
    /// Degree of spherical harmonics, for that effect.
    pub degree: Option<u8>,
    /// Whether the scene and the path call for it.
    pub called_for: bool,
    /// Evidence for `called_for`.
    pub evidence: String,
    /// Cost of simulating it.
    pub cost: EffectCost,
    /// Saving by leaving it out.
    pub saving: EffectSaving,
}

/// Cost of simulating an effect.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct EffectCost {
    /// Work by unit.
    #[serde(flatten)]
    pub work: Work,
    /// Wall time of the simulator with the effect minus that without it, where both were run; 0
    /// where there is nothing to simulate.
    pub wall_ms: Option<f64>,
    /// The timed runs and their times.
    pub wall: Option<Wall>,
}

/// Saving by leaving out an effect that is not called for.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct EffectSaving {
    /// Wall time of the simulator; 0 for an effect that is called for, as it is not left out, and
    /// where there is nothing to simulate. `None` without timing.
    pub wall_ms: Option<f64>,
    /// Modelled cycles: 0, since the hardware does no work that is not called for.
    pub cycles: u64,
    /// What the configuration without the effect's hardware saves; `None` for an effect that is called
    /// for.
    pub hardware: Option<HardwareSaving>,
}

impl FoundEffect {
    /// `is_there` tells whether the simulator could do work for the effect.
    fn new(
        finding: &Finding,
        work: Work,
        wall: Option<Wall>,
        is_there: bool,
        scene: &Scene,
    ) -> Self {
        let called_for = finding.is_called_for;
        // What is not called for is not in what was counted, but for what all models have.
        let work = match (called_for, finding.effect) {
            (true, _) | (false, Effect::Warping) => work,
            (false, Effect::ViewMlp) if scene.facts().perceptron.is_some() => work,
            (false, _) => Work {
                cycles: work.cycles.map(|_| 0),
                amount: work.amount.map(|_| 0),
                ..work
            },
        };
        let nothing = (!called_for && !is_there).then_some(0.0);
        let taken = wall.map(|wall| wall.pairs.difference_ms).or(nothing);
        Self {
            name: finding.effect.name(),
            degree: finding.effect.degree(),
            called_for,
            evidence: finding.evidence.clone(),
            cost: EffectCost {
                work,
                wall_ms: taken,
                wall,
            },
            saving: EffectSaving {
                wall_ms: match called_for {
                    true => Some(0.0),
                    false => taken,
                },
                cycles: 0,
                hardware: None,
            },
        }
    }

    /// Medians of the timed pairs, if any.
    #[must_use]
    pub fn timed(&self) -> Option<Pairs> {
        self.cost.wall.map(|wall| wall.pairs)
    }

    /// Name, with its degree.
    #[must_use]
    pub fn title(&self) -> String {
        match self.degree {
            Some(degree) => format!("{}:{degree}", self.name),
            None => self.name.to_owned(),
        }
    }
}

/// A unit, and its parts that are left out.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct UnitUse {
    /// Name of its top module.
    pub unit: &'static str,
    /// Whether RTL simulation, and Verilog emitted for the scene, instantiate it.
    pub instantiated: bool,
    /// Whether the path's cameras use it.
    pub used_by_path: bool,
    /// Parts left out, with the reasons.
    pub left_out: Vec<LeftOut>,
}

impl UnitUse {
    fn of(hardware: &Hardware, analysis: &Analysis) -> Vec<Self> {
        let splats = |prefix: &str| {
            let own = hardware.left_out.iter();
            own.filter(|part| part.field.starts_with(prefix))
                .cloned()
                .collect()
        };
        // Colours of Gaussians are made of a field's features, whether one is in view or not.
        let makes_colours = analysis.calls_for(Effect::Trilinear);
        let is_in_view = analysis.seen.in_view > 0;
        vec![
            Self {
                unit: "gathering_unit",
                instantiated: hardware.gathers,
                used_by_path: hardware.gathers && (is_in_view || makes_colours),
                left_out: splats("g"),
            },
            Self {
                unit: "vector_unit",
                instantiated: hardware.computes,
                used_by_path: analysis.calls_for(Effect::Exponential) || makes_colours,
                left_out: splats("v"),
            },
        ]
    }
}
