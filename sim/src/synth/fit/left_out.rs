//! How far off the formulas are at points that they were not fitted to.

use serde::Serialize;

use super::estimate::Work;
use super::formulas::Formulas;
use crate::synth::SynthError;
use crate::synth::grid::{Family, GridPoint};

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

/// Relative errors of a family.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct LeftOut {
    /// Of the unit's area.
    pub area: Spread,
    /// Of its longest path.
    pub period: Spread,
    /// Of its energy a cycle, each net changing at most once.
    pub zero_delay: Spread,
    /// The same with glitches.
    pub with_glitches: Spread,
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
    /// The largest of the roots of mean squares.
    #[must_use]
    pub fn largest_rms(&self) -> f64 {
        let all = [self.area, self.period, self.zero_delay, self.with_glitches];
        all.iter().fold(0.0, |most, spread| spread.rms.max(most))
    }

    pub(super) fn measure(family: Family, points: &[&GridPoint]) -> Result<Self, SynthError> {
        let mut found = vec![];
        for (at, left_out) in points.iter().enumerate() {
            let others = [&points[..at], &points[at + 1..]].concat();
            let config = left_out.config()?;
            let work = Work::of(&left_out.activity);
            let estimate = Formulas::fit(family, &others)?.at(&config, work);
            let area = estimate.area_um2 / left_out.area_um2() - 1.0;
            let period = estimate.period_ps / left_out.period_ps - 1.0;
            let [zero_delay, with_glitches] = left_out.energy();
            found.push([
                area,
                period,
                estimate.zero_delay_pj / zero_delay - 1.0,
                estimate.with_glitches_pj / with_glitches - 1.0,
            ]);
        }
        let spread = |figure: usize| Spread::new(found.iter().map(|errors| errors[figure]));
        Ok(Self {
            area: spread(0),
            period: spread(1),
            zero_delay: spread(2),
            with_glitches: spread(3),
        })
    }
}
