//! Runs compared in every bit and every cycle.

use std::path::Path;

use potamoi_cycles::{GatherWork, Stalls};
use potamoi_formats::config::Config;
use potamoi_formats::units::{GATHERING_UNIT, VECTOR_UNIT};
use potamoi_reference::GatherTask;

use super::gather::GatherUnit;
use super::gather_check::GatherCheck;
use super::gather_drive::GatherTotals;
use super::mismatch::Mismatch;
use super::model::RtlError;
use super::port_trace::Traced;
use super::vector::VectorUnit;
use super::vector_check::VectorCheck;
use super::vector_drive::{VectorBatch, VectorTotals};
use super::wave_dump::Window;

/// Cycles that a unit is observed after its last beat; no further beat may come.
pub(super) const DRAIN: u64 = 16;

/// Conditions of a comparison.
pub struct Check<'a> {
    /// Random stalls of the streams.
    pub stalls: Stalls,
    /// Seed of the stalls, and of state without reset.
    pub seed: u64,
    /// Expected sticky flags at the end.
    pub flags: u64,
    /// Called now and then with the cycles since the last call.
    pub progress: &'a mut dyn FnMut(u64),
}

impl GatherUnit {
    /// Runs tasks through the unit from reset, and compares every cycle with the stepwise cycle
    /// model and every beat with `features` (or sums), in task and entry order.
    ///
    /// # Errors
    /// [`RtlError::Mismatch`] at the first difference; otherwise as [`GatherUnit::run`].
    pub fn check<T: Copy + Into<i32>>(
        &self,
        config: &Config,
        tasks: &[GatherTask],
        features: &[T],
        check: Check<'_>,
    ) -> Result<GatherTotals, RtlError> {
        let work = GatherWork::new(config, tasks)?;
        let expected = work.entries() as usize * work.channels();
        if features.len() != expected {
            return Err(lengths(features.len(), expected));
        }
        let mut watch = GatherCheck::new(config, &work, features, check.progress)?;
        let totals = self.watch(&work, &check.stalls, check.seed, DRAIN, &mut watch)?;
        flags(GATHERING_UNIT, totals.errors, check.flags, totals.cycles)?;
        Ok(totals)
    }

    /// As [`GatherUnit::check`], with the ports recorded in every clock. State without reset is
    /// drawn from `state`, whatever the seed of the stalls.
    ///
    /// # Errors
    /// Work that the unit cannot do, or an engine that cannot be started. The trace is returned
    /// with every other error.
    pub fn check_traced<T: Copy + Into<i32>>(
        &self,
        config: &Config,
        tasks: &[GatherTask],
        features: &[T],
        check: Check<'_>,
        state: u64,
    ) -> Result<Traced<GatherTotals>, RtlError> {
        let work = GatherWork::new(config, tasks)?;
        let expected = work.entries() as usize * work.channels();
        if features.len() != expected {
            return Err(lengths(features.len(), expected));
        }
        let mut watch = GatherCheck::new(config, &work, features, check.progress)?;
        let seeds = [check.seed, state];
        let run = self.watch_traced(&work, &check.stalls, seeds, DRAIN, &mut watch)?;
        Ok(run.and_then(|totals| {
            flags(GATHERING_UNIT, totals.errors, check.flags, totals.cycles)?;
            Ok(totals)
        }))
    }
}

impl GatherUnit {
    /// Repeats a check that failed in `cycle`, and dumps the window around it into a VCD file.
    /// Returns the time of that cycle in the file.
    ///
    /// # Errors
    /// Those of [`GatherUnit::check`], except the mismatch.
    pub fn excerpt<T: Copy + Into<i32>>(
        &self,
        config: &Config,
        tasks: &[GatherTask],
        features: &[T],
        check: Check<'_>,
        cycle: u64,
        path: &Path,
    ) -> Result<u64, RtlError> {
        let work = GatherWork::new(config, tasks)?;
        let watch = GatherCheck::new(config, &work, features, check.progress)?;
        let window = Window::around(cycle, path);
        let time = window.time();
        let done = self.dump(&work, &check.stalls, check.seed, DRAIN, watch, window);
        dumped(done.err(), time)
    }
}

