//! The search for the best machine of a space.

mod by_schedule;
mod goal;
mod sampler;

use std::collections::HashSet;
use std::path::Path;

use potamoi_explore::Progress;
use potamoi_scene::Scene;
use schemars::JsonSchema;
use serde::Serialize;

pub use by_schedule::{BySchedule, CHECKED};
pub use goal::{Goal, Objective, Standing, is_clock_above_reached, is_clock_guessed};

use self::sampler::{Parzen, Random, Sampler};
use crate::cells::Cell;
use crate::machine::{Machine, MachineError};
use crate::space::{Setting, Space};
use crate::sweep::evaluation::{Evaluation, Task};
use crate::sweep::{SweepError, front};
use crate::workload::Workload;

/// Points that are asked for before any of them is evaluated, on any number of threads.
const BATCH: usize = 8;
/// Known points that a sampler may propose for a batch before chance fills it.
const PATIENCE: usize = 200;

/// A search.
pub struct Search<'a> {
    /// Machines among which it is.
    pub space: &'a Space,
    /// Scenes that each machine renders.
    pub scenes: &'a [Scene],
    /// What it seeks.
    pub goal: Goal,
    /// What machines do on each scene.
    pub workload: Workload,
    /// Most points that it tries; a space with no more points is tried whole.
    pub budget: usize,
    /// Seed of the samplers.
    pub seed: u64,
}

/// How points were chosen.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Method {
    /// Every point of the space.
    Exhaustive,
    /// Tree-structured Parzen estimators.
    Estimators,
    /// Random search.
    Random,
}

/// A point that was tried.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct Tried {
    /// Values of the varied fields.
    pub setting: Setting,
    /// Whether it keeps the limits.
    pub keeps_limits: bool,
    /// Cells on each scene, in the order of [`COLUMNS`](crate::cells::COLUMNS); why there are none.
    pub scenes: Vec<Result<Vec<Cell>, String>>,
    #[serde(skip)]
    places: Vec<usize>,
    #[serde(skip)]
    standing: Option<Standing>,
    /// The limits that it misses, in words; none where it keeps them all.
    #[serde(skip)]
    pub missed: Vec<String>,
}

/// Points of one method.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct Trials {
    /// The method.
    pub method: Method,
    /// All points in the order in which they were tried.
    pub tried: Vec<Tried>,
    /// Index of the best of them: one that keeps the limits, where there is one.
    pub best: Option<usize>,
    /// Indices of the front of objective, area and quality among those that keep the limits, the best
    /// objective first.
    pub front: Vec<usize>,
}

impl Trials {
    /// The best point, whether it keeps the limits or not.
    #[must_use]
    pub fn nearest(&self) -> Option<&Tried> {
        self.best.and_then(|at| self.tried.get(at))
    }
}

/// Result of a search.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct Searched {
    /// Points of the space.
    pub points: usize,
    /// The base machine, for ratios.
    pub base: Tried,
    /// The search.
    pub trials: Trials,
    /// A random search of the same budget beside it; `None` where every point was tried.
    pub random: Option<Trials>,
    /// The best of a search by demand, evaluated again by their schedule; `None` of a search by schedule.
    pub by_schedule: Option<BySchedule>,
}

impl Searched {
    /// The base, by the method that [`Searched::found`] is judged by.
    #[must_use]
    pub fn judged_base(&self) -> &Tried {
        (self.by_schedule.as_ref()).map_or(&self.base, |own| &own.base)
    }

    /// The best point that was tried by any method, where it keeps the limits: by its schedule.
    #[must_use]
    pub fn found(&self) -> Option<&Tried> {
        self.nearest().filter(|own| own.keeps_limits)
    }

    /// All points that were tried by any method.
    pub fn tried(&self) -> impl Iterator<Item = &Tried> {
        let all = [Some(&self.trials), self.random.as_ref()];
        all.into_iter().flatten().flat_map(|own| &own.tried)
    }

    /// The front of objective, area and quality among all that were tried and keep the limits, the best
    /// objective first.
    #[must_use]
    pub fn front(&self, objective: Objective) -> Vec<&Tried> {
        let all: Vec<&Tried> = self.tried().collect();
        let on = front_of(&all, objective);
        on.into_iter()
            .filter_map(|at| all.get(at).copied())
            .collect()
    }

    /// The best point that was tried by any method, by its schedule.
    #[must_use]
    pub fn nearest(&self) -> Option<&Tried> {
        if let Some(own) = &self.by_schedule {
            return own.best();
        }
        let all = [Some(&self.trials), self.random.as_ref()];
        let each = all.into_iter().flatten().filter_map(Trials::nearest);
        each.reduce(|best, own| match own.is_better(best) {
            true => own,
            false => best,
        })
    }
}

impl Tried {
    /// Whether it has figures on every scene.
    #[must_use]
    pub fn has_figures(&self) -> bool {
        self.scenes.iter().all(Result::is_ok)
    }

