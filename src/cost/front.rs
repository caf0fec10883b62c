//! Which points no other beats, and where the front bends.

/// What is compared: less time and more quality are better.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Place {
    /// Nanoseconds, or any other cost.
    pub(super) cost: f64,
    /// Decibels, or any other quality.
    pub(super) quality: f64,
}

impl Place {
    /// Whether it is as good in both, and better in one.
    fn beats(self, other: Self) -> bool {
        let as_good = self.cost <= other.cost && self.quality >= other.quality;
        as_good && (self.cost < other.cost || self.quality > other.quality)
    }
}

/// The Pareto front: points that no other beats, by rising cost; of equal ones the first.
pub(super) fn front(places: &[Place]) -> Vec<usize> {
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

/// The knee of a front: the point farthest above the line between its ends, both axes scaled to
/// 1 (V. Satopaa et al., "Finding a 'Kneedle' in a Haystack", ICDCSW 2011); none where it has
/// no bend. Equal pictures, whose quality has no number, are no end of that line.
pub(super) fn knee(places: &[Place], front: &[usize]) -> Option<usize> {
    let finite = front.iter().filter(|i| places[**i].quality.is_finite());
    let front: Vec<usize> = finite.copied().collect();
    let [first, .., last] = front[..] else {
        return None;
    };
    let (low, high) = (places[first], places[last]);
    let scale = |of: Place| {
        let x = (of.cost - low.cost) / (high.cost - low.cost);
        let y = (of.quality - low.quality) / (high.quality - low.quality);
        y - x
    };
    let above = |i: &&usize| scale(places[**i]);
    let best = front.iter().max_by(|a, b| above(a).total_cmp(&above(b)))?;
    (scale(places[*best]) > 0.0).then_some(*best)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use proptest::prelude::*;

    fn places(of: &[(f64, f64)]) -> Vec<Place> {
        let place = |&(cost, quality)| Place { cost, quality };
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
        // A straight line has none, nor have two points.
        let all = places(&[(1.0, 1.0), (2.0, 2.0), (3.0, 3.0)]);
        assert_eq!(knee(&all, &front(&all)), None);
        assert_eq!(knee(&all[..2], &[0, 1]), None);
        // Equal pictures for more time change nothing of it.
        let mut all = places(&[(1.0, 10.0), (2.0, 38.0), (3.0, 39.0), (10.0, 40.0)]);
        all.push(Place {
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
            let all: Vec<Place> = all.iter().map(|(c, q)| Place {
                cost: f64::from(*c), quality: f64::from(*q),
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
