//! How far off the formulas are at points that they were not fitted to.

use serde::Serialize;

use super::estimate::{Estimate, Work};
use super::formulas::Formulas;
use crate::SynthError;
use crate::grid::{Family, GridPoint};

/// Relative errors of one figure, over points that were left out one at a time.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Spread {
    /// How many points there are.
    pub points: usize,
    /// Root of the mean of their squares.
    pub rms: f64,
    /// The largest, without its sign.
    pub worst: f64,
}

/// Relative errors of one point, which the formulas were fitted without.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PointErrors {
    /// What it has in place of the defaults.
    pub point: String,
    /// Of the unit's area.
    pub area: f64,
    /// Of its longest path.
    pub period: f64,
    /// Of its energy a cycle, each net changing at most once.
    pub zero_delay: f64,
    /// The same with glitches.
    pub with_glitches: f64,
    /// Of its leakage.
    pub leakage: f64,
}

/// Relative errors of a family.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LeftOut {
    /// Of each point.
    pub points: Vec<PointErrors>,
    /// Of the unit's area.
    pub area: Spread,
    /// Of its longest path.
    pub period: Spread,
    /// Of its energy a cycle, each net changing at most once.
    pub zero_delay: Spread,
    /// The same with glitches.
    pub with_glitches: Spread,
    /// Of its leakage.
    pub leakage: Spread,
}

impl PointErrors {
    pub(super) fn new(point: &GridPoint, found: &Estimate) -> Self {
        let [zero_delay, with_glitches] = point.energy();
        let leakage: f64 = point.modules.iter().map(|m| m.energy.leakage_nw).sum();
        Self {
            point: point.name(),
            area: found.area_um2 / point.area_um2() - 1.0,
            period: found.period_ps / point.period_ps - 1.0,
            zero_delay: found.zero_delay_pj / zero_delay - 1.0,
            with_glitches: found.with_glitches_pj / with_glitches - 1.0,
            leakage: found.leakage_nw / leakage - 1.0,
        }
    }
}

impl Spread {
    fn new(errors: impl Iterator<Item = f64>) -> Self {
        let errors: Vec<_> = errors.collect();
        let squares: f64 = errors.iter().map(|e| e * e).sum();
        Self {
            points: errors.len(),
            rms: (squares / errors.len().max(1) as f64).sqrt(),
            worst: errors.iter().fold(0.0, |worst, e| e.abs().max(worst)),
        }
    }
}

impl LeftOut {
    /// The largest of the roots of mean squares, leakage not counted.
    #[must_use]
    pub fn largest_rms(&self) -> f64 {
        let all = [self.area, self.period, self.zero_delay, self.with_glitches];
        all.iter().fold(0.0, |most, spread| spread.rms.max(most))
    }

    pub(super) fn measure(family: Family, points: &[&GridPoint]) -> Result<Self, SynthError> {
        let mut found = vec![];
        for (at, left_out) in points.iter().enumerate() {
            let others = [&points[..at], &points[at + 1..]].concat();
            let work = Work::of(&left_out.activity);
            let formulas = Formulas::fit(family, &others)?;
            let estimate = formulas.at(&left_out.config()?, work);
            found.push(PointErrors::new(left_out, &estimate));
        }
        let spread = |of: fn(&PointErrors) -> f64| Spread::new(found.iter().map(of));
        Ok(Self {
            area: spread(|e| e.area),
            period: spread(|e| e.period),
            zero_delay: spread(|e| e.zero_delay),
            with_glitches: spread(|e| e.with_glitches),
            leakage: spread(|e| e.leakage),
            points: found,
        })
    }
}
