//! What comes out if what is calibrated or assumed were otherwise, and without a GPU.

use potamoi_system::soc::{Gpu, Model, Scenario, System, Variant};
use serde::Serialize;

use super::ModelArgs;
use super::report::{self, Report};
use crate::args::Common;
use crate::failure::Failure;
use crate::stdout::say;
use crate::tables;

/// One thing, changed.
struct Change {
    name: &'static str,
    make: fn(&mut System),
    /// It is of what the remote GPU alone does.
    is_remote: bool,
}

impl Change {
    const fn new(name: &'static str, make: fn(&mut System)) -> Self {
        Self {
            name,
            make,
            is_remote: false,
        }
    }

    const fn remote(name: &'static str, make: fn(&mut System)) -> Self {
        Self {
            name,
            make,
            is_remote: true,
        }
    }
}

/// What programs reach of a machine's best is calibrated once, and taken to hold for both.
const CHANGES: [Change; 21] = [
    Change::new("as it is", |_| {}),
    Change::new("fields' share of the best halved", |system| {
        both(system, |gpu| gpu.fields_efficiency /= 2.0);
    }),
    Change::new("fields' share doubled", |system| {
        both(system, |gpu| gpu.fields_efficiency *= 2.0);
    }),
    Change::new("splats' share of the best halved", |system| {
        both(system, |gpu| gpu.splats_efficiency /= 2.0);
    }),
    Change::new("splats' share doubled", |system| {
        both(system, |gpu| gpu.splats_efficiency *= 2.0);
    }),
    Change::new("warping's share of the best halved", |system| {
        both(system, |gpu| gpu.pictures_efficiency /= 2.0);
    }),
    Change::new("warping's share doubled", |system| {
        both(system, |gpu| gpu.pictures_efficiency *= 2.0);
    }),
    Change::new("all shares 1, as though none were calibrated", |system| {
        both(system, |gpu| *gpu = gpu.reaching(1.0));
    }),
    Change::remote(
        "the remote GPU's shares doubled, not the device's",
        |system| {
            let gpu = &mut system.remote;
            gpu.fields_efficiency *= 2.0;
            gpu.splats_efficiency *= 2.0;
            gpu.pictures_efficiency *= 2.0;
        },
    ),
    Change::remote("the remote GPU's shares 1, not the device's", |system| {
        system.remote = system.remote.reaching(1.0);
    }),
    Change::new("the device gathers 10 times slower", |system| {
        system.gpu.gathering_factor *= 10.0;
    }),
    Change::new("the device gathers 100 times slower", |system| {
        system.gpu.gathering_factor *= 100.0;
    }),
    Change::new("finding a sample takes twice the instructions", |system| {
        system.instructions.sample *= 2.0;
    }),
    Change::new("reading and interpolating vectors, twice", |system| {
        system.instructions.vector *= 2.0;
        system.instructions.code *= 2.0;
    }),
    Change::new("projecting and sorting Gaussians, twice", |system| {
        let own = &mut system.instructions;
        own.projected *= 2.0;
        own.harmonics *= 2.0;
        own.sorted *= 2.0;
    }),
    Change::new("launching a kernel takes no time", |system| {
        both(system, |gpu| gpu.launch_us = 0.0);
    }),
    Change::new("one group of rays in flight instead of two", |system| {
        system.groups_in_flight = 1;
    }),
    Change::new("16 banks of the feature buffer instead of 48", |system| {
        (system.feature_banks, system.feature_block_banks) = (16, 16);
    }),
    Change::new("a block in one bank of it", |system| {
        system.feature_block_banks = 1;
    }),
    Change::new("twice the watts", |system| {
        system.gpu.watts *= 2.0;
        system.gpu.idle_watts *= 2.0;
    }),
    Change::new("the device's work takes no time and no energy", |system| {
        without_work(&mut system.gpu);
    }),
];

fn both(system: &mut System, change: fn(&mut Gpu)) {
    change(&mut system.gpu);
    change(&mut system.remote);
}

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
    remote: Gpu,
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
        (change.make)(&mut system);
        let mut means = vec![];
        let scenarios = args.scenario.all().iter();
        for &scenario in scenarios.filter(|s| !change.is_remote || **s == Scenario::Remote) {
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
        if !means.is_empty() {
            rows.push(Row {
                change: change.name,
                gpu: system.gpu,
                remote: system.remote,
                means,
            });
        }
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
            Scenario::Local => "rendered here",
            Scenario::Remote => "references from afar",
        };
        let heading = std::iter::once(heading.to_owned());
        let mut table = tables::plain(
            heading
                .chain(names.map(|m| m.variant.to_owned()))
                .collect::<Vec<_>>(),
        );
        for row in &found.rows {
            let figures = of(row);
            if !figures.is_empty() {
                table.add_row([vec![row.change.to_owned()], figures].concat());
            }
        }
        say!("{table}");
    }
}
