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
/// the line. Equal pictures, whose PSNR is infinite, are left out.
#[must_use]
pub fn knee(places: &[CostQuality], front: &[usize]) -> Option<usize> {
    let ends = |of: fn(&CostQuality) -> f64| {
        let finite = places.iter().filter(|p| p.quality.is_finite());
        finite.map(of).fold(None, |ends, v| {
            let (low, high): (f64, f64) = ends.unwrap_or((v, v));
            Some((low.min(v), high.max(v)))
        })
    };
    let (fast, slow) = ends(|p| p.cost)?;
    let (worst, best) = ends(|p| p.quality)?;
    if fast == slow || worst == best {
        return None;
    }
    let above = |i: &usize| {
        let CostQuality { cost, quality } = places[*i];
        (quality - worst) / (best - worst) - (cost - fast) / (slow - fast)
    };
    let finite = front.iter().filter(|i| places[**i].quality.is_finite());
    let knee = finite.max_by(|a, b| above(a).total_cmp(&above(b)))?;
    (above(knee) > 0.0).then_some(*knee)
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

    proptest! {
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
