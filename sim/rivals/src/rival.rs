//! Rivals: what they are made of.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::constant::{Constant, Origin};
use crate::trace::Class;

/// Why a rival's file is refused.
#[derive(Debug, thiserror::Error)]
#[error("{file}: {message}")]
pub struct RivalError {
    /// The file.
    pub file: String,
    /// What is wrong, and what was expected.
    pub message: String,
}

/// How the stages of a frame follow each other.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Overlap {
    /// All at the same time: a frame takes as long as its longest stage.
    Longest,
    /// One after the other.
    Sum,
}

/// What a stage takes of a count.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Term {
    /// The count.
    pub count: String,
    /// A count that bounds it from below, where the rival skips work that is not known; the count itself where the
    /// trace has none.
    pub least: Option<String>,
    /// Work for each.
    pub times: Constant,
}

/// What a stage asks for.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Demand {
    /// Work of units, each of which does so much in a cycle.
    Units {
        /// The work.
        work: Vec<Term>,
        /// Units.
        units: Constant,
        /// Work of a unit in a cycle.
        rate: Constant,
    },
    /// Bytes of the memory.
    Bytes {
        /// The bytes.
        work: Vec<Term>,
        /// Bandwidth in GB/s.
        bandwidth: Constant,
    },
    /// Kernels of a program on a GPU, by the model of `potamoi-gpu`.
    Gpu {
        /// The device.
        device: String,
        /// The program.
        program: String,
        /// Its kernels that stay on the GPU.
        kernels: Vec<String>,
        /// Counts of the program: of the trace, or constants.
        counts: Vec<(String, Source)>,
    },
}

/// Where a program's count comes from.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Source {
    /// A count of the trace.
    Count(String),
    /// A constant.
    Constant(Constant),
}

/// A stage.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Stage {
    /// Its name.
    pub name: String,
    /// What it asks for.
    pub demand: Demand,
}

/// A GPU that a speed-up is published over.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Beside {
    /// The device.
    pub device: String,
    /// The program.
    pub program: String,
    /// Its counts.
    pub counts: Vec<(String, Source)>,
}

/// A published figure, and the workload that is published for it.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Figure {
    /// What it is.
    pub what: String,
    /// Whether it stands in the rival's own publication.
    pub is_own: bool,
    /// Frames a second, or the speed-up over [`Figure::beside`].
    pub published: Constant,
    /// Class of the workload.
    pub class: Class,
    /// Its counts.
    pub counts: BTreeMap<String, Constant>,
    /// The GPU of a speed-up; none of a frame rate.
    pub beside: Option<Beside>,
}

/// A published accelerator.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Rival {
    /// Its name, that of the file.
    pub name: String,
    /// Its name in tables.
    pub title: String,
    /// Its publication.
    pub publication: String,
    /// What it renders.
    pub classes: Vec<Class>,
    /// Clock in GHz.
    pub clock_ghz: Constant,
    /// Technology node of area and power, in nm.
    pub node_nm: Constant,
    /// Area in mm^2.
    pub area_mm2: Constant,
    /// Power in W, without memory.
    pub power_w: Constant,
    /// How the stages follow each other.
    pub overlap: Overlap,
    /// Where that is said.
    pub overlap_origin: Origin,
    /// Its stages.
    pub stages: Vec<Stage>,
    /// What the model leaves out.
    pub left_out: Vec<String>,
    /// Published figures to compute again.
    pub figures: Vec<Figure>,
}

impl Rival {
    /// All constants of the machine, each with its place; those of its figures are not among them.
    #[must_use]
    pub fn constants(&self) -> Vec<(String, &Constant)> {
        let named = |name: &str, own| (name.to_owned(), own);
        let mut all = vec![
            named("clock", &self.clock_ghz),
            named("node", &self.node_nm),
            named("area", &self.area_mm2),
            named("power", &self.power_w),
        ];
        for stage in &self.stages {
            let of = |what: &str| format!("{}: {what}", stage.name);
            let terms = |work: &'_ [Term]| -> Vec<String> {
                work.iter()
                    .map(|own| of(&format!("work a unit of {}", own.count)))
                    .collect()
            };
            match &stage.demand {
                Demand::Units { work, units, rate } => {
                    all.push((of("units"), units));
                    all.push((of("rate"), rate));
                    all.extend(
                        terms(work)
                            .into_iter()
                            .zip(work.iter().map(|own| &own.times)),
                    );
                }
                Demand::Bytes { work, bandwidth } => {
                    all.push((of("bandwidth"), bandwidth));
                    all.extend(
                        terms(work)
                            .into_iter()
                            .zip(work.iter().map(|own| &own.times)),
                    );
                }
                Demand::Gpu { counts, .. } => {
                    for (name, source) in counts {
                        if let Source::Constant(own) = source {
                            all.push((of(name), own));
                        }
                    }
                }
            }
        }
        all
    }
}
