//! Results of the system for a scene's path.

use std::ops::Add;

use potamoi_base::camera::Camera;
use potamoi_splats::PairTest;
use potamoi_system::system_model::work::{
    FrameWork, PathOptions, PathReplay, PathWork, PixelPairs,
};
use potamoi_system::system_model::{
    Alone, Area, AtBounds, Clock, Gathered, GpuOnly, Outcome, Scenario, Timeline, Unknown, Variant,
};
use schemars::JsonSchema;
use serde::Serialize;

use super::moved::Moved;
use crate::{ExploreError, Setup};

/// A scene's path in each variant of a system.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct Modelled {
    /// The scene's name.
    pub scene: String,
    /// The model's algorithm.
    pub algorithm: String,
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Options that the path was counted with.
    pub options: PathOptions,
    /// Name of the units' preset, if it is one.
    pub preset: Option<&'static str>,
    /// Whether the counted work was cached.
    pub was_kept: bool,
    /// Method that gives unit cycles: the middle one of [`rungs`](super::rungs).
    pub fidelity: &'static str,
    /// Clock of the accelerator in gigahertz.
    pub clock_ghz: f64,
    /// The clock that its slowest block reaches at 12 nm, in gigahertz, where known.
    pub reached_ghz: Option<f64>,
    /// The clock with its origin, and the blocks that bound it.
    pub clock: Clock,
    /// Areas of the accelerator's blocks at 12 nm.
    pub area: Area,
    /// Bytes of the feature buffer that are the reorder buffer of splats; 0 for fields.
    pub reorder_bytes: u64,
    /// Source of the energies.
    pub energy_origin: String,
    /// Blocks whose energy and area are not known.
    pub energy_unknown: Vec<Unknown>,
    /// Share of rendered pixels among the targets' non-void pixels, over the path.
    pub rendered_share: f64,
    /// (pixel, Gaussian) pairs of the path; `None` for fields.
    pub splats: Option<PathPairs>,
    /// Replay of the path's memory accesses, on which all times rest.
    pub memory: Option<PathReplay>,
    /// Gathering alone, for the first reference's frame.
    pub gathered: Gathered,
    /// The full frames on the GPU alone, with its own memory.
    pub gpu_only: GpuOnly,
    /// Results, the baseline first.
    pub outcomes: Vec<Outcome>,
    /// What moving parts of the GPU's work to other hardware would give; none where nothing is rendered
    /// locally.
    pub moved: Vec<Moved>,
    /// Why all (tile, Gaussian) pairs are listed although the configuration asks for fewer; `None` where
    /// it does not ask, or pairs are left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub keeps_all_pairs: Option<&'static str>,
    /// Items that files leave open, and frames with an empty view.
    pub not_checked: Vec<String>,
}

impl Modelled {
    /// Models a counted path seen by these cameras: each variant in each scenario, scenarios
    /// outermost. Also returns the timeline of the last.
    ///
    /// # Errors
    /// As [`Model::run`](potamoi_system::system_model::Model::run).
    pub fn of(
        (path, was_kept): (&PathWork, bool),
        setup: &Setup,
        variants: &[Variant],
        scenarios: &[Scenario],
        cameras: &[Camera],
    ) -> Result<(Self, Option<Timeline>), ExploreError> {
        let model = setup.model();
        let mut outcomes = vec![];
        let mut last = None;
        for scenario in scenarios {
            for variant in variants {
                let (outcome, timeline) = model.run(path, *variant, *scenario)?;
                outcomes.push(outcome);
                last = Some(timeline);
            }
        }
        let moved = match scenarios.contains(&Scenario::Local) {
            true => Moved::all(setup, path, variants)?,
            false => vec![],
        };
        let found = Self {
            scene: path.scene.clone(),
            algorithm: path.algorithm.clone(),
            size: path.size,
            options: path.options,
            preset: setup.preset,
            was_kept,
            fidelity: "cycle models",
            clock_ghz: model.clock_ghz,
            reached_ghz: model.costs.clock.reached_ghz,
            clock: model.costs.clock.clone(),
            area: setup.area().clone(),
            energy_origin: model.costs.origin.clone(),
            energy_unknown: model.costs.unknown.clone(),
            rendered_share: rendered_share(path),
            splats: PathPairs::of(path),
            memory: model.replay.copied(),
            gathered: model.gathered(path.full(0))?,
            gpu_only: GpuOnly::of(&setup.system.gpu.device, path),
            outcomes,
            moved,
            keeps_all_pairs: setup.scene.keeps_all_pairs(&setup.config),
            reorder_bytes: setup.scene.reorder_bytes(),
            not_checked: setup.scene.left_open_along(cameras),
        };
        Ok((found, last))
    }

