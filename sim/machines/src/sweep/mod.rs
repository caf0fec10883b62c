//! Sweeps: every point of a plan, each once, resumable; here on threads, or by an engine elsewhere.

mod beside;
mod counted_anew;
mod error;
pub(crate) mod evaluation;
mod front;
mod journal;
mod plan;
mod rows;
mod session;

use std::collections::HashSet;
use std::path::Path;

use potamoi_explore::Progress;

pub use beside::{Change, ColumnChange, by_column, changes};
pub use error::SweepError;
pub use evaluation::program;
pub use front::{Better, better, front};
pub use plan::Plan;
pub use rows::{Rows, SweepRow, setting};
pub use session::{MissingPoint, Session};

use self::evaluation::{Evaluation, Task};
use crate::cells::{COLUMNS, Cell};

/// Results of a sweep, and how much of it was there before.
#[derive(Debug, Clone)]
pub struct Swept {
    /// Rows in the order of the plan's points.
    pub rows: Rows,
    /// Points that were evaluated now; equal ones once.
    pub evaluated: usize,
    /// Points of the plan whose rows the journal had at the beginning; equal ones once.
    pub resumed: usize,
}

impl Plan {
    /// Evaluates all points whose rows the folder's journal lacks, on threads. Rows are the same on one
    /// thread or many, and whether the sweep was interrupted or not.
    ///
    /// # Errors
    /// The journal cannot be written, or is another program's.
    pub fn run(&self, folder: &Path, progress: &dyn Progress) -> Result<Swept, SweepError> {
        let mut evaluation = Evaluation::open(folder)?;
        let tasks = self.tasks();
        progress.expect(tasks.len() as u64);
        evaluation.all(&tasks, &self.workload, progress)?;
        Ok(self.swept(&tasks, &evaluation))
    }

    fn swept(&self, tasks: &[Task<'_>], evaluation: &Evaluation) -> Swept {
        // The journal may have points of other plans too.
        let known = tasks.iter().filter(|task| evaluation.line(task).is_some());
        let known: HashSet<&str> = known.map(|task| task.key.as_str()).collect();
        Swept {
            rows: self.rows(tasks, evaluation),
            evaluated: evaluation.evaluated,
            resumed: known.len().saturating_sub(evaluation.evaluated),
        }
    }

    fn tasks(&self) -> Vec<Task<'_>> {
        (0..self.len()).filter_map(|at| self.task(at)).collect()
    }

    /// The task of a point by its number.
    fn task(&self, number: usize) -> Option<Task<'_>> {
        let (scene, space, at) = self.point(number)?;
        let space = &self.spaces[space];
        let machine = space.machine(&space.places(at));
        Some(Task::of(machine, &self.scenes[scene], &self.workload))
    }

    fn rows(&self, tasks: &[Task<'_>], evaluation: &Evaluation) -> Rows {
        let rows = tasks.iter().enumerate().filter_map(|(at, task)| {
            let (scene, space, number) = self.point(at)?;
            let line = evaluation.line(task)?;
            let space = &self.spaces[space];
            let setting = space.setting(&space.places(number));
            Some(SweepRow {
                key: task.key.clone(),
                setting: setting.into_iter().map(|(_, value)| value).collect(),
                cells: match &line.row {
                    Ok(cells) => named(cells, &space.base.name),
                    Err(_) => refused(&space.base.name, self.scenes[scene].name()),
                },
                refused: line.row.clone().err(),
            })
        });
        Rows {
            fields: self.fields().into_iter().map(str::to_owned).collect(),
            rows: rows.collect(),
        }
    }
}

/// Cells with the machine's name: those of an equal one may have another.
fn named(cells: &[Cell], machine: &str) -> Vec<Cell> {
    let both = COLUMNS.iter().zip(cells);
    let cells = both.map(|(column, cell)| match column.name {
        "machine" => machine.into(),
        _ => cell.clone(),
    });
    cells.collect()
}

/// Cells of a point that is no machine, or whose machine cannot render the scene.
fn refused(machine: &str, scene: &str) -> Vec<Cell> {
    let cells = COLUMNS.iter().map(|column| match column.name {
        "machine" => machine.into(),
        "scene" => scene.into(),
        _ => Cell::Unknown,
    });
    cells.collect()
}
