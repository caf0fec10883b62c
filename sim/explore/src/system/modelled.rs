//! What the system takes for the frames of a scene's path.

use potamoi_base::camera::Camera;
use potamoi_system::soc::work::{PathOptions, PathReplay, PathWork};
use potamoi_system::soc::{Gathered, Outcome, Scenario, Timeline, Variant};
use serde::Serialize;

use crate::{ExploreError, Setup};

/// A scene's path on a system, in each variant of it.
#[derive(Debug, Clone, Serialize)]
pub struct Modelled {
    /// The scene's name.
    pub scene: String,
    /// The model's algorithm.
    pub algorithm: String,
    /// Pixels of a row, and rows.
    pub size: [u32; 2],
    /// The path, and what was counted of it.
    pub options: PathOptions,
    /// The preset whose units it is.
    pub preset: Option<&'static str>,
    /// Whether the work had been counted earlier.
    pub was_kept: bool,
    /// How cycles of units were found: the middle one of [`rungs`](super::rungs).
    pub fidelity: &'static str,
    /// The units' clock, assumed.
    pub clock_ghz: f64,
    /// What its units reach at 12 nm before wires, where they were synthesised.
    pub reached_ghz: Option<f64>,
    /// Where energy is from.
    pub energy_origin: String,
    /// Pixels of targets that are rendered, of those that are not void, over the path.
    pub rendered_share: f64,
    /// What memory takes for the path's accesses in their order, which all of this rests on.
    pub memory: Option<PathReplay>,
    /// Gathering alone, of the first reference's frame.
    pub gathered: Gathered,
    /// The baseline first.
    pub outcomes: Vec<Outcome>,
    /// What files leave open, and frames in which nothing is in view.
    pub not_checked: Vec<String>,
}

impl Modelled {
    /// Of a path that is counted, now or earlier, seen by these cameras: each variant in each
    /// scenario, scenarios outermost, and the timeline of the last.
    ///
    /// # Errors
    /// As [`Model::run`](potamoi_system::soc::Model::run).
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
        let found = Self {
            scene: path.scene.clone(),
            algorithm: path.algorithm.clone(),
            size: path.size,
            options: path.options,
            preset: setup.preset,
            was_kept,
            fidelity: "cycle models",
            clock_ghz: model.clock_ghz,
            reached_ghz: model.costs.reached_ghz,
            energy_origin: model.costs.origin.clone(),
            rendered_share: rendered_share(path),
            memory: model.replay.copied(),
            gathered: model.gathered(path.full(0))?,
            outcomes,
            not_checked: setup.scene.left_open_along(cameras),
        };
        Ok((found, last))
    }

    /// The outcome that one is compared with: the baseline of its scenario.
    #[must_use]
    pub fn baseline(&self, of: &Outcome) -> &Outcome {
        let own = self.outcomes.iter().find(|o| o.scenario == of.scenario);
        own.unwrap_or(&self.outcomes[0])
    }

    /// The baseline's time over the outcome's.
    #[must_use]
    pub fn speed_up(&self, of: &Outcome) -> f64 {
        self.baseline(of).run.span_ns / of.run.span_ns
    }

    /// The baseline's energy over the outcome's.
    #[must_use]
    pub fn saving(&self, of: &Outcome) -> f64 {
        self.baseline(of).run.energy.total_mj() / of.run.energy.total_mj()
    }
}

/// Pixels of targets that are rendered, of those that are not void.
fn rendered_share(path: &PathWork) -> f64 {
    let warped = path.targets.iter().filter(|t| t.reference.is_some());
    let [rendered, shown] = warped.fold([0, 0], |[rendered, shown], target| {
        let own = &target.classes;
        [rendered + own.rendered, shown + own.rendered + own.warped]
    });
    rendered as f64 / f64::max(shown as f64, 1.0)
}
