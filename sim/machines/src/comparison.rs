//! Machines side by side.

use std::convert::Infallible;
use std::num::NonZero;
use std::thread;

use potamoi_explore::Progress;
use potamoi_explore::synthesis::in_parallel;
use potamoi_scene::Scene;
use potamoi_system::system_model::AtBounds;
use schemars::JsonSchema;
use serde::Serialize;

use crate::cells::{COLUMNS, Cell};
use crate::figures::Figures;
use crate::machine::{Machine, MachineError};
use crate::workbench::Workbench;
use crate::workload::Workload;

/// A machine on a scene: figures, or why there are none.
#[derive(Debug, Clone, Serialize, JsonSchema)]
#[serde(untagged)]
pub enum Row {
    /// Its figures.
    Figures(Box<Figures>),
    /// It cannot render the scene.
    Refused {
        /// The machine.
        machine: String,
        /// The scene.
        scene: String,
        /// The reason.
        refused: String,
    },
}

impl Row {
    /// The figures, if there are some.
    #[must_use]
    pub fn figures(&self) -> Option<&Figures> {
        match self {
            Self::Figures(own) => Some(own),
            Self::Refused { .. } => None,
        }
    }
}

/// Machines on scenes, ratios over the first machine.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct Comparison {
    /// What they do.
    pub workload: Workload,
    /// Scenes in order, each with its machines in order.
    pub scenes: Vec<Vec<Row>>,
}

impl Comparison {
    /// Compares machines on scenes. Work that several have in common is counted once.
    ///
    /// # Errors
    /// No machine can render any of the scenes; the first reason is the error's.
    pub fn of(
        machines: &[Machine],
        scenes: &[Scene],
        workload: &Workload,
        progress: &dyn Progress,
    ) -> Result<Self, MachineError> {
        let bench = Workbench::default();
        progress.expect((machines.len() * scenes.len()) as u64);
        let one = |machine: &Machine, scene: &Scene| {
            progress.now(&format!("{} on {}", scene.name(), machine.name));
            let found = bench.figures(machine, scene, workload, &());
            progress.advance(1);
            found
        };
        let jobs = thread::available_parallelism().map_or(1, NonZero::get);
        let mut failed = None;
        let rows = scenes.iter().map(|scene| {
            // Not threads of a pool: one that waits in a pool takes up other tasks of it, which could ask
            // for the result that it is counting.
            let never = |own: &Machine, _: &dyn Fn()| Ok::<_, Infallible>(one(own, scene));
            let found = in_parallel(machines, jobs, 0, &(), never).unwrap_or_default();
            let rows = found
                .into_iter()
                .zip(machines)
                .map(|(found, machine)| match found {
                    Ok(figures) => Row::Figures(Box::new(figures)),
                    Err(error) => {
                        let refused = error.to_string();
                        failed.get_or_insert(error);
                        Row::Refused {
                            machine: machine.name.clone(),
                            scene: scene.name().to_owned(),
                            refused,
                        }
                    }
                });
            rows.collect()
        });
        let scenes: Vec<Vec<Row>> = rows.collect();
        let any = scenes.iter().flatten().any(|row| row.figures().is_some());
        match (any, failed) {
            (false, Some(error)) => Err(error),
            _ => Ok(Self {
                workload: *workload,
                scenes,
            }),
        }
    }

    /// Ratios of a row over the first machine on the same scene.
    #[must_use]
    pub fn ratios(&self, scene: usize, row: usize) -> Option<Ratios> {
        let rows = self.scenes.get(scene)?;
        Some(Ratios::of(
            rows.get(row)?.figures()?,
            rows.first()?.figures()?,
        ))
    }

    /// Geometric means of a machine's ratios over the scenes on which both have figures, and the number
    /// of those scenes.
    #[must_use]
    pub fn means(&self, row: usize) -> Option<(Ratios, usize)> {
        let all = (0..self.scenes.len()).filter_map(|scene| self.ratios(scene, row));
        let all: Vec<Ratios> = all.collect();
        let known: Option<Vec<_>> = all.iter().map(|own| own.energy).collect();
        (!all.is_empty()).then(|| {
            let own = Ratios {
                rate: mean(all.iter().map(|own| own.rate)),
                energy: known.map(|own| mean(own.into_iter())),
            };
            (own, all.len())
        })
    }

    /// All rows as CSV, with [`COLUMNS`], the ratios, and the reason of a refusal.
    ///
    /// # Errors
    /// None: it is written to memory.
    pub fn csv(&self) -> Result<String, csv::Error> {
        let mut csv = csv::Writer::from_writer(vec![]);
        let more = ["fps_ratio", "saving", "refused"];
        csv.write_record(COLUMNS.iter().map(|own| own.name).chain(more))?;
        for (at, rows) in self.scenes.iter().enumerate() {
            for (row, own) in rows.iter().enumerate() {
                let cells: Vec<Cell> = match own {
                    Row::Figures(own) => {
                        let ratios = self.ratios(at, row);
                        let energy = ratios.and_then(|own| own.energy).map(|own| own.mid());
                        let rate = ratios.map(|own| own.rate.mid());
                        let own = COLUMNS.iter().map(|column| (column.of)(own));
                        own.chain([rate.into(), energy.into(), Cell::Unknown])
                            .collect()
                    }
                    Row::Refused {
                        machine,
                        scene,
                        refused,
                    } => {
                        let known = COLUMNS.iter().map(|column| match column.name {
                            "machine" => machine.as_str().into(),
                            "scene" => scene.as_str().into(),
                            _ => Cell::Unknown,
                        });
                        let last = [Cell::Unknown, Cell::Unknown, refused.as_str().into()];
                        known.chain(last).collect()
                    }
                };
                csv.write_record(cells.iter().map(ToString::to_string))?;
            }
        }
        let bytes = csv.into_inner().map_err(|error| error.into_error())?;
        Ok(String::from_utf8_lossy(&bytes).into_owned())
    }
}

/// Ratios of a machine over another, at both bounds of the GPU's kernels.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct Ratios {
    /// Its frames a second over the other's.
    pub rate: AtBounds<f64>,
    /// The other's energy over its own; `None` where one is not known.
    pub energy: Option<AtBounds<f64>>,
}

impl Ratios {
    fn of(own: &Figures, other: &Figures) -> Self {
        let energy = other.mj.zip(own.mj);
        Self {
            rate: own.frames_per_second.over(&other.frames_per_second),
            energy: energy.map(|(other, own)| other.over(&own)),
        }
    }
}

/// Geometric mean at each bound.
fn mean(of: impl Iterator<Item = AtBounds<f64>> + Clone) -> AtBounds<f64> {
    let at = |bound: fn(&AtBounds<f64>) -> f64| {
        let (sum, count) = of.clone().fold((0.0, 0.0), |(sum, count), own| {
            (sum + bound(&own).ln(), count + 1.0)
        });
        f64::exp(sum / f64::max(count, 1.0))
    };
    AtBounds {
        max: at(|own| own.max),
        sum: at(|own| own.sum),
    }
}
