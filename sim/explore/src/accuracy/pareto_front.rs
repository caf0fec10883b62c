//! Pareto front and its knee.

/// Cost and quality of a candidate; lower cost and higher quality are better.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CostQuality {
    /// Nanoseconds, millijoules or square millimetres.
    pub cost: f64,
    /// Quality, in dB.
    pub quality: f64,
}

impl CostQuality {
    /// Pareto dominance: at least as good in both, and better in one.
    fn beats(self, other: Self) -> bool {
        let as_good = self.cost <= other.cost && self.quality >= other.quality;
        as_good && (self.cost < other.cost || self.quality > other.quality)
    }
}

/// Quality in dB above which small differences count as none: no eye sees them, and formats scatter
/// by as much.
const FINE_DB: f64 = 60.0;
/// Smallest difference in dB that counts above it.
const LEAST_DB: f64 = 0.1;

/// Whether quality rises by so little, from so high, that it counts as equal.
fn is_equal(from: f64, to: f64) -> bool {
    from > FINE_DB && to - from < LEAST_DB
}

/// The Pareto front: indices of points that no other dominates, by rising cost; of equal points the
/// first.
#[must_use]
pub fn front(places: &[CostQuality]) -> Vec<usize> {
    let mut kept: Vec<usize> = (0..places.len())
        .filter(|i| {
            let own = places[*i];
            let is_beaten = places.iter().any(|other| other.beats(own));
            let is_again = places[..*i].contains(&own);
            !is_beaten && !is_again
        })
        .collect();
    kept.sort_by(|a, b| places[*a].cost.total_cmp(&places[*b].cost));
    kept
}

