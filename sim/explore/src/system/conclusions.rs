//! Conclusions about scenes, and whether the model's own error leaves them standing.
//!
//! A conclusion holds if it is the same at both bounds of the GPU's kernels, unchanged and under each
//! error. Otherwise it is open.

use std::collections::BTreeMap;

use potamoi_gpu::rows::Measured;
use potamoi_gpu::validate::{Check, Summary};
use potamoi_system::system_model::{AtBounds, GpuOnly, Model, Scenario, System, Variant};
use schemars::JsonSchema;
use serde::Serialize;

use super::counted_scene::CountedScene;
use crate::ExploreError;

/// Share by which wires lengthen the periods of logic, which are given before them. Assumed.
const WIRES: f64 = 0.25;
/// Ratios nearer to 1 are ties: jobs that share memory may end in another order.
const TIE: f64 = 0.005;

/// An error of the model: its name, and what is changed.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct ModelErrorNote {
    /// Name in a conclusion that it opens.
    pub name: &'static str,
    /// The change, and its origin.
    pub means: String,
}

/// An error of the model, as a change of the system.
struct ModelError {
    note: ModelErrorNote,
    make: Box<dyn Fn(&mut System)>,
    /// Factor of the accelerator's clock.
    clock: f64,
}

impl ModelError {
    fn new(name: &'static str, means: String, make: impl Fn(&mut System) + 'static) -> Self {
        Self {
            note: ModelErrorNote { name, means },
            make: Box::new(make),
            clock: 1.0,
        }
    }

    /// GPUs that are `factor` times as fast.
    fn of_gpus(name: &'static str, means: String, factor: f64) -> Self {
        Self::new(name, means, move |system| {
            for gpu in [&mut system.gpu, &mut system.remote] {
                gpu.device = gpu.device.faster(factor);
            }
        })
    }

    /// Each error by itself; those of GPUs are of the judged rows of `potamoi-gpu`.
    fn all() -> Result<Vec<Self>, ExploreError> {
        let judged = Measured::all()?.into_iter().filter(Measured::judged);
        let checks: Vec<Check> = judged
            .map(|row| Check::of(&row))
            .collect::<Result<_, _>>()?;
        let Summary { error, worst, .. } = Summary::of(&checks);
        let mean = format!("{error:.2} times, the mean error of measured frame rates");
        let furthest = format!("{worst:.2} times, the worst of them, which was too fast");
        let wires = format!("periods of logic {WIRES} longer than before wires, assumed");
        Ok(vec![
            Self::of_gpus("slower GPUs", mean.clone(), 1.0 / error),
            Self::of_gpus("faster GPUs", mean, error),
            Self::of_gpus("slowest GPUs", furthest, 1.0 / worst),
            Self {
                clock: 1.0 / (1.0 + WIRES),
                ..Self::new("wires", wires, |_| ())
            },
            Self::new(
                "half the interconnect",
                "twice the memory's peak is assumed".to_owned(),
                |system| system.interconnect_over_memory /= 2.0,
            ),
            Self::new(
                "blocks in a bank",
                "that a block of the feature buffer goes over its 48 banks is assumed".to_owned(),
                |system| system.feature_block_banks = 1,
            ),
        ])
    }
}

/// A statement about a scene.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Conclusion {
    /// The scene.
    pub scene: String,
    /// Where full frames are rendered.
    pub scenario: Scenario,
    /// What is compared: `A over B`, or what bounds a variant.
    pub of: String,
    /// How many times as fast, at both bounds; none for what bounds a variant.
    pub ratio: Option<AtBounds<f64>>,
    /// The ratio under each error, by name.
    pub under: BTreeMap<&'static str, AtBounds<f64>>,
    /// The lowest and the highest ratio, with and without errors.
    pub within: Option<[f64; 2]>,
    /// What is concluded without an error.
    pub says: String,
    /// Names of the errors under which it would be otherwise, each with what it would be.
    pub open_by: Vec<(&'static str, String)>,
}

/// One statement of an evaluation.
struct Said {
    of: String,
    ratio: Option<AtBounds<f64>>,
    says: String,
}

