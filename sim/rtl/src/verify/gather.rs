//! Verification of the gathering unit.

use std::sync::Arc;

use potamoi_cycles::{GatherWork, runs};
use potamoi_formats::config::Config;
use potamoi_formats::units::GATHERING_UNIT;
use potamoi_reference::GatherTask;
use potamoi_units::gathering_unit::gathering_unit;

use super::under_way::{Piece, Runs, UnderWay};
use super::{Conditions, Verifier};
use crate::gather_drive::GatherTotals;
use crate::{GatherUnit, Mismatch, RtlError};

/// MVoxels, and what the reference unit makes of them.
struct Gathering {
    unit: Arc<GatherUnit>,
    config: Arc<Config>,
    tasks: Vec<GatherTask>,
    features: Vec<i32>,
    flags: u64,
}

/// MVoxels under way.
struct GatherPiece {
    work: Arc<Gathering>,
    runs: Runs<GatherTotals>,
}

impl Gathering {
    fn run(
        &self,
        conditions: &Conditions,
        progress: &mut dyn FnMut(u64),
    ) -> Result<GatherTotals, RtlError> {
        let check = conditions.check(self.flags, progress);
        self.unit
            .check(&self.config, &self.tasks, &self.features, check)
    }
}

impl Piece for GatherPiece {
    fn cycles(&self) -> u64 {
        self.runs.cycles()
    }

    fn compare(self: Box<Self>, verifier: &mut Verifier<'_>) -> Result<(), RtlError> {
        verifier.compare_gather(*self)
    }
}

impl Verifier<'_> {
    /// Verifies the share of `tasks` in the settings. `features` (or sums) and `flags`, one for
    /// each task, are the reference unit's.
    pub(super) fn verify_gather(
        &mut self,
        tasks: &[GatherTask],
        features: &[i32],
        flags: &[u8],
    ) -> Result<(), RtlError> {
        let every = self.settings.gather_every.max(1);
        let before = self.gather.mvoxels_total;
        self.gather.mvoxels_total += tasks.len() as u64;
        self.gather.samples_total += tasks.iter().map(|t| t.entries.len() as u64).sum::<u64>();
        if every == 1 {
            return self.gather_runs(tasks, features, flags);
        }
        let (mut picked, mut values, mut raised) = (vec![], vec![], vec![]);
        let mut at = 0;
        for ((number, task), flags) in (before..).zip(tasks).zip(flags) {
            let codes = task.entries.len() * task.channels;
            if number.is_multiple_of(every) {
                picked.push(task.clone());
                values.extend_from_slice(&features[at..at + codes]);
                raised.push(*flags);
            }
            at += codes;
        }
        self.gather_runs(&picked, &values, &raised)
    }

    fn gather_runs(
        &mut self,
        tasks: &[GatherTask],
        features: &[i32],
        flags: &[u8],
    ) -> Result<(), RtlError> {
        let (mut first, mut from) = (0, 0);
        for tasks in runs(tasks) {
            let codes: usize = tasks.iter().map(|t| t.entries.len() * t.channels).sum();
            let flags = flags[first..first + tasks.len()]
                .iter()
                .fold(0, |a, b| a | b);
            self.gather_run(tasks, &features[from..from + codes], u64::from(flags))?;
            first += tasks.len();
            from += codes;
        }
        Ok(())
    }

    fn gather_run(
        &mut self,
        tasks: &[GatherTask],
        features: &[i32],
        flags: u64,
    ) -> Result<(), RtlError> {
        let unit = match &self.gather_unit {
            Some(unit) => unit.clone(),
            None => Arc::new(self.build_gather()?),
        };
        self.gather_unit = Some(unit.clone());
        self.gather.reach.add(&self.config, tasks);
        let work = Arc::new(Gathering {
            unit,
            config: self.config.clone(),
            tasks: tasks.to_vec(),
            features: features.to_vec(),
            flags,
        });
        let conditions = self.conditions();
        let runs = UnderWay::begin(conditions, {
            let work = work.clone();
            move |conditions, progress| work.run(conditions, progress)
        });
        self.add(Box::new(GatherPiece { work, runs }))
    }

    /// Compares both runs of a piece of work.
    fn compare_gather(&mut self, piece: GatherPiece) -> Result<(), RtlError> {
        let GatherPiece { work: own, runs } = piece;
        let tasks = &own.tasks;
        let work = GatherWork::new(&self.config, tasks)?;
        let predicted = work.predicted(&self.config)?;
        for (conditions, totals) in self.wait(runs) {
            let (stalled, seed) = (conditions.is_stalled, conditions.seed);
            let totals = match totals {
                Ok(totals) => totals,
                Err(RtlError::Mismatch(mismatch)) => {
                    let excerpt = self.excerpt(|path| {
                        let none = &mut |_| {};
                        let check = conditions.check(own.flags, none);
                        let Gathering { unit, config, .. } = &*own;
                        unit.excerpt(config, tasks, &own.features, check, mismatch.cycle, path)
                    });
                    return Err(self.fail(*mismatch, stalled, seed, excerpt));
                }
                Err(other) => return Err(other),
            };
            let report = &mut self.gather;
            report.cycles_compared += totals.cycles;
            let [fifo, mft, rit] = totals.stalls;
            let all = [fifo, mft, rit, totals.stall_bank];
            for (sum, own) in report.stalls_compared.iter_mut().zip(all) {
                *sum += own;
            }
            if stalled {
                report.cycles_stalled += totals.cycles;
                continue;
            }
            let fill = totals.first_issue - totals.first_beat;
            for (signal, found, expected) in [
                (
                    "cycles from the first to the last issue",
                    totals.issue_span(),
                    predicted.issue_span(),
                ),
                ("issuing cycles", totals.busy, predicted.busy),
                ("stalls for banks", totals.stall_bank, predicted.stall_bank),
                ("cycles of first fill", fill, predicted.fill),
                (
                    "cycles from the first RIT beat to the last feature",
                    totals.cycles - totals.first_beat,
                    predicted.elapsed,
                ),
            ] {
                if found != expected {
                    let place = format!("whole run of {} MVoxels, closed form", tasks.len());
                    let mismatch = Mismatch {
                        module: GATHERING_UNIT,
                        cycle: totals.cycles,
                        signal: signal.to_owned(),
                        expected: expected.to_string(),
                        found: found.to_string(),
                        place,
                    };
                    return Err(self.fail(mismatch, stalled, seed, None));
                }
            }
            report.runs += 1;
            report.mvoxels += tasks.len() as u64;
            report.samples += work.entries();
            report.cycles += totals.issue_span();
            report.cycles_predicted += predicted.issue_span();
            report.busy += totals.busy;
            report.stall_fifo += fifo;
            report.stall_mft += mft;
            report.stall_rit += rit;
            report.stall_bank += totals.stall_bank;
            report.fill += fill;
            report.fill_predicted += predicted.fill;
        }
        Ok(())
    }

    fn build_gather(&self) -> Result<GatherUnit, RtlError> {
        let engine = self.settings.engine;
        if let Some(rtl) = &self.settings.rtl {
            let files = rtl.files(gathering_unit(&self.config)?.as_ref())?;
            return GatherUnit::of_files(engine, &self.config, &files);
        }
        let own = self.settings.inject.filter(|i| i.is_of_gathering_unit());
        let Some(injection) = own else {
            return GatherUnit::on(engine, &self.config);
        };
        let right = gathering_unit(&self.config)?;
        GatherUnit::of_module(
            engine,
            &self.config,
            &injection.apply(&self.config, &right)?,
        )
    }
}
