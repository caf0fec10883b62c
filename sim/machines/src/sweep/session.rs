//! A sweep whose points an engine evaluates: what its folder lacks, and lines of points that come back.

use std::collections::HashSet;
use std::path::Path;

use serde::Serialize;

use super::evaluation::{Evaluation, Task, evaluate_each};
use super::journal::Line;
use super::{Plan, SweepError, Swept};
use crate::cells::COLUMNS;
use crate::workbench::Workbench;

/// A point whose line a folder lacks. Of points with equal keys the first stands for all.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct MissingPoint {
    /// Number of the point in the plan, from 0.
    pub number: usize,
    /// Key of its line.
    pub key: String,
    /// Names of the files of counted work that its figures are made from. Points that share a file share
    /// what is rendered for it. A point that is no machine has none.
    pub work: Vec<String>,
}

/// A sweep in a folder, open for lines of points.
pub struct Session<'a> {
    plan: &'a Plan,
    tasks: Vec<Task<'a>>,
    evaluation: Evaluation,
    /// Keys that the journal lacks.
    waiting: HashSet<String>,
}

impl Plan {
    /// Opens the journal of a folder.
    ///
    /// # Errors
    /// The journal cannot be written, or is another program's.
    pub fn session(&self, folder: &Path) -> Result<Session<'_>, SweepError> {
        let evaluation = Evaluation::open(folder)?;
        let tasks = self.tasks();
        let waiting = evaluation.waiting(&tasks).into_iter();
        Ok(Session {
            plan: self,
            waiting: waiting.map(|(_, task)| task.key.clone()).collect(),
            tasks,
            evaluation,
        })
    }

    /// Evaluates points by number, on at most so many threads, and hands over each line of the journal when
    /// its point is finished. No folder is read or written. It ends early where `hand_over` returns false.
    ///
    /// # Errors
    /// A number that is no point's.
    pub fn evaluate(
        &self,
        numbers: &[usize],
        threads: usize,
        hand_over: &(dyn Fn(&str) -> bool + Sync),
    ) -> Result<(), SweepError> {
        let task = |number: &usize| {
            let points = self.len();
            let number = *number;
            self.task(number)
                .ok_or(SweepError::Point { number, points })
        };
        let tasks = numbers.iter().map(task).collect::<Result<Vec<_>, _>>()?;
        let tasks: Vec<&Task<'_>> = tasks.iter().collect();
        let bench = Workbench::default();
        // What is not handed over is evaluated again by whoever lacks it.
        let _ = evaluate_each(&tasks, threads, (&bench, &self.workload), |line| {
            let text = serde_json::to_string(line).map_err(|_| ())?;
            hand_over(&text).then_some(()).ok_or(())
        });
        Ok(())
    }
}