    /// The baseline of a result's scenario.
    #[must_use]
    pub fn baseline(&self, of: &Outcome) -> &Outcome {
        let own = self.outcomes.iter().find(|o| o.scenario == of.scenario);
        own.unwrap_or(&self.outcomes[0])
    }

    /// Speed-up of a result over its baseline, at both bounds.
    #[must_use]
    pub fn speed_up(&self, of: &Outcome) -> AtBounds<f64> {
        self.baseline(of).run.span_ns().over(&of.run.span_ns())
    }

    /// Speed-up of a result over a program on the GPU alone, at both bounds.
    #[must_use]
    pub fn over_gpu(&self, of: &Outcome, alone: &Alone) -> AtBounds<f64> {
        let frames = of.run.max.frames as f64;
        let span = of.run.span_ns();
        alone.frame_ns.over(&span.map(|ns| ns / frames))
    }

    /// Energy saving of a result, at both bounds: the baseline's energy over its own; `None` where
    /// an energy is not known.
    #[must_use]
    pub fn saving(&self, of: &Outcome) -> Option<AtBounds<f64>> {
        let both = self.baseline(of).run.total_mj().zip(of.run.total_mj());
        both.map(|(baseline, own)| baseline.over(&own))
    }
}

/// (pixel, Gaussian) pairs of a path, summed over its frames.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
pub struct PathPairs {
    /// Of the full frames at the references' poses.
    pub full: PixelPairs,
    /// Of the pixels that are rendered in frames warped from references.
    pub rest: PixelPairs,
    /// (tile, Gaussian) pairs that the GPU tests and leaves out, of the full frames and of the rest;
    /// `None` where it tests none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tile_tests: Option<[PairTest; 2]>,
}

impl PathPairs {
    fn of(path: &PathWork) -> Option<Self> {
        let full = path.references.iter().filter_map(|frame| frame.pixel_pairs);
        let rest = path
            .targets
            .iter()
            .filter_map(|t| t.work.as_ref()?.pixel_pairs);
        let tests = [
            tested(path.references.iter()),
            tested(path.targets.iter().filter_map(|t| t.work.as_ref())),
        ];
        Some(Self {
            full: full.reduce(Add::add)?,
            rest: rest.reduce(Add::add).unwrap_or_default(),
            tile_tests: (tests[0].pairs > 0).then_some(tests),
        })
    }
}

/// Share of rendered pixels among the targets' non-void pixels.
fn rendered_share(path: &PathWork) -> f64 {
    let warped = path.targets.iter().filter(|t| t.reference.is_some());
    let [rendered, shown] = warped.fold([0, 0], |[rendered, shown], target| {
        let own = &target.classes;
        [rendered + own.rendered, shown + own.rendered + own.warped]
    });
    rendered as f64 / f64::max(shown as f64, 1.0)
}

/// Sum of the pairs that are tested, and left out.
fn tested<'w>(works: impl Iterator<Item = &'w FrameWork>) -> PairTest {
    works.fold(PairTest::default(), |sum, work| PairTest {
        pairs: sum.pairs + work.pairs_tested,
        left_out: sum.left_out + work.pairs_tested.saturating_sub(work.pairs),
    })
}
