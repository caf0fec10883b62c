//! Wall time of the simulator with and without an effect, in pairs.

use std::time::Instant;

use potamoi_analysis::{Hardware, Holes};
use potamoi_base::camera::Camera;
use potamoi_base::effects::{Choices, Effect};
use potamoi_formats::config::Config;
use potamoi_reference::ReferenceUnits;
use potamoi_rtl::{RtlCycles, RtlUnits};
use potamoi_scene::Scene;
use potamoi_warp::{Frame, Plan, PlanOptions, Profile, ReferenceFrom, Renderer, Sequence, Warper};
use schemars::JsonSchema;
use serde::Serialize;

use crate::ExploreError;

/// Window: targets of a reference.
const WINDOW: u32 = 16;

/// Times runs of a scene and path in pairs.
pub(super) struct Stopwatch<'a> {
    /// The scene, with its default choices.
    pub(super) scene: &'a Scene,
    pub(super) config: &'a Config,
    pub(super) path: &'a [Camera],
    pub(super) pairs: u32,
}

/// Wall time with and without an effect.
#[derive(Debug, Clone, Copy, Serialize, JsonSchema)]
pub struct Wall {
    /// What was timed.
    pub of: &'static str,
    /// Medians of the runs.
    #[serde(flatten)]
    pub pairs: Pairs,
}

/// Medians of interleaved runs, in milliseconds.
#[derive(Debug, Clone, Copy, Serialize, JsonSchema)]
pub struct Pairs {
    /// With the effect.
    pub with_ms: f64,
    /// Without the effect.
    pub without_ms: f64,
    /// Median of the differences within pairs.
    pub difference_ms: f64,
    /// Half of the range of those differences; a smaller difference is noise. `None` for a single
    /// pair.
    pub spread_ms: Option<f64>,
}

impl Pairs {
    /// Medians of pairs; `None` without pairs.
    fn of(times: [Vec<f64>; 2]) -> Option<Self> {
        if times.iter().any(Vec::is_empty) {
            return None;
        }
        let pairs = times[0].iter().zip(&times[1]);
        let differences: Vec<f64> = pairs.map(|(with, without)| with - without).collect();
        let least = differences.iter().copied().fold(f64::INFINITY, f64::min);
        let most = differences
            .iter()
            .copied()
            .fold(f64::NEG_INFINITY, f64::max);
        let pairs_made = differences.len();
        let [with_ms, without_ms] = times.map(median);
        Some(Self {
            with_ms,
            without_ms,
            difference_ms: median(differences),
            spread_ms: (pairs_made > 1).then_some((most - least) / 2.0),
        })
    }

    /// Difference and spread as text.
    #[must_use]
    pub fn words(&self) -> String {
        format!(
            "{:.2} ms ({}) of {:.2} ms",
            self.difference_ms,
            self.spread_ms
                .map_or_else(|| "one pair".to_owned(), |ms| format!("spread {ms:.2}")),
            self.with_ms
        )
    }
}

/// Wall time of the frame on the Verilated units.
#[derive(Debug, Serialize, JsonSchema)]
pub struct RtlWall {
    /// With the whole configuration and both units, and without the parts that the scene does not
    /// call for; `None` without timed pairs.
    pub wall: Option<Pairs>,
    /// Cycles, equal in both.
    pub cycles: RtlCycles,
    /// Whether picture, counts and cycles are equal.
    pub is_same: bool,
}

fn median(mut all: Vec<f64>) -> f64 {
    all.sort_by(f64::total_cmp);
    let middle = all.len() / 2;
    match all.len() % 2 {
        0 => all[middle - 1..=middle].iter().sum::<f64>() / 2.0,
        _ => all[middle],
    }
}

