//! What was found, as JSON has it.

use potamoi_system::soc::work::{PathOptions, PathReplay, PathWork};
use potamoi_system::soc::{Gathered, Outcome, System};
use serde::Serialize;

use super::ModelArgs;
use crate::failure::Failure;
use crate::files;
use crate::model_context::Setup;

/// Version of the JSON reports.
const FORMAT_VERSION: u32 = 1;

/// What was found of scenes on a system.
#[derive(Serialize)]
pub(super) struct Report<T> {
    format_version: u32,
    command: &'static str,
    system: System,
    pub(super) scenes: Vec<T>,
}

impl<T> Report<T> {
    pub(super) fn new(command: &'static str, system: &System, scenes: Vec<T>) -> Self {
        Self {
            format_version: FORMAT_VERSION,
            command,
            system: system.clone(),
            scenes,
        }
    }
}

/// Writes a report where that was asked for.
pub(super) fn write(report: &impl Serialize, args: &ModelArgs) -> Result<(), Failure> {
    match &args.json {
        Some(path) => Ok(files::write_json(path, report)?),
        None => Ok(()),
    }
}

/// Of one scene.
#[derive(Serialize)]
pub(super) struct Found {
    pub(super) scene: String,
    pub(super) algorithm: String,
    pub(super) size: [u32; 2],
    pub(super) options: PathOptions,
    /// The preset whose units it is.
    pub(super) preset: Option<&'static str>,
    /// Whether the work had been counted earlier.
    pub(super) was_kept: bool,
    /// How cycles of units were found: the middle rung of `--ladder`.
    pub(super) fidelity: &'static str,
    pub(super) clock_ghz: f64,
    /// What its units reach at 12 nm before wires, where they were synthesised.
    pub(super) reached_ghz: Option<f64>,
    /// Where energy is from.
    pub(super) energy_origin: String,
    /// Pixels of targets that are rendered, of those that are not void, over the path.
    pub(super) rendered_share: f64,
    /// What memory takes for the path's accesses in their order, which all of this rests on.
    pub(super) memory: Option<PathReplay>,
    /// Gathering alone, of the first reference's frame.
    pub(super) gathered: Gathered,
    /// The baseline first.
    pub(super) outcomes: Vec<Outcome>,
    /// What files leave open, and frames in which nothing is in view.
    pub(super) not_checked: Vec<String>,
}

impl Found {
    pub(super) fn new(
        path: &PathWork,
        setup: &Setup,
        was_kept: bool,
        outcomes: Vec<Outcome>,
    ) -> Result<Self, Failure> {
        let model = setup.model();
        let warped = path.targets.iter().filter(|t| t.reference.is_some());
        let [rendered, shown] = warped.fold([0, 0], |[rendered, shown], target| {
            let own = &target.classes;
            [rendered + own.rendered, shown + own.rendered + own.warped]
        });
        Ok(Self {
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
            rendered_share: rendered as f64 / f64::max(shown as f64, 1.0),
            memory: model.replay.copied(),
            gathered: model.gathered(path.full(0))?,
            outcomes,
            not_checked: vec![],
        })
    }

    /// The outcome that one is compared with: the baseline of its scenario.
    pub(super) fn baseline(&self, of: &Outcome) -> &Outcome {
        let own = self.outcomes.iter().find(|o| o.scenario == of.scenario);
        own.unwrap_or(&self.outcomes[0])
    }

    pub(super) fn speed_up(&self, of: &Outcome) -> f64 {
        self.baseline(of).run.span_ns / of.run.span_ns
    }

    pub(super) fn saving(&self, of: &Outcome) -> f64 {
        self.baseline(of).run.energy.total_mj() / of.run.energy.total_mj()
    }
}