/// A scene's path on a system: nanoseconds of a frame and what bounds it, by variant, and
/// nanoseconds of a frame on the GPU alone by our fused program.
struct Evaluated {
    variants: Vec<(&'static str, AtBounds<f64>, AtBounds<&'static str>)>,
    alone: AtBounds<f64>,
}

impl Evaluated {
    fn of(
        CountedScene { setup, path, .. }: &CountedScene,
        system: &System,
        clock: f64,
        variants: &[Variant],
        scenario: Scenario,
    ) -> Result<Self, ExploreError> {
        let own = setup.model();
        let model = Model {
            system,
            clock_ghz: own.clock_ghz * clock,
            ..own
        };
        let each = variants.iter().map(|variant| {
            let run = model.run(path, *variant, scenario)?.0.run;
            let frame_ns = run.map(|run| run.span_ns / run.frames as f64);
            Ok((variant.name, frame_ns, run.map(|run| run.bottleneck().0)))
        });
        Ok(Self {
            variants: each.collect::<Result<_, ExploreError>>()?,
            alone: GpuOnly::of(&system.gpu.device, path).fused.frame_ns,
        })
    }

    /// Numbers of the variants from the fastest on.
    fn order(&self) -> Vec<usize> {
        let mut order: Vec<usize> = (0..self.variants.len()).collect();
        order.sort_by(|a, b| {
            let [a, b] = [a, b].map(|i| self.variants[*i].1.mid());
            a.total_cmp(&b)
        });
        order
    }

    /// Each variant over the baseline, which is the first; neighbours in an order; each variant over
    /// the GPU alone; what bounds each.
    fn says(&self, order: &[usize]) -> Vec<Said> {
        let all = &self.variants;
        let over = |a: &(&str, AtBounds<f64>, AtBounds<&str>), name: &str, ns: &AtBounds<f64>| {
            let ratio = ns.over(&a.1);
            Said {
                of: format!("{} over {name}", a.0),
                says: verdict(&ratio).to_owned(),
                ratio: Some(ratio),
            }
        };
        let baseline = &all[0];
        let speed_ups = all[1..]
            .iter()
            .map(|own| over(own, "the baseline", &baseline.1));
        let pairs = order.windows(2).map(|pair| [&all[pair[0]], &all[pair[1]]]);
        // Those with the baseline stand above.
        let pairs = pairs.filter(|pair| pair.iter().all(|own| own.0 != baseline.0));
        let pairs = pairs.map(|[a, b]| over(a, b.0, &b.1));
        let alone = all
            .iter()
            .map(|own| over(own, "the GPU alone", &self.alone));
        let bounds = all.iter().map(|(name, _, by)| Said {
            of: format!("what bounds {name}"),
            ratio: None,
            says: match by.max == by.sum {
                true => by.max.to_owned(),
                false => format!("{} or {}", by.max, by.sum),
            },
        });
        speed_ups.chain(pairs).chain(alone).chain(bounds).collect()
    }
}

/// What a ratio of speeds says.
fn verdict(ratio: &AtBounds<f64>) -> &'static str {
    if ratio.low() > 1.0 + TIE {
        "faster"
    } else if ratio.high() < 1.0 - TIE {
        "slower"
    } else if ratio.low() >= 1.0 - TIE && ratio.high() <= 1.0 + TIE {
        "as fast"
    } else {
        "no conclusion"
    }
}

/// All conclusions about scenes: each variant over the baseline, neighbours in the order of variants,
/// each variant over the GPU alone, and what bounds it.
pub(super) fn conclusions(
    counted: &[CountedScene],
    system: &System,
    variants: &[Variant],
    scenarios: &[Scenario],
) -> Result<(Vec<Conclusion>, Vec<ModelErrorNote>), ExploreError> {
    let errors = ModelError::all()?;
    let mut all = vec![];
    for scene in counted {
        for &scenario in scenarios {
            let plain = Evaluated::of(scene, system, 1.0, variants, scenario)?;
            let order = plain.order();
            let mut found: Vec<Conclusion> = (plain.says(&order).into_iter())
                .map(|own| Conclusion::new(&scene.name, scenario, own))
                .collect();
            for error in &errors {
                let mut system = system.clone();
                (error.make)(&mut system);
                let other = Evaluated::of(scene, &system, error.clock, variants, scenario)?;
                for (own, other) in found.iter_mut().zip(other.says(&order)) {
                    own.meets(error.note.name, other);
                }
            }
            all.extend(found);
        }
    }
    Ok((all, errors.into_iter().map(|error| error.note).collect()))
}