impl VectorUnit {
    /// As [`GatherUnit::excerpt`].
    ///
    /// # Errors
    /// Those of [`VectorUnit::check`], except the mismatch.
    pub fn excerpt(
        &self,
        config: &Config,
        batches: &[VectorBatch<'_>],
        results: &[i32],
        check: Check<'_>,
        cycle: u64,
        path: &Path,
    ) -> Result<u64, RtlError> {
        let vectors = self.vectors(batches)?;
        let watch = VectorCheck::new(config, &vectors, results, check.progress)?;
        let window = Window::around(cycle, path);
        let time = window.time();
        let done = self.dump(&vectors, &check.stalls, check.seed, DRAIN, watch, window);
        dumped(done.err(), time)
    }
}

fn dumped(error: Option<RtlError>, time: u64) -> Result<u64, RtlError> {
    match error {
        None | Some(RtlError::Mismatch(_)) => Ok(time),
        Some(other) => Err(other),
    }
}

impl VectorUnit {
    /// Computes from reset, and compares every cycle with the stepwise cycle model and every result
    /// with `results`, batch after batch.
    ///
    /// # Errors
    /// [`RtlError::Mismatch`] at the first difference; otherwise as [`VectorUnit::run`].
    pub fn check(
        &self,
        config: &Config,
        batches: &[VectorBatch<'_>],
        results: &[i32],
        check: Check<'_>,
    ) -> Result<VectorTotals, RtlError> {
        let vectors = self.vectors(batches)?;
        if results.len() != vectors.elements() {
            return Err(lengths(results.len(), vectors.elements()));
        }
        let mut watch = VectorCheck::new(config, &vectors, results, check.progress)?;
        let totals = self.watch(&vectors, &check.stalls, check.seed, DRAIN, &mut watch)?;
        flags(VECTOR_UNIT, totals.errors, check.flags, totals.cycles)?;
        Ok(totals)
    }

    /// As [`GatherUnit::check_traced`].
    ///
    /// # Errors
    /// As [`GatherUnit::check_traced`].
    pub fn check_traced(
        &self,
        config: &Config,
        batches: &[VectorBatch<'_>],
        results: &[i32],
        check: Check<'_>,
        state: u64,
    ) -> Result<Traced<VectorTotals>, RtlError> {
        let vectors = self.vectors(batches)?;
        if results.len() != vectors.elements() {
            return Err(lengths(results.len(), vectors.elements()));
        }
        let mut watch = VectorCheck::new(config, &vectors, results, check.progress)?;
        let seeds = [check.seed, state];
        let run = self.watch_traced(&vectors, &check.stalls, seeds, DRAIN, &mut watch)?;
        Ok(run.and_then(|totals| {
            flags(VECTOR_UNIT, totals.errors, check.flags, totals.cycles)?;
            Ok(totals)
        }))
    }
}

fn lengths(found: usize, expected: usize) -> RtlError {
    RtlError::Usage(format!("{found} expected values: expected {expected}"))
}

/// Names of flags of the vector unit.
pub(super) fn vector_flags(flags: u64) -> impl Iterator<Item = String> {
    let names = [
        "an operation that was not built",
        "a reserved rounding code",
        "a lane with only some of its bytes kept",
        "an operand beyond its width (vu.operands)",
    ];
    let raised = names.into_iter().enumerate();
    raised
        .filter(move |(bit, _)| flags >> bit & 1 == 1)
        .map(|(_, name)| format!("raised: {name}"))
}

pub(super) fn flags(
    module: &'static str,
    found: u64,
    expected: u64,
    cycle: u64,
) -> Result<(), Box<Mismatch>> {
    if found == expected {
        return Ok(());
    }
    let mut place = "at the end of the run".to_owned();
    if module == VECTOR_UNIT {
        let raised = vector_flags(found & !expected);
        place = [place]
            .into_iter()
            .chain(raised)
            .collect::<Vec<_>>()
            .join(", ");
    }
    Err(Box::new(Mismatch {
        module,
        cycle,
        signal: "stat_errors".to_owned(),
        expected: format!("{expected:#010b}"),
        found: format!("{found:#010b}"),
        place,
    }))
}
