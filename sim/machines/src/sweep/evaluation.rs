//! Evaluation of points: each once, on threads, with a journal.

use std::collections::{HashMap, HashSet};
use std::convert::Infallible;
use std::num::NonZero;
use std::path::Path;
use std::sync::{Mutex, PoisonError};
use std::thread;

use potamoi_base::content_hash::hash_of;
use potamoi_explore::Progress;
use potamoi_explore::synthesis::in_parallel;
use potamoi_scene::Scene;

use super::SweepError;
use super::journal::{Journal, Line};
use crate::cells::COLUMNS;
use crate::machine::{Machine, MachineError};
use crate::quality::identity_of;
use crate::workbench::Workbench;
use crate::workload::Workload;

/// Version of the rows, raised where a figure or a column changes its meaning.
const VERSION: &str = "3";

/// What wrote a row: rows of another program are not taken for own ones.
#[must_use]
pub fn program() -> String {
    format!("potamoi {} rows {VERSION}", env!("CARGO_PKG_VERSION"))
}

/// A machine on a scene, and the key of its row: all that the row depends on.
pub(crate) struct Task<'a> {
    pub(crate) key: String,
    scene: &'a Scene,
    /// The machine, or why the values make none.
    machine: Result<Machine, String>,
}

impl<'a> Task<'a> {
    /// A machine on a scene.
    pub(crate) fn of(
        machine: Result<Machine, MachineError>,
        scene: &'a Scene,
        workload: &Workload,
    ) -> Self {
        let machine = machine.map_err(|error| error.to_string());
        let identity = match &machine {
            Ok(own) => own.identity().to_hex().to_string(),
            Err(why) => why.clone(),
        };
        let key = hash_of(&(identity, identity_of(scene).as_bytes(), workload));
        Self {
            key: key.to_hex()[..32].to_owned(),
            scene,
            machine,
        }
    }

    /// Names of the files of counted work that its figures are made from; none where it has no figures.
    pub(super) fn counted_files(&self, bench: &Workbench, workload: &Workload) -> Vec<String> {
        let machine = self.machine.as_ref().ok();
        let files = machine.map(|own| bench.counted_files(own, self.scene, workload));
        files.and_then(Result::ok).unwrap_or_default()
    }
}

/// Lines of points so far, and what they have in common.
pub(crate) struct Evaluation {
    journal: Journal,
    lines: HashMap<String, Line>,
    bench: Workbench,
    /// Points that were evaluated now.
    pub(crate) evaluated: usize,
}

impl Evaluation {
    /// Reads the journal of a folder.
    ///
    /// # Errors
    /// It cannot be written, or is another program's.
    pub(crate) fn open(folder: &Path) -> Result<Self, SweepError> {
        let (journal, lines) = Journal::open(folder, &program())?;
        Ok(Self {
            journal,
            lines,
            bench: Workbench::default(),
            evaluated: 0,
        })
    }

    /// Tasks that no line is of, with their numbers; of equal ones the first.
    pub(super) fn waiting<'t, 'a>(&self, tasks: &'t [Task<'a>]) -> Vec<(usize, &'t Task<'a>)> {
        let mut seen = HashSet::new();
        let each = tasks.iter().enumerate();
        let is_new = |task: &Task<'_>| !self.lines.contains_key(&task.key);
        each.filter(|(_, task)| is_new(task) && seen.insert(task.key.as_str()))
            .collect()
    }

    /// Evaluates the tasks that no line is of, in their order, so that neighbours share what is counted. Each
    /// task is a step, which the caller announces.
    ///
    /// # Errors
    /// The journal cannot be written.
    pub(crate) fn all(
        &mut self,
        tasks: &[Task<'_>],
        workload: &Workload,
        progress: &dyn Progress,
    ) -> Result<(), SweepError> {
        let waiting: Vec<&Task<'_>> = self
            .waiting(tasks)
            .into_iter()
            .map(|(_, own)| own)
            .collect();
        progress.pass_over((tasks.len() - waiting.len()) as u64);
        let jobs = thread::available_parallelism().map_or(1, NonZero::get);
        let failed = Mutex::new(None);
        let found = evaluate_each(&waiting, jobs, (&self.bench, workload), |line| {
            if let Err(error) = self.journal.append(line) {
                let mut failed = failed.lock().unwrap_or_else(PoisonError::into_inner);
                failed.get_or_insert(error);
            }
            progress.advance(1);
            Ok::<_, Infallible>(())
        });
        if let Some(error) = failed.into_inner().unwrap_or_else(PoisonError::into_inner) {
            return Err(error);
        }
        let found = found.unwrap_or_default();
        self.evaluated += found.len();
        self.lines
            .extend(found.into_iter().map(|line| (line.key.clone(), line)));
        Ok(())
    }

    /// Keeps a line that was made elsewhere.
    ///
    /// # Errors
    /// The journal cannot be written.
    pub(super) fn keep(&mut self, line: Line) -> Result<(), SweepError> {
        self.journal.append(&line)?;
        self.evaluated += 1;
        self.lines.insert(line.key.clone(), line);
        Ok(())
    }

    /// The line of a task that was evaluated.
    pub(crate) fn line(&self, task: &Task<'_>) -> Option<&Line> {
        self.lines.get(&task.key)
    }
}

/// Evaluates tasks on threads, and hands over each line when its task is finished; ends at the first failure.
pub(super) fn evaluate_each<E: Send>(
    tasks: &[&Task<'_>],
    threads: usize,
    (bench, workload): (&Workbench, &Workload),
    finished: impl Fn(&Line) -> Result<(), E> + Sync,
) -> Result<Vec<Line>, E> {
    // Not threads of a pool: one that waits in a pool takes up other tasks of it, which could ask for
    // the result that it is counting.
    in_parallel(tasks, threads, 0, &(), |task, _| {
        let line = evaluate(task, bench, workload);
        finished(&line)?;
        Ok(line)
    })
}

fn evaluate(task: &Task<'_>, bench: &Workbench, workload: &Workload) -> Line {
    let figures = task.machine.as_ref().map_err(Clone::clone);
    let figures = figures.and_then(|machine| {
        let own = bench.figures(machine, task.scene, workload, &());
        own.map_err(|error| error.to_string())
    });
    Line {
        key: task.key.clone(),
        row: figures.map(|own| COLUMNS.iter().map(|column| (column.of)(&own)).collect()),
    }
}