impl Stopwatch<'_> {
    pub(super) fn chosen(&self, choices: Choices) -> Scene {
        let mut scene = self.scene.clone();
        scene.set_choices(choices);
        scene
    }

    /// Runs both alternately, after one warm-up run of each; `None` without pairs.
    pub(super) fn in_pairs<T>(
        &self,
        mut run: impl FnMut(bool) -> Result<T, ExploreError>,
    ) -> Result<Option<Pairs>, ExploreError> {
        let mut times = [vec![], vec![]];
        for pair in 0..=self.pairs {
            // Each comes first in every other pair.
            let order = [pair % 2 == 0, pair % 2 != 0];
            for with in order {
                let begun = Instant::now();
                run(with)?;
                if pair > 0 {
                    times[usize::from(!with)].push(begun.elapsed().as_secs_f64() * 1e3);
                }
            }
        }
        Ok(Pairs::of(times))
    }

    /// Time with and without an effect; `None` where there is nothing to run or to leave out.
    pub(super) fn wall(
        &self,
        effect: Effect,
        is_called_for: bool,
    ) -> Result<Option<Wall>, ExploreError> {
        let Some(of) = self.timed(effect).filter(|_| self.pairs > 0) else {
            return Ok(None);
        };
        let choices = [
            Choices::default().force(effect),
            Choices::default().leave_out(effect),
        ];
        if of == PATH && self.path.len() < 2 {
            return Ok(None);
        }
        if effect == Effect::Disocclusion {
            if !is_called_for {
                return Ok(None);
            }
            let pairs = self.in_pairs(|with| match with {
                true => self.warped(self.scene, false),
                false => self.with_holes(),
            })?;
            return Ok(pairs.map(|pairs| Wall { of, pairs }));
        }
        if effect == Effect::Warping {
            let pairs = self.in_pairs(|with| match (with, is_called_for) {
                (true, _) => self.warped(self.scene, true).map(|_| ()),
                (false, false) => self.warped(self.scene, false).map(|_| ()),
                (false, true) => self.full().map(|_| ()),
            })?;
            return Ok(pairs.map(|pairs| Wall { of, pairs }));
        }
        let scenes = match is_called_for {
            true => [Choices::default(), choices[1]],
            false => [choices[0], Choices::default()],
        }
        .map(|choices| self.chosen(choices));
        let pairs = self.in_pairs(|with| {
            let scene = &scenes[usize::from(!with)];
            match of {
                FLOAT => drop(scene.render_float()?),
                _ => drop(scene.render_fixed(self.config, &mut ReferenceUnits::new(self.config))?),
            }
            Ok(())
        })?;
        Ok(pairs.map(|pairs| Wall { of, pairs }))
    }

    /// Whether the simulator could do work for an effect here, called for or not.
    pub(super) fn is_there(&self, effect: Effect) -> bool {
        self.timed(effect).is_some()
    }

    /// What to time for an effect.
    fn timed(&self, effect: Effect) -> Option<&'static str> {
        let facts = self.scene.facts();
        let is_splats = self.scene.model().is_splats();
        let is_table = !facts.tables.is_empty();
        Some(match effect {
            Effect::SphericalHarmonics(degree)
                if usize::from(degree) <= facts.stored_harmonics() =>
            {
                match facts.perceptron {
                    None => FLOAT,
                    Some(_) => FIXED,
                }
            }
            Effect::Sorting if is_splats => FLOAT,
            Effect::EarlyTermination => match is_splats || facts.most_opaque.is_some() {
                true => FLOAT,
                false => FIXED,
            },
            Effect::ViewMlp if facts.perceptron.is_some() => FIXED,
            Effect::VoidTest if is_table && !is_splats => FIXED,
            Effect::OctreeMerging | Effect::Trilinear if is_splats => FIXED,
            Effect::Trilinear | Effect::Exponential => FIXED,
            Effect::HashLevels if facts.hashed_tables() > 0 => FIXED,
            Effect::Warping | Effect::Disocclusion => PATH,
            _ => return None,
        })
    }

    /// The path's frames, warped from references.
    pub(super) fn warped(
        &self,
        renderer: &dyn Renderer,
        warps_still: bool,
    ) -> Result<Vec<Frame>, ExploreError> {
        let options = PlanOptions {
            window: WINDOW,
            reference: ReferenceFrom::Predicted,
            lead: None,
        };
        let plan = Plan::new(self.path, &options)?;
        let mut rule = Profile::Potamoi.rule();
        rule.warps_still = warps_still;
        let warper = Warper {
            renderer,
            geometry: None,
            rule,
        };
        let frames = Sequence::new(warper, self.path, &plan, &[]);
        Ok(frames.collect::<Result<_, _>>()?)
    }

    /// Pixels of warped frames that remain to be rendered.
    pub(super) fn pixels_left(&self) -> Result<u64, ExploreError> {
        let frames = self.warped(self.scene, false)?;
        let warped = frames.iter().filter(|frame| frame.reference.is_some());
        let classes = warped.flat_map(|frame| &frame.target.classes);
        Ok(classes.filter(|class| class.is_rendered()).count() as u64)
    }

    /// The path's warped frames with holes left empty.
    pub(super) fn with_holes(&self) -> Result<Vec<Frame>, ExploreError> {
        self.warped(&Holes(self.scene), false)
    }

    /// The path's frames, rendered in full.
    pub(super) fn full(&self) -> Result<Vec<potamoi_base::picture::Picture>, ExploreError> {
        let shaded = self
            .path
            .iter()
            .map(|camera| self.scene.shade(camera, None));
        let all: Result<Vec<_>, _> = shaded.collect();
        Ok(all?.into_iter().map(|shaded| shaded.picture).collect())
    }

    /// Times the frame on Verilated units of the whole configuration and of the parts called for.
    pub(super) fn rtl(&self, hardware: &Hardware) -> Result<RtlWall, ExploreError> {
        let mut shots = [None, None];
        let wall = self.in_pairs(|whole| {
            let mut units = match whole {
                true => {
                    let mut units = RtlUnits::new(self.config);
                    units.instantiate()?;
                    units
                }
                false => RtlUnits::new(&hardware.config),
            };
            let rendered = self.scene.render_fixed(self.config, &mut units)?;
            let cycles = units.cycles();
            shots[usize::from(!whole)] = Some((rendered.picture, rendered.counts, cycles));
            Ok(())
        })?;
        Ok(RtlWall {
            wall,
            cycles: shots[1].as_ref().map_or_else(RtlCycles::default, |s| s.2),
            is_same: shots[0] == shots[1],
        })
    }
}

/// Name of the frame in floating point.
const FLOAT: &str = "the frame in floating point";
const FIXED: &str = "the frame through the units' twins";
const PATH: &str = "the path's frames in floating point";
