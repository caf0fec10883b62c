//! Local search: the lowest cost at a quality, or the best quality within a budget.

use std::collections::{HashMap, HashSet};

use super::pareto_front::CostQuality;

/// Goal of a search.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Goal {
    /// The lowest cost at this quality in dB or more.
    Quality(f64),
    /// The best quality at this cost or less.
    Budget(f64),
}

impl Goal {
    fn is_met(self, place: CostQuality) -> bool {
        match self {
            Self::Quality(least) => place.quality >= least,
            Self::Budget(most) => place.cost <= most,
        }
    }

    /// Whether `own` is preferred to `other`. Places that meet the goal come first; of two that
    /// miss it, the nearer one.
    fn prefers(self, own: CostQuality, other: CostQuality) -> bool {
        match (self.is_met(own), self.is_met(other)) {
            (true, false) => true,
            (false, true) => false,
            (met, _) => {
                let cheaper = own.cost < other.cost
                    || (own.cost == other.cost && own.quality > other.quality);
                let better = own.quality > other.quality
                    || (own.quality == other.quality && own.cost < other.cost);
                match self {
                    Self::Quality(_) if met => cheaper,
                    Self::Quality(_) => better,
                    Self::Budget(_) if met => better,
                    Self::Budget(_) => cheaper,
                }
            }
        }
    }
}

impl Goal {
    /// The next place among those reachable by one knob. While over budget, it is the one with the
    /// highest saving per quality lost, so that no knob is turned all the way at once. Otherwise it
    /// is the one preferred to all others.
    fn next(
        self,
        stands: CostQuality,
        reached: Vec<(Choice, CostQuality)>,
    ) -> Option<(Choice, CostQuality)> {
        let ahead = reached
            .into_iter()
            .filter(|(_, at)| self.prefers(*at, stands));
        let is_over = matches!(self, Self::Budget(_)) && !self.is_met(stands);
        let worth =
            |at: CostQuality| (stands.cost - at.cost) / (stands.quality - at.quality).max(1e-9);
        ahead.reduce(|best, own| {
            let is_better = match is_over {
                true => worth(own.1) > worth(best.1),
                false => self.prefers(own.1, best.1),
            };
            if is_better { own } else { best }
        })
    }
}

/// Source of a path variant's quality relative to full frames.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Paths {
    /// Counted on the path with all settings.
    Counted,
    /// Taken from the path with default settings, where that was counted.
    AsAlone,
}

/// Settings that alone miss a quality by more than this, in dB, are tried in no combination.
const HOPELESS: f64 = 1.0;

/// The setting of each knob; `None` for the default.
pub type Choice = Vec<Option<usize>>;

/// A knob, and one of its settings or the default's.
type Turn = (usize, Option<usize>);

/// The choice of settings that a goal prefers, with its place and whether it meets the goal; `None`
/// where the default has no place. Path variants are first taken with the quality they have alone.
/// The result is then measured on its own path; if it misses the goal, the search is repeated with
/// all choices measured.
///
/// `settings` has the number of each knob's settings. `place` measures a choice, or returns `None`
/// if it is invalid. `reach` is called for every choice on the way that meets the goal and is
/// preferred to those before.
///
/// # Errors
/// Those of `place` and `reach`.
pub fn search_by_ways_alone<E>(
    goal: Goal,
    settings: &[usize],
    mut place: impl FnMut(&Choice, Paths) -> Result<Option<CostQuality>, E>,
    mut reach: impl FnMut(&Choice) -> Result<(), E>,
) -> Result<Option<(Choice, CostQuality, bool)>, E> {
    let alone = |chosen: &Choice| place(chosen, Paths::AsAlone);
    let found = search(goal, settings, alone, &mut reach)?;
    let Some((chosen, _, true)) = found else {
        return Ok(found);
    };
    let counted = place(&chosen, Paths::Counted)?;
    match counted.filter(|at| goal.is_met(*at)) {
        Some(at) => Ok(Some((chosen, at, true))),
        None => search(goal, settings, |own| place(own, Paths::Counted), reach),
    }
}