impl Session<'_> {
    /// Points that the journal lacks, in the plan's order.
    #[must_use]
    pub fn missing(&self) -> Vec<MissingPoint> {
        let bench = Workbench::default();
        let waiting = self.evaluation.waiting(&self.tasks).into_iter();
        let each = waiting.map(|(number, task)| MissingPoint {
            number,
            key: task.key.clone(),
            work: task.counted_files(&bench, &self.plan.workload),
        });
        each.collect()
    }

    /// Writes a line of a point into the journal. False if it has the point already: the line is dropped.
    ///
    /// # Errors
    /// Text that is no line, a line of a point that the plan does not have, a journal that cannot be written.
    pub fn accept(&mut self, text: &str) -> Result<bool, SweepError> {
        let wrong = |problem: String| SweepError::Line { problem };
        let line: Line = serde_json::from_str(text).map_err(|error| wrong(error.to_string()))?;
        if let Ok(cells) = &line.row
            && cells.len() != COLUMNS.len()
        {
            let problem = format!("{} cells: expected {}", cells.len(), COLUMNS.len());
            return Err(wrong(problem));
        }
        if self.waiting.remove(&line.key) {
            self.evaluation.keep(line)?;
            return Ok(true);
        }
        match self.tasks.iter().any(|task| task.key == line.key) {
            true => Ok(false),
            false => Err(wrong(format!(
                "key {} is no point's of this plan",
                line.key
            ))),
        }
    }

    /// The rows of all points.
    ///
    /// # Errors
    /// The journal lacks some of them.
    pub fn finish(self) -> Result<Swept, SweepError> {
        match self.waiting.len() {
            0 => Ok(self.plan.swept(&self.tasks, &self.evaluation)),
            count => Err(SweepError::Lacking {
                count,
                points: self.tasks.len(),
            }),
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use std::sync::Mutex;

    /// Two lanes with two banks, one of which no unit has: the two that are refused are one point.
    const PLAN: &[u8] = b"width = 8\n[workload]\nfidelity = \"demand\"\nquality = false\n[vary]\n\
        \"gu.banks\" = [16, 0]\n\"vu.lanes\" = [3, 6]\n";

    fn plan() -> Plan {
        Plan::of(PLAN, "plan.toml", Path::new("")).unwrap()
    }

    fn lines(plan: &Plan, numbers: &[usize]) -> Vec<String> {
        let found = Mutex::new(vec![]);
        let keep = |line: &str| {
            found.lock().unwrap().push(line.to_owned());
            true
        };
        plan.evaluate(numbers, 2, &keep).unwrap();
        found.into_inner().unwrap()
    }

    fn written(folder: &Path) -> usize {
        let text = std::fs::read_to_string(folder.join("journal.jsonl")).unwrap();
        text.lines().count() - 1
    }

    #[test]
    fn lines_of_an_engine_make_the_rows_of_threads() {
        let folder = tempfile::tempdir().unwrap();
        let (plan, at) = (plan(), folder.path().join("engine"));
        let mut session = plan.session(&at).unwrap();
        let missing = session.missing();
        let numbers: Vec<usize> = missing.iter().map(|own| own.number).collect();
        assert_eq!(numbers[..2], [0, 1]);
        // Lanes alone render nothing again, and what is no machine renders nothing.
        assert!(missing[0].work.len() == 5 && missing[0].work == missing[1].work);
        assert!(missing[2].work.is_empty());
        for line in lines(&plan, &numbers) {
            assert!(session.accept(&line).unwrap());
            assert!(!session.accept(&line).unwrap(), "twice: {line}");
        }
        assert_eq!(written(&at), missing.len());
        let swept = session.finish().unwrap();
        let threads = plan.run(&folder.path().join("threads"), &()).unwrap();
        assert_eq!(swept.rows, threads.rows);
        assert_eq!(swept.evaluated, threads.evaluated);
        assert!(plan.session(&at).unwrap().missing().is_empty());
    }

    #[test]
    fn what_is_no_line_of_a_point_is_refused_and_a_lack_is_told() {
        let folder = tempfile::tempdir().unwrap();
        let plan = plan();
        let mut session = plan.session(folder.path()).unwrap();
        let line = lines(&plan, &[0]).remove(0);
        for (wrong, said) in [
            ("{", "no line"),
            ("{\"key\":\"0\",\"row\":{\"Err\":\"why\"}}", "key 0"),
            (&line.replace("\"Ok\":[", "\"Ok\":[1.0,"), "cells"),
        ] {
            let error = session.accept(wrong).unwrap_err().to_string();
            assert!(error.contains(said), "{wrong}: {error}");
        }
        assert!(session.accept(&line).unwrap());
        assert_eq!(written(folder.path()), 1);
        let error = session.finish().unwrap_err().to_string();
        assert!(error.contains("of 4 points"), "{error}");
        let error = plan.evaluate(&[4], 1, &|_| true).unwrap_err().to_string();
        assert!(error.contains("--points 4"), "{error}");
    }
}