    /// Blocks whose energy or area is not known, with the reason, on the first scene with such blocks.
    #[must_use]
    pub fn unknown(&self) -> Option<&str> {
        let mut rows = self.scenes.iter().flatten();
        rows.find_map(|cells| goal::text(cells, "unknown"))
    }

    /// Whether its clock is above the one that its slowest block reaches, on any scene.
    #[must_use]
    pub fn is_clock_above_reached(&self) -> bool {
        let mut rows = self.scenes.iter().flatten();
        rows.any(|cells| is_clock_above_reached(cells))
    }

    /// Whether its clock rests on a block of unknown period, on any scene.
    #[must_use]
    pub fn is_clock_guessed(&self) -> bool {
        let mut rows = self.scenes.iter().flatten();
        rows.any(|cells| is_clock_guessed(cells))
    }

    /// Whether this stands better than another: limits first, then objective, then area.
    #[must_use]
    pub fn is_better(&self, other: &Self) -> bool {
        match (&self.standing, &other.standing) {
            (Some(own), Some(other)) => own.is_better(other),
            (own, _) => own.is_some(),
        }
    }
}

impl Search<'_> {
    /// Runs the search; a journal in `folder` has every evaluated point, so that the same search goes on
    /// where it was interrupted.
    ///
    /// # Errors
    /// The journal cannot be written.
    pub fn run(&self, folder: &Path, progress: &dyn Progress) -> Result<Searched, SweepError> {
        let mut evaluation = Evaluation::open(folder)?;
        let points = self.space.len();
        let tried = match points <= self.budget {
            true => points,
            false => 2 * self.budget,
        };
        let again = by_schedule::most(self, points);
        progress.expect((self.scenes.len() * (1 + tried + again)) as u64);
        let base = self.base(&mut evaluation, progress)?;
        // A clock that is a guess is no gain over one that is known.
        let goal = Goal {
            needs_known_clock: !base.is_clock_guessed(),
            ..self.goal
        };
        let own = Search { goal, ..*self };
        let searched = own.searched(base, &mut evaluation, progress)?;
        by_schedule::checked(&own, searched, &mut evaluation, progress)
    }

    /// Tries points beside a base.
    fn searched(
        &self,
        base: Tried,
        evaluation: &mut Evaluation,
        progress: &dyn Progress,
    ) -> Result<Searched, SweepError> {
        let points = self.space.len();
        if points <= self.budget {
            let all = (0..points).map(|at| self.space.places(at)).collect();
            let tried = self.tried(all, evaluation, progress)?;
            return Ok(Searched {
                points,
                base,
                trials: trials(Method::Exhaustive, tried, self.goal.objective),
                random: None,
                by_schedule: None,
            });
        }
        let mut with = |method, sampler: &mut dyn Sampler| {
            let tried = self.sampled(sampler, evaluation, progress)?;
            Ok::<_, SweepError>(trials(method, tried, self.goal.objective))
        };
        let own = with(Method::Estimators, &mut Parzen::new(self.space, self.seed))?;
        let random = with(Method::Random, &mut Random::new(self.space, self.seed))?;
        Ok(Searched {
            points,
            base,
            trials: own,
            random: Some(random),
            by_schedule: None,
        })
    }

    /// The machine of a point.
    ///
    /// # Errors
    /// Values that do not go together.
    pub fn machine(&self, tried: &Tried) -> Result<Machine, MachineError> {
        self.space.machine(&tried.places)
    }

    fn base(
        &self,
        evaluation: &mut Evaluation,
        progress: &dyn Progress,
    ) -> Result<Tried, SweepError> {
        let base = &self.space.base;
        let tasks: Vec<Task<'_>> = (self.scenes.iter())
            .map(|scene| Task::of(Ok(base.clone()), scene, &self.workload))
            .collect();
        evaluation.all(&tasks, &self.workload, progress)?;
        let fields = self.space.axes.iter().flat_map(|axis| &axis.fields);
        let own = |field: &String| base.value(field).unwrap_or_else(|| "default".to_owned());
        let setting = fields.map(|field| (field.clone(), own(field))).collect();
        Ok(self.read(setting, vec![], &tasks, evaluation))
    }

    /// Points by a sampler: none twice, in batches that do not depend on the number of threads.
    fn sampled(
        &self,
        sampler: &mut dyn Sampler,
        evaluation: &mut Evaluation,
        progress: &dyn Progress,
    ) -> Result<Vec<Tried>, SweepError> {
        let (mut all, mut known): (Vec<Tried>, HashSet<Vec<usize>>) = (vec![], HashSet::new());
        let mut chance = Random::new(self.space, self.seed.wrapping_add(2));
        while all.len() < self.budget {
            let (mut batch, mut patience) = (vec![], PATIENCE);
            while batch.len() < BATCH.min(self.budget - all.len()) {
                // Estimators that propose known points alone have nothing more to say: chance goes on.
                let places = match patience {
                    0 => chance.ask(),
                    _ => sampler.ask(),
                };
                match known.insert(places.clone()) {
                    true => batch.push(places),
                    false => patience = patience.saturating_sub(1),
                }
            }
            for tried in self.tried(batch, evaluation, progress)? {
                let value = tried.standing.map_or(f64::MAX, |own| own.value());
                sampler.tell(&tried.places, value);
                all.push(tried);
            }
        }
        Ok(all)
    }

    /// Evaluates points on all scenes.
    fn tried(
        &self,
        points: Vec<Vec<usize>>,
        evaluation: &mut Evaluation,
        progress: &dyn Progress,
    ) -> Result<Vec<Tried>, SweepError> {
        let task = |places: &Vec<usize>, scene| {
            Task::of(self.space.machine(places), scene, &self.workload)
        };
        let tasks: Vec<Task<'_>> = (points.iter())
            .flat_map(|places| self.scenes.iter().map(|scene| task(places, scene)))
            .collect();
        evaluation.all(&tasks, &self.workload, progress)?;
        let each = points
            .into_iter()
            .zip(tasks.chunks(self.scenes.len().max(1)));
        Ok(each
            .map(|(places, tasks)| {
                self.read(self.space.setting(&places), places, tasks, evaluation)
            })
            .collect())
    }

    fn read(
        &self,
        setting: Setting,
        places: Vec<usize>,
        tasks: &[Task<'_>],
        evaluation: &Evaluation,
    ) -> Tried {
        let rows = tasks.iter().map(|task| match evaluation.line(task) {
            Some(line) => line.row.clone(),
            None => Err("it was not evaluated".to_owned()),
        });
        let scenes: Vec<_> = rows.collect();
        let cells: Vec<Option<&[Cell]>> = scenes.iter().map(|own| own.as_deref().ok()).collect();
        let standing = self.goal.standing(&cells);
        Tried {
            keeps_limits: standing.keeps_limits(),
            standing: Some(standing),
            missed: self.goal.missed(&cells),
            setting,
            scenes,
            places,
        }
    }
}