/// Turns one knob at a time, as [`Goal::next`] says, until no turn is preferred. If a single
/// setting alone is preferred to the result, the search restarts there. Settings that alone miss a
/// quality are tried in combinations only where no other turn helps, as they seldom meet it; those
/// that miss it by more than [`HOPELESS`] are not tried at all. Arguments are those of
/// [`search_by_ways_alone`]. Returns the final choice, and whether it meets the goal.
fn search<E>(
    goal: Goal,
    settings: &[usize],
    place: impl FnMut(&Choice) -> Result<Option<CostQuality>, E>,
    reach: impl FnMut(&Choice) -> Result<(), E>,
) -> Result<Option<(Choice, CostQuality, bool)>, E> {
    let mut places = Places {
        known: HashMap::new(),
        place,
        best: None,
        reach,
    };
    let default: Choice = vec![None; settings.len()];
    let Some(start) = places.at(goal, &default)? else {
        return Ok(None);
    };
    let turns: Vec<Turn> = (settings.iter().enumerate())
        .flat_map(|(knob, count)| (0..=*count).map(move |s| (knob, s.checked_sub(1))))
        .collect();
    let mut alone = vec![];
    for (knob, setting) in &turns {
        let mut chosen = default.clone();
        chosen[*knob] = *setting;
        let found = places.at(goal, &chosen)?;
        alone.extend(found.map(|found| ((*knob, *setting), chosen, found)));
    }
    let is_hopeless = |found: &CostQuality| matches!(goal, Goal::Quality(least) if found.quality < least - HOPELESS);
    let hopeless: HashSet<Turn> = (alone.iter())
        .filter(|(.., found)| is_hopeless(found))
        .map(|(turn, ..)| *turn)
        .collect();
    let mut found = climb(goal, &turns, &hopeless, (default, start), &mut places)?;
    let best = alone.into_iter().map(|(_, chosen, at)| (chosen, at));
    let best = best.reduce(|best, own| match goal.prefers(own.1, best.1) {
        true => own,
        false => best,
    });
    if let Some(best) = best.filter(|best| goal.prefers(best.1, found.1)) {
        found = climb(goal, &turns, &hopeless, best, &mut places)?;
    }
    let (own, stands) = found;
    Ok(Some((own, stands, goal.is_met(stands))))
}

/// Measured places of choices, each measured once.
struct Places<F, R> {
    known: HashMap<Choice, Option<CostQuality>>,
    place: F,
    /// The best that meets the goal.
    best: Option<CostQuality>,
    reach: R,
}

impl<F, R> Places<F, R> {
    fn at<E>(&mut self, goal: Goal, chosen: &Choice) -> Result<Option<CostQuality>, E>
    where
        F: FnMut(&Choice) -> Result<Option<CostQuality>, E>,
        R: FnMut(&Choice) -> Result<(), E>,
    {
        if let Some(place) = self.known.get(chosen) {
            return Ok(*place);
        }
        let found = (self.place)(chosen)?;
        self.known.insert(chosen.clone(), found);
        let met = found.filter(|found| goal.is_met(*found));
        if let Some(met) = met.filter(|met| self.best.is_none_or(|best| goal.prefers(*met, best))) {
            self.best = Some(met);
            (self.reach)(chosen)?;
        }
        Ok(found)
    }
}

/// Last known saving of a turn; infinite for one that was never tried, so that it comes first.
fn last_saved(saved: &HashMap<Turn, f64>, turn: &Turn) -> f64 {
    saved.get(turn).copied().unwrap_or(f64::INFINITY)
}

