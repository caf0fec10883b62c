//! Sensitivity of the results to figures of the devices, and results without a GPU.

use potamoi_gpu::Device;
use potamoi_system::system_model::work::PathWork;
use potamoi_system::system_model::{
    AtBounds, Clock, Gpu, Model, Outcome, Scenario, System, Variant,
};
use schemars::JsonSchema;
use serde::Serialize;

use super::conclusions::{Conclusion, ModelErrorNote, conclusions};
use super::counted_scene::CountedScene;
use crate::{ExploreError, Setup};

/// A change of one parameter.
struct Change {
    name: &'static str,
    make: fn(&mut System),
    /// Whether it concerns only remote rendering.
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

/// Figures of the devices, each by itself; those of both GPUs alike unless said otherwise.
const CHANGES: [Change; 17] = [
    Change::new("unchanged", |_| {}),
    Change::new("twice the clock of the GPUs", |system| {
        both(system, |gpu| gpu.device.clock_ghz *= 2.0);
    }),
    Change::new("half the clock of the GPUs", |system| {
        both(system, |gpu| gpu.device.clock_ghz /= 2.0);
    }),
    Change::new("twice the multiprocessors", |system| {
        both(system, |gpu| gpu.device.multiprocessors *= 2.0);
    }),
    Change::new("twice the bytes a clock of L2", |system| {
        both(system, |gpu| gpu.device.l2_bytes_clock *= 2.0);
    }),
    Change::new("twice the tensor cores", |system| {
        both(system, |gpu| gpu.device.tensor_tflops *= 2.0);
    }),
    Change::new("half the latencies", |system| {
        both(system, |gpu| {
            gpu.device.l2_latency_clocks /= 2.0;
            gpu.device.dram_latency_ns /= 2.0;
        });
    }),
    Change::new("launching a kernel takes no time", |system| {
        both(system, |gpu| {
            let device = &mut gpu.device;
            (device.launch_us, device.ramp_us, device.wait_us) = (0.0, 0.0, 0.0);
        });
    }),
    Change::remote("twice the remote GPU, not the device's", |system| {
        system.remote.device.multiprocessors *= 2.0;
        system.remote.device.dram_gb_s *= 2.0;
    }),
    Change::new("a GPU with a memory of its own", |system| {
        system.gpu.shares_memory = false;
    }),
    Change::remote("twice the rate of the link", |system| {
        system.link_bytes_per_second *= 2.0;
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
        system.gpu.device.watts *= 2.0;
        system.gpu.idle_watts *= 2.0;
    }),
    Change::new("the device's GPU idles at no watt", |system| {
        system.gpu.idle_watts = 0.0;
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
    gpu.device = Device::infinite();
    (gpu.device.watts, gpu.idle_watts) = (0.0, 0.0);
}

/// The variants of a counted path on the setup's system with a GPU that takes no time and no energy;
/// its bytes still move.
///
/// # Errors
/// As [`Model::run`].
pub fn with_free_gpu(
    setup: &Setup,
    path: &PathWork,
    variants: &[Variant],
    scenario: Scenario,
) -> Result<Vec<Outcome>, ExploreError> {
    let mut system = setup.system.clone();
    without_work(&mut system.gpu);
    let model = Model {
        system: &system,
        ..setup.model()
    };
    let run = |variant: &Variant| Ok(model.run(path, *variant, scenario)?.0);
    variants.iter().map(run).collect()
}

/// Speed-up and energy saving over the baseline of the same system, as means over scenes.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct Mean {
    /// The variant's name.
    pub variant: &'static str,
    /// Where full frames are rendered.
    pub scenario: Scenario,
    /// Speed-up at both bounds: the baseline's time over the variant's.
    pub speed_up: AtBounds<f64>,
    /// Energy saving at both bounds: the baseline's energy over the variant's; `None` where an
    /// energy is not known.
    pub saving: Option<AtBounds<f64>>,
}

/// Results under one change.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct SensitivityRow {
    /// Description of the change; the first row has none.
    pub change: &'static str,
    /// Means by scenario and variant; the baseline is first in each scenario.
    pub means: Vec<Mean>,
}

/// Speed-ups and energy savings under each change.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct Sensitivity {
    /// Names of the scenes averaged over.
    pub scenes: Vec<String>,
    /// The clock of each.
    pub clocks: Vec<Clock>,
    /// One row a change; changes that affect no scenario are left out.
    pub rows: Vec<SensitivityRow>,
    /// Conclusions about each scene, and whether the model's error leaves them standing.
    pub conclusions: Vec<Conclusion>,
    /// The errors under which they were tried.
    pub errors: Vec<ModelErrorNote>,
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
                    means,
                });
            }
        }
        let (conclusions, errors) = conclusions(counted, system, variants, scenarios)?;
        Ok(Self {
            scenes: counted.iter().map(|own| own.name.clone()).collect(),
            clocks: (counted.iter())
                .map(|own| own.setup.costs().clock.clone())
                .collect(),
            rows,
            conclusions,
            errors,
        })
    }
}

/// Time, and energy where known.
type Spent = (AtBounds<f64>, Option<AtBounds<f64>>);

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
            speed_up: AtBounds::default(),
            saving: Some(AtBounds::default()),
        })
        .collect();
    for CountedScene { setup, path, .. } in counted {
        let model = Model {
            system,
            ..setup.model()
        };
        let mut baseline: Option<(Scenario, Spent)> = None;
        for (mean, (variant, scenario)) in means.iter_mut().zip(pairs) {
            let run = model.run(path, *variant, *scenario)?.0.run;
            let own = (run.span_ns(), run.total_mj());
            let (span, energy) = match baseline {
                Some((known, of)) if known == *scenario => of,
                _ => baseline.insert((*scenario, own)).1,
            };
            let add = |mean: &mut AtBounds<f64>, ratio: AtBounds<f64>| {
                mean.max += ratio.max / counted.len() as f64;
                mean.sum += ratio.sum / counted.len() as f64;
            };
            add(&mut mean.speed_up, span.over(&own.0));
            let ratio = energy.zip(own.1).map(|(whole, own)| whole.over(&own));
            mean.saving = mean.saving.zip(ratio).map(|(mut mean, ratio)| {
                add(&mut mean, ratio);
                mean
            });
        }
    }
    Ok(means)
}