impl Conclusion {
    fn new(scene: &str, scenario: Scenario, said: Said) -> Self {
        Self {
            scene: scene.to_owned(),
            scenario,
            of: said.of,
            within: said.ratio.map(|ratio| [ratio.low(), ratio.high()]),
            ratio: said.ratio,
            under: BTreeMap::new(),
            says: said.says,
            open_by: vec![],
        }
    }

    /// Takes what would be said under an error.
    fn meets(&mut self, error: &'static str, other: Said) {
        if let Some(([low, high], ratio)) = self.within.as_mut().zip(other.ratio) {
            *low = low.min(ratio.low());
            *high = high.max(ratio.high());
            self.under.insert(error, ratio);
        }
        if self.says != other.says {
            self.open_by.push((error, other.says));
        }
    }

    /// Whether it is the same at both bounds and under each error.
    #[must_use]
    pub fn holds(&self) -> bool {
        self.open_by.is_empty() && self.says != "no conclusion" && !self.says.contains(" or ")
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::float_cmp)]
    use super::*;

    #[test]
    fn a_ratio_near_one_is_a_tie() {
        let of = |max, sum| verdict(&AtBounds { max, sum });
        assert_eq!(of(1.2, 3.0), "faster");
        assert_eq!(of(0.4, 0.9), "slower");
        assert_eq!(of(0.999, 1.002), "as fast");
        assert_eq!(of(0.9, 1.1), "no conclusion");
        assert_eq!(of(1.0, 1.02), "no conclusion");
    }

    /// Each error changes the system or the clock by the factor that its text names, and nothing
    /// else.
    #[test]
    fn errors_are_as_large_as_they_say() {
        let plain = System::default();
        let mut seen = 0;
        for error in ModelError::all().unwrap() {
            let mut other = plain.clone();
            (error.make)(&mut other);
            let gpu = other.gpu.device.clock_ghz / plain.gpu.device.clock_ghz;
            let remote = other.remote.device.clock_ghz / plain.remote.device.clock_ghz;
            let means = &error.note.means;
            let said = |factor: f64| means.starts_with(&format!("{factor:.2} times"));
            seen += 1;
            match error.note.name {
                "slower GPUs" => assert!(said(1.0 / gpu) && gpu == remote, "{gpu} {means}"),
                "faster GPUs" => assert!(said(gpu) && gpu == remote, "{gpu} {means}"),
                "slowest GPUs" => assert!(said(1.0 / gpu) && gpu < 0.5, "{gpu} {means}"),
                "wires" => assert_eq!((error.clock, &other), (1.0 / 1.25, &plain)),
                "half the interconnect" => {
                    let ratio = other.interconnect_over_memory / plain.interconnect_over_memory;
                    assert_eq!((ratio, gpu), (0.5, 1.0));
                }
                "blocks in a bank" => assert_eq!((other.feature_block_banks, gpu), (1, 1.0)),
                other => unreachable!("{other} has no test"),
            }
        }
        assert_eq!(seen, 6);
    }

    #[test]
    fn what_flips_under_an_error_is_open() {
        let said = |max, sum| Said {
            of: "potamoi over the GPU alone".to_owned(),
            ratio: Some(AtBounds { max, sum }),
            says: verdict(&AtBounds { max, sum }).to_owned(),
        };
        let mut own = Conclusion::new("cairn", Scenario::Local, said(1.1, 1.3));
        own.meets("wires", said(1.05, 1.2));
        assert!(own.holds());
        own.meets("slow GPUs", said(0.8, 0.9));
        assert!(!own.holds());
        assert_eq!(own.within, Some([0.8, 1.3]));
        assert_eq!(own.open_by, [("slow GPUs", "slower".to_owned())]);
        assert!(!Conclusion::new("cairn", Scenario::Local, said(0.9, 1.1)).holds());
    }
}
