//! Depth sorting.

use potamoi_gaussians::Cloud;

/// Bits sorted in one pass.
const DIGIT: u32 = 11;

/// Sorts (view depth, index) front to back; depths must be positive.
///
/// All 64 bits of a depth count: depths that differ only below 32-bit precision, which the
/// reference leaves in file order, are ordered correctly. Exact ties are broken by the values of
/// the Gaussians, not by their positions in the file, so that any permutation of the input gives
/// the same bits.
pub(crate) fn sort(cloud: &Cloud, depths: Vec<(f64, usize)>) -> Vec<(f64, usize)> {
    let mut sorted = radix(depths);
    for ties in sorted.chunk_by_mut(|a, b| a.0.to_bits() == b.0.to_bits()) {
        if ties.len() > 1 {
            ties.sort_by(|a, b| cloud.compare_content(a.1, b.1));
        }
    }
    sorted
}

/// Whether (view depth, index) are in the order of [`sort`].
pub(crate) fn is_sorted(cloud: &Cloud, depths: &[(f64, usize)]) -> bool {
    depths.is_sorted_by(|a, b| {
        let order = a.0.total_cmp(&b.0);
        order.then_with(|| cloud.compare_content(a.1, b.1)).is_le()
    })
}

/// Stable radix sort by depth, from the lowest digit in which any two differ.
fn radix(mut items: Vec<(f64, usize)>) -> Vec<(f64, usize)> {
    // Bits of positive doubles order as the doubles do.
    let low = items.iter().map(|i| i.0.to_bits()).min().unwrap_or(0);
    let high = items.iter().map(|i| i.0.to_bits()).max().unwrap_or(0);
    let bits = u64::BITS - (high - low).leading_zeros();
    let mut other = vec![(0.0, 0); items.len()];
    for shift in (0..bits).step_by(DIGIT as usize) {
        let digit =
            |item: &(f64, usize)| ((item.0.to_bits() - low) >> shift) as usize % (1 << DIGIT);
        let mut next = [0usize; 1 << DIGIT];
        for item in &items {
            next[digit(item)] += 1;
        }
        let mut sum = 0;
        for place in &mut next {
            sum += std::mem::replace(place, sum);
        }
        for item in &items {
            let place = &mut next[digit(item)];
            other[*place] = *item;
            *place += 1;
        }
        std::mem::swap(&mut items, &mut other);
    }
    items
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn ties_are_ordered_by_content_and_near_ties_truly() {
        let n = 5;
        let cloud = Cloud::new(
            0,
            (0..n).map(|i| [-(i as f32), 0.0, 0.0]).collect(),
            vec![[0.0; 3]; n],
            vec![[0.0; 4]; n],
            vec![0.0; n],
            vec![[0.0; 3]; n],
        )
        .unwrap();
        let d = 3.0f64;
        let depths = vec![(d.next_up(), 0), (d, 1), (d, 2), (d.next_down(), 3), (d, 4)];
        // The same in 32 bits. Of equal depths the smallest x is first.
        assert!(depths.iter().all(|i| i.0 as f32 == 3.0));
        let order: Vec<usize> = sort(&cloud, depths).iter().map(|i| i.1).collect();
        assert_eq!(order, [3, 4, 2, 1, 0]);
    }

    proptest! {
        /// A list is in order exactly if sorting does not change it, including ties by content.
        #[test]
        fn in_order_is_what_sorting_leaves(
            places in proptest::collection::vec((0u8..3, 0u8..3), 1..6),
        ) {
            let n = places.len();
            let cloud = Cloud::new(
                0,
                places.iter().map(|(_, x)| [f32::from(*x), 0.0, 0.0]).collect(),
                vec![[0.0; 3]; n],
                vec![[0.0; 4]; n],
                vec![0.0; n],
                vec![[0.0; 3]; n],
            )
            .unwrap();
            let depths: Vec<(f64, usize)> =
                places.iter().map(|(z, _)| f64::from(*z) + 1.0).zip(0..).collect();
            let key = |(z, i): &(f64, usize)| (*z as u8, places[*i].1);
            let keys = |all: &[(f64, usize)]| all.iter().map(key).collect::<Vec<_>>();
            let sorted = sort(&cloud, depths.clone());
            prop_assert!(keys(&sorted).is_sorted());
            prop_assert!(is_sorted(&cloud, &sorted));
            prop_assert_eq!(is_sorted(&cloud, &depths), keys(&depths) == keys(&sorted));
        }

        #[test]
        fn radix_is_a_stable_sort(
            depths in proptest::collection::vec(
                prop_oneof![0.01f64..0.02, 1e-3f64..1e39, Just(7.5), Just(f64::MIN_POSITIVE)],
                0..600,
            )
        ) {
            let items: Vec<(f64, usize)> = depths.into_iter().zip(0..).collect();
            let mut expected = items.clone();
            expected.sort_by(|a, b| a.0.total_cmp(&b.0));
            prop_assert_eq!(radix(items), expected);
        }
    }
}
