//! The power of the units, by the work of a scene.

use std::collections::BTreeMap;

use clap::Args;
use potamoi_formats::config::Config;
use potamoi_reference::Twins;
use potamoi_reference::observer::Observed;
use potamoi_scene::Scene;
use potamoi_synth::{
    Extent, Made, Order, POWER_STEPS, Power, PowerReport, STEPS, Sampler, SynthError, UnitKind,
    estimate,
};

use super::Flow;
use crate::failure::Failure;
use crate::progress;
use crate::stdout::say;
use crate::tables;

/// The work of the gathering unit and of the vector unit unless a scene is named: voxels
/// of eight vertices, and the exponentials of splats.
const SCENES: [&str; 2] = ["lantern", "garden"];
/// Instead of a scene: no power.
const NONE: &str = "none";

#[derive(Debug, Args)]
pub(super) struct PowerArgs {
    /// Scene whose work drives the netlists, for their power; `none` leaves power out [default:
    /// lantern for the gathering unit, garden for the vector unit]
    #[arg(long, value_name = "SCENE")]
    activity: Option<String>,
    /// Simulate the whole netlists rather than slices of them, which is slower
    #[arg(long)]
    whole: bool,
}

/// Scenes whose work is asked for, each once.
pub(super) struct Scenes(Vec<(String, Scene)>);

impl Scenes {
    /// Opens those of the units.
    pub(super) fn open(args: &PowerArgs, units: &[UnitKind]) -> Result<Self, Failure> {
        let mut scenes: Vec<(String, Scene)> = vec![];
        for name in units.iter().filter_map(|unit| args.scene(*unit)) {
            if scenes.iter().all(|(known, _)| known != name) {
                scenes.push((name.to_owned(), Scene::open(name)?));
            }
        }
        Ok(Self(scenes))
    }

    /// Renders them, with all operations that the scenes ask for: a unit that lacks some is
    /// given its part of the work.
    pub(super) fn work(self, config: &Config) -> Result<Work, Failure> {
        let mut config = config.clone();
        for op in Config::default().vu.ops {
            if !config.vu.ops.contains(&op) {
                config.vu.ops.push(op);
            }
        }
        let config = &config;
        let spinner = progress::spinner("rendering the work");
        let mut work = BTreeMap::new();
        for (name, scene) in self.0 {
            let mut sampler = Sampler::new(config);
            let mut twins = Twins::new(config);
            let mut units = Observed::new(&mut twins, config).by(&mut sampler);
            scene.render_fixed(config, &mut units)?;
            work.insert(name, sampler);
        }
        spinner.finish_and_clear();
        Ok(Work(work))
    }
}

/// Work by scene.
pub(super) struct Work(BTreeMap<String, Sampler>);

impl PowerArgs {
    /// Whether power was not left out.
    pub(super) fn is_wanted(&self) -> bool {
        self.activity.as_deref() != Some(NONE)
    }

    /// Whether it is of the scenes that are taken unless any are named.
    pub(super) fn is_default(&self) -> bool {
        self.activity.is_none()
    }

    /// Steps of a unit: its synthesis, and its power.
    pub(super) fn steps(&self) -> u64 {
        match (self.is_wanted(), self.whole) {
            (false, _) => STEPS,
            (true, false) => STEPS + POWER_STEPS,
            // Both runs of the whole netlist.
            (true, true) => STEPS + 2,
        }
    }

    fn scene(&self, unit: UnitKind) -> Option<&str> {
        let default = match unit {
            UnitKind::Gathering => SCENES[0],
            UnitKind::Vector => SCENES[1],
        };
        let scene = self.activity.as_deref().unwrap_or(default);
        (scene != NONE).then_some(scene)
    }

    /// Adds its power to a unit that was made.
    pub(super) fn add(
        &self,
        (config, unit): (&Config, UnitKind),
        made: &mut Made,
        work: &Work,
        flow: &Flow<'_>,
        step: &dyn Fn(),
    ) -> Result<(), Failure> {
        let Some(scene) = self.scene(unit) else {
            return Ok(());
        };
        let sampler = work.0.get(scene);
        let windows = (
            sampler.and_then(Sampler::gather_window),
            sampler.and_then(Sampler::vector_window),
        );
        let order = Order {
            config,
            unit,
            library: flow.library,
            tools: flow.tools,
            made: (&made.report, &made.netlist),
            scene,
            windows: (windows.0.as_ref(), windows.1.as_ref()),
            extent: match self.whole {
                true => Extent::Whole,
                false => Extent::Slices,
            },
            step,
        };
        let power = estimate(&order, flow.cache).map_err(wrong)?;
        made.report.power = Some(power);
        Ok(())
    }
}

/// A netlist that computes something else is a check that failed.
fn wrong(error: SynthError) -> Failure {
    match error {
        SynthError::Rtl(error) => Failure::Rtl(*error),
        other => Failure::Synth(other),
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
        "power of cells, without wires, clock tree and memories, at {:.3} GHz, {} V, {:.4} mW of it \
         leakage;\n{}: {}; {} simulated, {} cycles of which {} busy, equal to the golden values in \
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
        "pJ a cycle",
        "switching",
        "internal",
        "clock",
        "sum",
        "at rest",
        "changes a net",
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
    say!("{table}");
}

fn modules(report: &PowerReport) {
    let mut table = tables::plain([
        "module",
        "count",
        "pJ a cycle, without delays",
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
    say!("{table}");
}
