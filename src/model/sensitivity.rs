//! What comes out if what is calibrated or assumed of the GPU were otherwise, and without a GPU.

use potamoi_sim::soc::{Gpu, Model, Scenario, System, Variant};
use serde::Serialize;

use super::ModelArgs;
use super::report::{self, Report};
use crate::common::Common;
use crate::failure::Failure;
use crate::say::say;
use crate::tables;

/// One thing about the GPU, changed.
struct Change {
    name: &'static str,
    make: fn(&mut Gpu),
}

const CHANGES: [Change; 12] = [
    Change {
        name: "as it is",
        make: |_| {},
    },
    Change {
        name: "fields' share of the best halved",
        make: |gpu| gpu.fields_efficiency /= 2.0,
    },
    Change {
        name: "fields' share doubled",
        make: |gpu| gpu.fields_efficiency *= 2.0,
    },
    Change {
        name: "splats' share of the best halved",
        make: |gpu| gpu.splats_efficiency /= 2.0,
    },
    Change {
        name: "splats' share doubled",
        make: |gpu| gpu.splats_efficiency *= 2.0,
    },
    Change {
        name: "warping's share of the best halved",
        make: |gpu| gpu.pictures_efficiency /= 2.0,
    },
    Change {
        name: "warping's share doubled",
        make: |gpu| gpu.pictures_efficiency *= 2.0,
    },
    Change {
        name: "all shares 1, as though none were calibrated",
        make: |gpu| {
            gpu.fields_efficiency = 1.0;
            gpu.splats_efficiency = 1.0;
            gpu.pictures_efficiency = 1.0;
        },
    },
    Change {
        name: "gathers 10 times slower",
        make: |gpu| gpu.gathering_factor *= 10.0,
    },
    Change {
        name: "gathers 100 times slower",
        make: |gpu| gpu.gathering_factor *= 100.0,
    },
    Change {
        name: "twice the watts",
        make: |gpu| {
            gpu.watts *= 2.0;
            gpu.idle_watts *= 2.0;
        },
    },
    Change {
        name: "its work takes no time and no energy",
        make: without_work,
    },
];

/// What is left are memory, the units, the array and the link. Its bytes still move.
fn without_work(gpu: &mut Gpu) {
    // Far beyond any machine, and small enough that quotients stay numbers.
    (gpu.cores, gpu.cache_gb_s) = (1e15, 1e15);
    (gpu.launch_us, gpu.watts, gpu.idle_watts) = (0.0, 0.0, 0.0);
}

/// Speed-up and energy saving over the baseline of the same system, means over scenes.
#[derive(Serialize)]
struct Mean {
    variant: &'static str,
    scenario: Scenario,
    speed_up: f64,
    saving: f64,
}

#[derive(Serialize)]
struct Row {
    change: &'static str,
    gpu: Gpu,
    means: Vec<Mean>,
}

#[derive(Serialize)]
struct Sensitivity {
    scenes: Vec<String>,
    rows: Vec<Row>,
}

pub(super) fn run(
    common: &Common,
    args: &ModelArgs,
    system: &System,
    names: &[String],
) -> Result<(), Failure> {
    let mut counted = vec![];
    for name in names {
        let mut setup = args.setup(common, system, args.scene.open_named(name)?)?;
        let path = args.count(&mut setup)?.0;
        counted.push((setup, path));
    }
    let variants = args.variants()?;
    let mut rows = vec![];
    for change in &CHANGES {
        let mut system = system.clone();
        (change.make)(&mut system.gpu);
        let mut means = vec![];
        for &scenario in args.scenario.all() {
            means.extend(variants.iter().map(|v| Mean {
                variant: v.name,
                scenario,
                speed_up: 0.0,
                saving: 0.0,
            }));
        }
        for (setup, path) in &counted {
            let model = Model {
                system: &system,
                ..setup.model()
            };
            let mut baseline: Option<(Scenario, [f64; 2])> = None;
            for mean in &mut means {
                let variant = Variant::named(mean.variant).unwrap_or(Variant::ALL[0]);
                let run = model.run(path, variant, mean.scenario)?.0.run;
                let own = [run.span_ns, run.energy.total_mj()];
                // The baseline comes first of each scenario.
                let [span, energy] = match baseline {
                    Some((scenario, of)) if scenario == mean.scenario => of,
                    _ => baseline.insert((mean.scenario, own)).1,
                };
                mean.speed_up += span / own[0] / counted.len() as f64;
                mean.saving += energy / own[1] / counted.len() as f64;
            }
        }
        rows.push(Row {
            change: change.name,
            gpu: system.gpu,
            means,
        });
    }
    let found = Sensitivity {
        scenes: names.to_vec(),
        rows,
    };
    print(&found, args);
    report::write(
        &Report::new("model --sensitivity", system, vec![found]),
        args,
    )
}

fn print(found: &Sensitivity, args: &ModelArgs) {
    say!(
        "speed-up (energy saving) over the baseline of the same system, means of {}",
        found.scenes.join(", ")
    );
    for scenario in args.scenario.all() {
        let of = |row: &Row| -> Vec<String> {
            let own = row.means.iter();
            own.filter(|m| m.scenario == *scenario && m.variant != "baseline")
                .map(|m| format!("{:.2} ({:.2})", m.speed_up, m.saving))
                .collect()
        };
        let names = found.rows.iter().take(1).flat_map(|row| &row.means);
        let names = names.filter(|m| m.scenario == *scenario && m.variant != "baseline");
        let heading = match scenario {
            Scenario::Local => "rendered here: the GPU",
            Scenario::Remote => "references from afar: the device's GPU",
        };
        let heading = std::iter::once(heading.to_owned());
        let mut table = tables::plain(
            heading
                .chain(names.map(|m| m.variant.to_owned()))
                .collect::<Vec<_>>(),
        );
        for row in &found.rows {
            table.add_row([vec![row.change.to_owned()], of(row)].concat());
        }
        say!("{table}");
    }
}