/// Climbs from a choice, turn by turn. While a quality is held, turns are tried in the order of
/// their last known savings, largest first, until no remaining one saved more than the best now
/// does. Where no turn helps, all are tried before it ends.
fn climb<E, F, R>(
    goal: Goal,
    turns: &[Turn],
    hopeless: &HashSet<Turn>,
    (mut own, mut stands): (Choice, CostQuality),
    places: &mut Places<F, R>,
) -> Result<(Choice, CostQuality), E>
where
    F: FnMut(&Choice) -> Result<Option<CostQuality>, E>,
    R: FnMut(&Choice) -> Result<(), E>,
{
    let mut missed = hopeless.clone();
    let mut saved: HashMap<Turn, f64> = HashMap::new();
    let mut is_whole = false;
    loop {
        if is_whole {
            missed.clone_from(hopeless);
        }
        let holds = matches!(goal, Goal::Quality(_)) && goal.is_met(stands);
        let mut tried: Vec<Turn> = turns.to_vec();
        tried.retain(|turn| !missed.contains(turn));
        tried.sort_by(|a, b| last_saved(&saved, b).total_cmp(&last_saved(&saved, a)));
        let (mut reached, mut most) = (vec![], 0.0);
        for turn in tried {
            if holds && !is_whole && last_saved(&saved, &turn) <= most {
                break;
            }
            let mut turned = own.clone();
            turned[turn.0] = turn.1;
            let found = places.at(goal, &turned)?;
            let may_help = match (goal, found) {
                (_, None) => false,
                (Goal::Quality(_), Some(found)) => goal.is_met(found),
                (Goal::Budget(_), Some(_)) => true,
            };
            let saves = found.map_or(0.0, |found| stands.cost - found.cost);
            saved.insert(turn, saves);
            if may_help {
                most = f64::max(most, saves);
            } else {
                missed.insert(turn);
            }
            reached.extend(found.map(|found| (turned, found)));
        }
        match goal.next(stands, reached) {
            Some((turned, found)) => {
                (own, stands) = (turned, found);
                is_whole = false;
            }
            None if is_whole => return Ok((own, stands)),
            None => is_whole = true,
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use proptest::prelude::*;

    /// Knobs with additive costs and losses; the last setting of the second is invalid.
    fn place(chosen: &Choice) -> Result<Option<CostQuality>, ()> {
        const COST: [[f64; 3]; 2] = [[10.0, 6.0, 1.0], [5.0, 2.0, 0.0]];
        const LOSS: [[f64; 3]; 2] = [[0.0, 0.5, 20.0], [0.0, 0.1, 0.0]];
        let at = |knob: usize| chosen[knob].map_or(0, |s| s + 1);
        if at(1) == 2 {
            return Ok(None);
        }
        Ok(Some(CostQuality {
            cost: COST[0][at(0)] + COST[1][at(1)],
            quality: 40.0 - LOSS[0][at(0)] - LOSS[1][at(1)],
        }))
    }

    #[test]
    fn the_cheapest_that_holds_is_found() {
        let found = |goal| {
            let mut last = None;
            let reach = |chosen: &Choice| {
                last = Some(chosen.clone());
                Ok(())
            };
            let found = search(goal, &[2, 2], place, reach).unwrap().unwrap();
            // Whoever stops it has what it would have ended with, or nothing.
            assert_eq!(last, found.2.then(|| found.0.clone()));
            found
        };
        let (chosen, at, met) = found(Goal::Quality(39.0));
        assert_eq!((chosen, at.cost, met), (vec![Some(0), Some(0)], 8.0, true));
        let (chosen, at, met) = found(Goal::Quality(39.7));
        assert_eq!((chosen, at.cost, met), (vec![None, Some(0)], 12.0, true));
        let (_, at, met) = found(Goal::Quality(41.0));
        assert_eq!((at.quality, met), (40.0, false));
        let (_, at, met) = found(Goal::Budget(9.0));
        assert_eq!((at.quality, at.cost, met), (39.4, 8.0, true));
        let (_, at, met) = found(Goal::Budget(2.0));
        assert_eq!((at.cost, met), (3.0, false));
    }

    /// Both knobs lose more together than alone: a choice that misses the goal is then not
    /// returned.
    #[test]
    fn what_is_found_meets_the_goal_by_its_own_path() {
        let mut counted = 0;
        let mut found = |goal, more: f64| {
            let place = |chosen: &Choice, paths: Paths| -> Result<Option<CostQuality>, ()> {
                let are_both = chosen.iter().all(Option::is_some);
                counted += u32::from(paths == Paths::Counted);
                let lost = match paths {
                    Paths::Counted if are_both => more,
                    _ => 0.0,
                };
                let at = place(chosen)?;
                Ok(at.map(|at| CostQuality {
                    quality: at.quality - lost,
                    ..at
                }))
            };
            let found = search_by_ways_alone(goal, &[2, 2], place, |_| Ok(()));
            let (chosen, at, met) = found.unwrap().unwrap();
            (chosen, at.quality, met, std::mem::take(&mut counted))
        };
        let both = vec![Some(0), Some(0)];
        assert_eq!(
            found(Goal::Quality(39.0), 0.25),
            (both, 39.15, true, 1),
            "once, for what was found"
        );
        let (chosen, quality, met, counted) = found(Goal::Quality(39.3), 0.25);
        assert_eq!((chosen, quality, met), (vec![Some(0), None], 39.5, true));
        assert!(counted > 1);
        let (.., met, counted) = found(Goal::Quality(41.0), 0.25);
        assert_eq!((met, counted), (false, 0));
    }

    /// Ten knobs of four settings with additive savings: each is turned fully, with few trials
    /// beyond single settings and a final pass.
    #[test]
    fn turns_that_saved_little_wait() {
        let mut tried = 0;
        let place = |chosen: &Choice| -> Result<Option<CostQuality>, ()> {
            tried += u32::from(chosen.iter().flatten().count() > 1);
            let turned = chosen.iter().enumerate();
            let saved = turned.map(|(knob, s)| s.map_or(0, |s| (knob + 1) * (s + 1)));
            Ok(Some(CostQuality {
                cost: 1000.0 - saved.sum::<usize>() as f64,
                quality: 40.0,
            }))
        };
        let goal = Goal::Quality(39.0);
        let (chosen, ..) = search(goal, &[4; 10], place, |_| Ok(())).unwrap().unwrap();
        assert_eq!(chosen, [Some(3); 10]);
        assert!(tried < 90, "{tried}");
    }

    proptest! {
        /// Random costs and qualities: the search ends, no single turn improves its result, and no
        /// single setting is preferred to it.
        #[test]
        fn no_knob_alone_is_preferred_to_what_is_found(
            all in prop::collection::vec((0u32..50, 0u32..50), 64), least in 0u32..50
        ) {
            let place = |chosen: &Choice| -> Result<Option<CostQuality>, ()> {
                let at = chosen.iter().fold(0, |at, s| 4 * at + s.map_or(0, |s| s + 1));
                let (cost, quality) = all[at];
                Ok(Some(CostQuality { cost: f64::from(cost), quality: f64::from(quality) }))
            };
            for goal in [Goal::Quality(f64::from(least)), Goal::Budget(f64::from(least))] {
                let (own, at, met) = search(goal, &[3, 3, 3], place, |_| Ok(())).unwrap().unwrap();
                prop_assert_eq!(met, goal.is_met(at));
                for knob in 0..3 {
                    for setting in [None, Some(0), Some(1), Some(2)] {
                        let mut alone = vec![None; 3];
                        alone[knob] = setting;
                        let by_itself = place(&alone).unwrap().unwrap();
                        prop_assert!(!goal.prefers(by_itself, at));
                        let quality = by_itself.quality;
                        if matches!(goal, Goal::Quality(least) if quality < least - HOPELESS) {
                            continue;
                        }
                        let mut turned = own.clone();
                        turned[knob] = setting;
                        prop_assert!(!goal.prefers(place(&turned).unwrap().unwrap(), at));
                    }
                }
            }
        }
    }
}
