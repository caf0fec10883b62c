//! The power of the units, by the work of a scene.

use clap::Args;
use potamoi_explore::synthesis::{Activity, ActivityScene};
use potamoi_synth::{Power, PowerReport};

use super::Units;
use crate::failure::Failure;
use crate::stdout::say;
use crate::tables;

/// Instead of a scene: no power.
const NONE: &str = "none";

#[derive(Debug, Args)]
pub(super) struct PowerArgs {
    /// Scene whose work stimulates the netlists for the power estimate; `none` skips the estimate
    /// [default: lantern for the gathering unit, garden for the vector unit]
    #[arg(long, value_name = "SCENE")]
    activity: Option<String>,
    /// Simulate whole netlists instead of slices, which is slower
    #[arg(long)]
    whole: bool,
}

impl PowerArgs {
    /// Whether power was not left out.
    pub(super) fn is_wanted(&self) -> bool {
        self.activity.as_deref() != Some(NONE)
    }

    /// What power is estimated from.
    ///
    /// # Errors
    /// A scene for units of which no work is recorded.
    pub(super) fn activity(&self, units: Units) -> Result<Activity, Failure> {
        let has_work = !matches!(units, Units::Su);
        if let Some(name) = self
            .activity
            .as_deref()
            .filter(|own| !has_work && *own != NONE)
        {
            return Err(Failure::Usage(format!(
                "--activity {name}: no work of the splat unit is recorded; leave it out with --unit su"
            )));
        }
        Ok(Activity {
            scene: match self.activity.as_deref() {
                None if !has_work => ActivityScene::None,
                None => ActivityScene::Default,
                Some(NONE) => ActivityScene::None,
                Some(name) => ActivityScene::Named(name.to_owned()),
            },
            whole: self.whole,
        })
    }
}

pub(super) fn print(power: &Power) {
    let report = match power {
        Power::Estimated(report) => report,
        Power::Absent { absent } => {
            say!("power: none, for {absent}");
            return;
        }
    };
    let activity = &report.activity;
    say!(
        "power of cells, without wires, clock tree and memories, at {:.3} GHz, {} V, {:.4} mW of which leakage;\n{}: {}; {} simulated, {} cycles of which {} busy, equal to the golden values in \
         every output bit and cycle",
        report.clock_ghz,
        report.volts,
        report.leakage_nw * 1e-6,
        activity.scene,
        activity.work,
        activity.simulated.join(" and "),
        activity.cycles,
        activity.busy
    );
    figures(report);
    modules(report);
}

fn figures(report: &PowerReport) {
    let mut table = tables::plain([
        "pJ per cycle",
        "switching",
        "internal",
        "clock",
        "sum",
        "idle",
        "toggles per net",
        &format!("pJ per {}", report.activity.item),
        "mW",
    ]);
    for (name, f) in [
        ("without delays", &report.zero_delay),
        ("with glitches", &report.with_glitches),
    ] {
        let mut row = vec![name.to_owned()];
        row.extend(
            [
                f.switching_pj_a_cycle,
                f.internal_pj_a_cycle,
                f.clock_pj_a_cycle,
                f.pj_a_cycle,
                f.rest_pj_a_cycle,
            ]
            .map(|v| format!("{v:.3}")),
        );
        row.push(format!("{:.4}", f.toggles_a_net));
        row.push(format!("{:.3}", f.pj_an_item));
        row.push(format!("{:.3}", f.mw));
        table.add_row(row);
    }
    say!("{}", tables::fitted(&table, &[]));
}

fn modules(report: &PowerReport) {
    let mut table = tables::plain([
        "module",
        "count",
        "pJ per cycle, without delays",
        "with glitches",
        "share",
        "leakage, uW",
    ]);
    for module in &report.modules {
        let share = module.with_glitches_pj_a_cycle / report.with_glitches.pj_a_cycle;
        table.add_row([
            module.module.clone(),
            module.count.to_string(),
            format!("{:.3}", module.zero_delay_pj_a_cycle),
            format!("{:.3}", module.with_glitches_pj_a_cycle),
            format!("{:.1} %", 100.0 * share),
            format!("{:.3}", module.leakage_nw * 1e-3),
        ]);
    }
    say!("{}", tables::fitted(&table, &[]));
}
