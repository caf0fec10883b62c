//! Sensitivity of the results to calibrated and assumed parameters, and results without a GPU.

use potamoi_system::system_model::work::PathWork;
use potamoi_system::system_model::{Gpu, Model, Scenario, System, Variant};
use serde::Serialize;

use crate::{ExploreError, Setup};

/// A change of one parameter.
struct Change {
    name: &'static str,
    make: fn(&mut System),
    /// Whether it concerns only the remote GPU.
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

/// Efficiencies are calibrated once, and assumed to hold for both GPUs.
const CHANGES: [Change; 21] = [
    Change::new("unchanged", |_| {}),
    Change::new("fields' share of the peak halved", |system| {
        both(system, |gpu| gpu.fields_efficiency /= 2.0);
    }),
    Change::new("fields' share doubled", |system| {
        both(system, |gpu| gpu.fields_efficiency *= 2.0);
    }),
    Change::new("splats' share of the peak halved", |system| {
        both(system, |gpu| gpu.splats_efficiency /= 2.0);
    }),
    Change::new("splats' share doubled", |system| {
        both(system, |gpu| gpu.splats_efficiency *= 2.0);
    }),
    Change::new("warping's share of the peak halved", |system| {
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
    Change::new("a block of the feature buffer in one bank", |system| {
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

/// Removes the GPU's work. Memory, units, array and link remain, and its bytes still move.
fn without_work(gpu: &mut Gpu) {
    // Far beyond any machine, and small enough that quotients stay numbers.
    (gpu.cores, gpu.cache_gb_s) = (1e15, 1e15);
    (gpu.launch_us, gpu.watts, gpu.idle_watts) = (0.0, 0.0, 0.0);
}

/// Speed-up and energy saving over the baseline of the same system, as means over scenes.
#[derive(Debug, Clone, Serialize)]
pub struct Mean {
    /// The variant's name.
    pub variant: &'static str,
    /// Where full frames are rendered.
    pub scenario: Scenario,
    /// Speed-up: the baseline's time over the variant's.
    pub speed_up: f64,
    /// Energy saving: the baseline's energy over the variant's.
    pub saving: f64,
}

/// Results under one change.
#[derive(Debug, Clone, Serialize)]
pub struct SensitivityRow {
    /// Description of the change; the first row has none.
    pub change: &'static str,
    /// The device's GPU as changed.
    pub gpu: Gpu,
    /// The remote GPU as changed.
    pub remote: Gpu,
    /// Means by scenario and variant; the baseline is first in each scenario.
    pub means: Vec<Mean>,
}

/// Speed-ups and energy savings under each change.
#[derive(Debug, Clone, Serialize)]
pub struct Sensitivity {
    /// Names of the scenes averaged over.
    pub scenes: Vec<String>,
    /// One row a change; changes that affect no scenario are left out.
    pub rows: Vec<SensitivityRow>,
}

/// A scene with a counted path.
pub struct CountedScene {
    /// Name of the scene, as requested.
    pub name: String,
    /// Its setup.
    pub setup: Setup,
    /// Work of its path.
    pub path: PathWork,
}

impl Sensitivity {
    /// Evaluates scenes with counted paths on a system and on each change of it. The baseline is
    /// the first variant.
    ///
    /// # Errors
    /// As [`Model::run`].
    pub fn of(
        counted: &[CountedScene],
        system: &System,
        variants: &[Variant],
        scenarios: &[Scenario],
    ) -> Result<Self, ExploreError> {
        let mut rows = vec![];
        for change in &CHANGES {
            let mut system = system.clone();
            (change.make)(&mut system);
            let scenarios = scenarios
                .iter()
                .filter(|s| !change.is_remote || **s == Scenario::Remote);
            let pairs = scenarios.flat_map(|s| variants.iter().map(move |v| (*v, *s)));
            let means = means(counted, &system, &pairs.collect::<Vec<_>>())?;
            if !means.is_empty() {
                rows.push(SensitivityRow {
                    change: change.name,
                    gpu: system.gpu,
                    remote: system.remote,
                    means,
                });
            }
        }
        Ok(Self {
            scenes: counted.iter().map(|own| own.name.clone()).collect(),
            rows,
        })
    }
}

/// Means over scenes by scenario and variant; the baseline is first in each scenario.
fn means(
    counted: &[CountedScene],
    system: &System,
    pairs: &[(Variant, Scenario)],
) -> Result<Vec<Mean>, ExploreError> {
    let mut means: Vec<Mean> = (pairs.iter())
        .map(|(variant, scenario)| Mean {
            variant: variant.name,
            scenario: *scenario,
            speed_up: 0.0,
            saving: 0.0,
        })
        .collect();
    for CountedScene { setup, path, .. } in counted {
        let model = Model {
            system,
            ..setup.model()
        };
        let mut baseline: Option<(Scenario, [f64; 2])> = None;
        for (mean, (variant, scenario)) in means.iter_mut().zip(pairs) {
            let run = model.run(path, *variant, *scenario)?.0.run;
            let own = [run.span_ns, run.energy.total_mj()];
            let [span, energy] = match baseline {
                Some((known, of)) if known == *scenario => of,
                _ => baseline.insert((*scenario, own)).1,
            };
            mean.speed_up += span / own[0] / counted.len() as f64;
            mean.saving += energy / own[1] / counted.len() as f64;
        }
    }
    Ok(means)
}