/// The knee of a front: the point farthest above the straight line from the worst quality of all
/// places to the best, over the range of costs (V. Satopaa et al., "Finding a 'Kneedle' in a
/// Haystack", ICDCSW 2011). `None` where all costs or all qualities are equal, or no point is above
/// the line. Equal pictures, whose PSNR is infinite, are left out. Differences below 0.1 dB make no
/// knee above 60 dB: a point that is better than a faster one by less counts as not there.
#[must_use]
pub fn knee(places: &[CostQuality], front: &[usize]) -> Option<usize> {
    let ends = |of: fn(&CostQuality) -> f64| {
        let finite = places.iter().filter(|p| p.quality.is_finite());
        finite.map(of).fold(None, |ends, v| {
            let (low, high): (f64, f64) = ends.unwrap_or((v, v));
            Some((low.min(v), high.max(v)))
        })
    };
    let mut kept: Vec<usize> = vec![];
    for i in front.iter().filter(|i| places[**i].quality.is_finite()) {
        let last = kept.last().map(|last| places[*last].quality);
        if last.is_none_or(|last| !is_equal(last, places[*i].quality)) {
            kept.push(*i);
        }
    }
    let (fast, slow) = ends(|p| p.cost)?;
    let (worst, _) = ends(|p| p.quality)?;
    let best = places[*kept.last()?].quality;
    if fast == slow || worst == best || is_equal(worst, best) {
        return None;
    }
    let above = |i: &usize| {
        let CostQuality { cost, quality } = places[*i];
        (quality - worst) / (best - worst) - (cost - fast) / (slow - fast)
    };
    let knee = kept
        .into_iter()
        .max_by(|a, b| above(a).total_cmp(&above(b)))?;
    (above(&knee) > 0.0).then_some(knee)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use proptest::prelude::*;

    fn places(of: &[(f64, f64)]) -> Vec<CostQuality> {
        let place = |&(cost, quality)| CostQuality { cost, quality };
        of.iter().map(place).collect()
    }

    #[test]
    fn beaten_points_are_not_on_the_front() {
        let all = places(&[
            (5.0, 40.0),
            (1.0, 10.0),
            (3.0, 40.0),
            (2.0, 9.0),
            (3.0, 40.0),
        ]);
        assert_eq!(front(&all), [1, 2]);
    }

    #[test]
    fn the_knee_is_where_more_time_buys_little() {
        let all = places(&[(1.0, 10.0), (2.0, 38.0), (3.0, 39.0), (10.0, 40.0)]);
        let kept = front(&all);
        assert_eq!(kept, [0, 1, 2, 3]);
        assert_eq!(knee(&all, &kept), Some(1));
        // A straight line has none, nor has a single place.
        let all = places(&[(1.0, 1.0), (2.0, 2.0), (3.0, 3.0)]);
        assert_eq!(knee(&all, &front(&all)), None);
        assert_eq!(knee(&all[..1], &[0]), None);
        assert_eq!(knee(&[], &[]), None);
        // The fastest that is nearly the best, though each step beyond buys more than the last.
        let all = places(&[(2.0, 38.0), (9.0, 38.5), (10.0, 40.0), (8.0, 10.0)]);
        assert_eq!(knee(&all, &front(&all)), Some(0));
        // What is slower than the best counts: nothing is bought beyond it.
        let all = places(&[(1.0, 10.0), (4.0, 12.0), (5.0, 40.0), (20.0, 39.0)]);
        assert_eq!(knee(&all, &front(&all)), Some(2));
        // Equal pictures for more time change nothing of it.
        let mut all = places(&[(1.0, 10.0), (2.0, 38.0), (3.0, 39.0), (10.0, 40.0)]);
        all.push(CostQuality {
            cost: 11.0,
            quality: f64::INFINITY,
        });
        assert_eq!(knee(&all, &front(&all)), Some(1));
    }

    /// The rule without a smallest difference.
    fn plain_knee(places: &[CostQuality], front: &[usize]) -> Option<usize> {
        let (mut costs, mut qualities) = ([f64::MAX, f64::MIN], [f64::MAX, f64::MIN]);
        for place in places {
            for (ends, v) in [(&mut costs, place.cost), (&mut qualities, place.quality)] {
                *ends = [ends[0].min(v), ends[1].max(v)];
            }
        }
        let part = |v: f64, [low, high]: [f64; 2]| (v - low) / (high - low);
        let above =
            |i: &&usize| part(places[**i].quality, qualities) - part(places[**i].cost, costs);
        let knee = front.iter().max_by(|a, b| above(a).total_cmp(&above(b)))?;
        (above(&knee) > 0.0).then_some(*knee)
    }

    /// `cost --scene lantern --knobs constant-bits`. Beside the picture in floating point, 0.56 dB at
    /// 100 dB were a knee; beside the converged picture these are 0.003 dB, and a knee by the rule
    /// without a smallest difference.
    #[test]
    fn widths_of_constants_have_no_knee_on_lantern() {
        // Microseconds, and dB beside either: the default, then 14, 16, 17 and 18 bits.
        let found = [
            (946.9, 99.709, 62.140),
            (994.1, 99.270, 62.135),
            (947.7, 100.265, 62.143),
            (892.0, 98.844, 62.139),
            (946.1, 99.926, 62.141),
        ];
        let float = places(&found.map(|(us, float, _)| (us, float)));
        let converged = places(&found.map(|(us, _, converged)| (us, converged)));
        assert_eq!(plain_knee(&float, &front(&float)), Some(2));
        assert_eq!(plain_knee(&converged, &front(&converged)), Some(3));
        assert_eq!(knee(&converged, &front(&converged)), None);
    }

    /// Qualities in quarters of a decibel, up to 100 dB.
    fn quarters(all: &[(u32, u32)]) -> Vec<CostQuality> {
        let of = |(c, q): &(u32, u32)| (f64::from(*c), 0.25 * f64::from(*q));
        places(&all.iter().map(of).collect::<Vec<_>>())
    }

    proptest! {
        /// What is better by less than 0.1 dB, from above 60 dB, makes no knee.
        #[test]
        fn what_nobody_sees_makes_no_knee(
            all in prop::collection::vec((1u32..1000, 0u32..1000), 2..40), best in 60.2f64..110.0
        ) {
            let of = |(cost, part): &(u32, u32)| {
                (f64::from(*cost), best - 1e-4 * f64::from(*part))
            };
            let all = places(&all.iter().map(of).collect::<Vec<_>>());
            prop_assert_eq!(knee(&all, &front(&all)), None);
        }

        /// Another point, slower than the best and better by less, is not the knee and moves none.
        #[test]
        fn what_nobody_sees_moves_no_knee(
            all in prop::collection::vec((0u32..200, 0u32..400), 2..40),
            share in 0.01f64..0.99, more in 0.001f64..0.099
        ) {
            let mut all = quarters(&all);
            let kept = front(&all);
            let found = knee(&all, &kept);
            let best = all[kept[kept.len() - 1]];
            let slow = all.iter().map(|p| p.cost).fold(0.0, f64::max);
            prop_assume!(best.quality > FINE_DB && slow > best.cost);
            all.push(CostQuality {
                cost: best.cost + share * (slow - best.cost),
                quality: best.quality + more,
            });
            let kept = front(&all);
            prop_assert_eq!(kept.last(), Some(&(all.len() - 1)));
            prop_assert_eq!(knee(&all, &kept), found);
        }

        /// The rule is the published one where no difference is small.
        #[test]
        fn differences_that_count_make_the_published_knee(
            all in prop::collection::vec((0u32..200, 0u32..400), 2..40)
        ) {
            let all = quarters(&all);
            let kept = front(&all);
            prop_assert_eq!(knee(&all, &kept), plain_knee(&all, &kept));
        }

        #[test]
        fn every_point_is_on_the_front_or_beaten_by_one_of_it(
            all in prop::collection::vec((0u32..20, 0u32..20), 1..40)
        ) {
            let all: Vec<CostQuality> = all.iter().map(|(c, q)| CostQuality {
                cost: 0.125 * f64::from(*c), quality: 0.125 * f64::from(*q),
            }).collect();
            let kept = front(&all);
            for (i, own) in all.iter().enumerate() {
                let is_kept = kept.contains(&i);
                let is_covered = kept.iter().any(|k| all[*k].beats(*own) || all[*k] == *own);
                prop_assert!(is_kept || is_covered);
            }
            for pair in kept.windows(2) {
                prop_assert!(all[pair[0]].cost < all[pair[1]].cost);
                prop_assert!(all[pair[0]].quality < all[pair[1]].quality);
            }
        }
    }
}
