//! The depth order of Gaussians in slots.

use rayon::prelude::*;

use super::splats::CHUNK;
use potamoi_gaussians::Cloud;

/// Bits sorted in one pass.
const DIGIT: u32 = 11;
/// Bits of the sorted part of a depth.
const KEY: u32 = 32;

/// The slots of all Gaussians, front to back, in the order of [`depth::sort`](crate::depth::sort):
/// by all 64 bits of their depths, and by their values where depths are equal.
///
/// A key is the upper part of a depth's bits above the smallest depth's. Keys are sorted digit by digit;
/// whole depths are compared only where keys are equal. `index` is that of a slot's Gaussian in the cloud.
pub(super) fn front_to_back(
    cloud: &Cloud,
    depths: &[Vec<f64>],
    index: impl Fn(u32) -> usize,
) -> Vec<u32> {
    // Bits of positive doubles order as the doubles do.
    let bits = || {
        depths
            .par_iter()
            .flat_map_iter(|own| own.iter().map(|d| d.to_bits()))
    };
    let low = bits().min().unwrap_or(0);
    let high = bits().max().unwrap_or(0);
    let used = u64::BITS - (high - low).leading_zeros();
    let dropped = used.saturating_sub(KEY);
    let count = depths.iter().map(Vec::len).sum();
    let mut items: Vec<u64> = Vec::with_capacity(count);
    for (slot, depth) in slots(depths) {
        items.push((depth.to_bits() - low) >> dropped << KEY | u64::from(slot));
    }
    let mut items = radix(items, used.min(KEY));
    let whole = |item: u64| {
        let slot = item as u32 as usize;
        (depths[slot / CHUNK][slot % CHUNK], index(item as u32))
    };
    for ties in items.chunk_by_mut(|a, b| a >> KEY == b >> KEY) {
        if ties.len() > 1 {
            ties.sort_by(|a, b| {
                let [(a, i), (b, j)] = [*a, *b].map(whole);
                a.total_cmp(&b).then_with(|| cloud.compare_content(i, j))
            });
        }
    }
    items.into_iter().map(|item| item as u32).collect()
}

/// The slots of all Gaussians in the order of the cloud.
pub(super) fn as_stored(depths: &[Vec<f64>]) -> Vec<u32> {
    slots(depths).map(|(slot, _)| slot).collect()
}

/// Each slot, with the depth of its Gaussian.
fn slots(depths: &[Vec<f64>]) -> impl Iterator<Item = (u32, f64)> {
    depths.iter().enumerate().flat_map(|(chunk, own)| {
        let first = (chunk * CHUNK) as u32;
        own.iter().zip(first..).map(|(depth, slot)| (slot, *depth))
    })
}

/// Stable radix sort by the upper half, of which the lowest `bits` are used.
fn radix(mut items: Vec<u64>, bits: u32) -> Vec<u64> {
    let mut other = vec![0; items.len()];
    for shift in (0..bits).step_by(DIGIT as usize) {
        let digit = |item: u64| (item >> (KEY + shift)) as usize % (1 << DIGIT);
        let mut next = [0usize; 1 << DIGIT];
        for item in &items {
            next[digit(*item)] += 1;
        }
        let mut sum = 0;
        for place in &mut next {
            sum += std::mem::replace(place, sum);
        }
        for item in &items {
            let place = &mut next[digit(*item)];
            other[*place] = *item;
            *place += 1;
        }
        std::mem::swap(&mut items, &mut other);
    }
    items
}