impl Tried {
    /// The objective, its geometric mean over scenes; area; and the least PSNR. `None` where one of the
    /// first two is not known.
    #[must_use]
    pub fn place(&self, objective: Objective) -> Option<[f64; 3]> {
        let (column, _) = objective.column();
        let scenes: Vec<&Vec<Cell>> = self.scenes.iter().flatten().collect();
        let all = |name: &str| -> Option<Vec<f64>> {
            scenes
                .iter()
                .map(|cells| goal::figure(cells, name))
                .collect()
        };
        let own = all(column)?;
        let mean = own.iter().map(|own| own.ln()).sum::<f64>() / own.len().max(1) as f64;
        let area = all("mm2")?.first().copied()?;
        // Equal pictures have no PSNR.
        let psnr = scenes
            .iter()
            .filter_map(|cells| goal::figure(cells, "psnr_db"));
        Some([mean.exp(), area, psnr.fold(f64::INFINITY, f64::min)])
    }
}

/// The front of objective, area and quality among points that keep the limits.
fn front_of(tried: &[&Tried], objective: Objective) -> Vec<usize> {
    let (column, is_more) = objective.column();
    let kept = tried.iter().enumerate().filter(|(_, own)| own.keeps_limits);
    let placed: Vec<(usize, [f64; 3])> = kept
        .filter_map(|(at, own)| Some((at, own.place(objective)?)))
        .collect();
    let rows: Vec<Vec<Cell>> = (placed.iter())
        .map(|(_, place)| place.map(Cell::Number).to_vec())
        .collect();
    let columns = [(0, column), (1, "mm2"), (2, "psnr_db")];
    // Every objective's column has a better end.
    let on = front(&rows, &columns).unwrap_or_default();
    let mut own: Vec<(usize, [f64; 3])> = placed
        .into_iter()
        .zip(on)
        .filter(|(_, on)| *on)
        .map(|(own, _)| own)
        .collect();
    own.sort_by(|(_, a), (_, b)| {
        let order = a[0].total_cmp(&b[0]);
        let order = if is_more { order.reverse() } else { order };
        order.then(a[1].total_cmp(&b[1]))
    });
    own.dedup_by(|(_, b), (_, a)| a == b);
    own.into_iter().map(|(at, _)| at).collect()
}

fn trials(method: Method, tried: Vec<Tried>, objective: Objective) -> Trials {
    let standings = tried.iter().enumerate();
    let standings = standings.filter_map(|(at, own)| Some((at, own.standing?)));
    let best = standings.reduce(|best, own| match own.1.is_better(&best.1) {
        true => own,
        false => best,
    });
    Trials {
        method,
        best: best.map(|(at, _)| at),
        front: front_of(&tried.iter().collect::<Vec<_>>(), objective),
        tried,
    }
}
