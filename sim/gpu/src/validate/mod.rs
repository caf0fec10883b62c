//! Predictions beside measurements: errors, bias, spread, ablation.

use crate::programs::{CountError, Counts};
use crate::rows::{At, Measured, Row};
use crate::{Bounds, Term};

/// A prediction beside a measurement.
#[derive(Debug, Clone)]
pub struct Check {
    /// The measurement.
    pub measured: Measured,
    /// Predicted time at the likely counts.
    pub mid: Bounds,
    /// Fewest frames a second: no overlap, largest counts.
    pub slowest: f64,
    /// Most frames a second: whole overlap, least counts.
    pub fastest: f64,
    /// Prediction in frames a second with half of all counts.
    pub at_half: f64,
    /// Prediction in frames a second with twice all counts.
    pub at_twice: f64,
}

/// Bounds of a row at given counts, as if one term cost nothing.
fn bounds(row: &Row, counts: &Counts, without: Option<Term>) -> Result<Bounds, CountError> {
    let frame = row.program.frame(counts, &row.device)?;
    Ok(frame.bounds_without(&row.device, without))
}

/// Prediction in frames a second at the likely counts, with one count times a factor.
///
/// # Errors
///
/// [`CountError`], where the program refuses the counts.
pub fn with_one_count(row: &Row, name: &str, factor: f64) -> Result<f64, CountError> {
    let counts = row.times(factor, |own| own == name);
    Ok(1.0 / bounds(row, &counts, None)?.mid())
}

impl Check {
    /// Predicts what was measured.
    ///
    /// # Errors
    ///
    /// [`CountError`], where the program refuses the counts.
    pub fn of(measured: &Measured) -> Result<Self, CountError> {
        let row = &measured.row;
        let scaled = |factor| bounds(row, &row.times(factor, |_| true), None);
        Ok(Self {
            mid: bounds(row, &row.at(At::Mid), None)?,
            slowest: 1.0 / bounds(row, &row.at(At::High), None)?.sum.seconds,
            fastest: 1.0 / bounds(row, &row.at(At::Low), None)?.max.seconds,
            at_half: 1.0 / scaled(0.5)?.mid(),
            at_twice: 1.0 / scaled(2.0)?.mid(),
            measured: measured.clone(),
        })
    }

    /// The prediction in frames a second.
    #[must_use]
    pub fn frames_s(&self) -> f64 {
        1.0 / self.mid.mid()
    }

    /// Predicted over measured frames a second: above 1 is too fast.
    #[must_use]
    pub fn ratio(&self) -> f64 {
        self.frames_s() / self.measured.frames_s()
    }

    /// Whether the measurement lies between slowest and fastest.
    #[must_use]
    pub fn within_range(&self) -> bool {
        let measured = self.measured.frames_s();
        self.slowest <= measured && measured <= self.fastest
    }

    /// Whether the prediction is within twice and half of the measurement.
    #[must_use]
    pub fn within_twice(&self) -> bool {
        (0.5..=2.0).contains(&self.ratio())
    }
}

/// Errors over several rows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Summary {
    /// Rows.
    pub rows: usize,
    /// Geometric mean of the larger over the smaller of predicted and measured.
    pub error: f64,
    /// Geometric mean of predicted over measured frames a second: above 1 is too fast.
    pub bias: f64,
    /// Geometric mean error that remains about the bias.
    pub spread: f64,
    /// Largest error.
    pub worst: f64,
    /// Rows whose measurement lies within the full range.
    pub in_range: usize,
    /// Rows whose prediction is within twice.
    pub in_twice: usize,
}

impl Summary {
    /// Of ratios of predicted to measured, without ranges.
    #[must_use]
    pub fn of_ratios(ratios: &[f64]) -> Self {
        let logs: Vec<f64> = ratios.iter().map(|r| r.ln()).collect();
        let count = logs.len().max(1) as f64;
        let bias = logs.iter().sum::<f64>() / count;
        let mean = |from: f64| logs.iter().map(|l| (l - from).abs()).sum::<f64>() / count;
        let worst = logs.iter().map(|l| l.abs()).fold(0.0, f64::max);
        Self {
            rows: logs.len(),
            error: mean(0.0).exp(),
            bias: bias.exp(),
            spread: mean(bias).exp(),
            worst: worst.exp(),
            in_range: 0,
            in_twice: ratios.iter().filter(|r| (0.5..=2.0).contains(*r)).count(),
        }
    }

    /// Of checks.
    #[must_use]
    pub fn of<'a>(checks: impl IntoIterator<Item = &'a Check>) -> Self {
        let checks: Vec<&Check> = checks.into_iter().collect();
        let ratios: Vec<f64> = checks.iter().map(|c| c.ratio()).collect();
        Self {
            in_range: checks.iter().filter(|c| c.within_range()).count(),
            ..Self::of_ratios(&ratios)
        }
    }
}

/// Rows grouped by what two views need: devices and programs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum By {
    /// By device.
    Device,
    /// By program.
    Program,
}

impl By {
    fn key(self, check: &Check) -> String {
        let row = &check.measured.row;
        match self {
            Self::Device => row.device.name.clone(),
            Self::Program => row.program.name.to_owned(),
        }
    }
}

/// Of each device or program: its name, its rows alone, and all others without them.
#[must_use]
pub fn leave_one_out(checks: &[Check], by: By) -> Vec<(String, Summary, Summary)> {
    let mut keys: Vec<String> = checks.iter().map(|c| by.key(c)).collect();
    keys.sort();
    keys.dedup();
    let view = |key: String| {
        let own = Summary::of(checks.iter().filter(|c| by.key(c) == key));
        let others = Summary::of(checks.iter().filter(|c| by.key(c) != key));
        (key, own, others)
    };
    keys.into_iter().map(view).collect()
}

/// Errors of the rows as if each term in turn cost nothing.
///
/// # Errors
///
/// [`CountError`], where a program refuses its counts.
pub fn ablation(checks: &[Check]) -> Result<Vec<(Term, Summary)>, CountError> {
    let mut all = vec![];
    for term in Term::ALL {
        let mut ratios = vec![];
        for check in checks {
            let row = &check.measured.row;
            let bounds = bounds(row, &row.at(At::Mid), Some(term))?;
            ratios.push(1.0 / bounds.mid() / check.measured.frames_s());
        }
        all.push((term, Summary::of_ratios(&ratios)));
    }
    Ok(all)
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod page;
#[cfg(test)]
mod tests;
