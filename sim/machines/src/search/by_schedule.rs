//! The best machines of a search by demand, judged by their schedule.
//!
//! A demand is a bound: machines that it cannot tell apart, such as those with more channels than the demand
//! needs, differ by their schedule, and so do the limits that they keep.

use std::cmp::Ordering;
use std::collections::HashSet;

use potamoi_explore::Progress;
use schemars::JsonSchema;
use serde::Serialize;

use super::{Search, Searched, Tried};
use crate::sweep::SweepError;
use crate::sweep::evaluation::Evaluation;
use crate::workload::{Fidelity, Workload};

/// Most machines of a search by demand that are evaluated again.
pub const CHECKED: usize = 16;

/// Machines that were evaluated again, by their schedule.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct BySchedule {
    /// The base.
    pub base: Tried,
    /// The best by demand, the best first.
    pub tried: Vec<Tried>,
}

impl BySchedule {
    /// The best of them, whether it keeps the limits or not.
    #[must_use]
    pub fn best(&self) -> Option<&Tried> {
        let all = self.tried.iter();
        all.reduce(|best, own| match own.is_better(best) {
            true => own,
            false => best,
        })
    }
}

/// Most points that [`checked`] evaluates, the base included.
pub(super) fn most(search: &Search<'_>, points: usize) -> usize {
    match search.workload.fidelity {
        Fidelity::Demand => 1 + points.min(CHECKED),
        Fidelity::Schedule => 0,
    }
}

/// Evaluates the best machines of a search by demand again.
pub(super) fn checked(
    search: &Search<'_>,
    mut searched: Searched,
    evaluation: &mut Evaluation,
    progress: &dyn Progress,
) -> Result<Searched, SweepError> {
    if search.workload.fidelity != Fidelity::Demand {
        return Ok(searched);
    }
    let mut best: Vec<&Tried> = searched.tried().filter(|own| own.has_figures()).collect();
    best.sort_by(|a, b| match (a.is_better(b), b.is_better(a)) {
        (true, _) => Ordering::Less,
        (_, true) => Ordering::Greater,
        _ => Ordering::Equal,
    });
    let mut known = HashSet::new();
    best.retain(|own| known.insert(&own.places));
    let places = best.iter().take(CHECKED).map(|own| own.places.clone());
    let places = places.collect();
    let own = Search {
        workload: Workload {
            fidelity: Fidelity::Schedule,
            ..search.workload
        },
        ..*search
    };
    searched.by_schedule = Some(BySchedule {
        base: own.base(evaluation, progress)?,
        tried: own.tried(places, evaluation, progress)?,
    });
    Ok(searched)
}
