//! Interpolation weights, U1.W, that sum to exactly 1.
//!
//! Weights rounded one by one do not sum to 1, and a constant field does not come back. Here a sum
//! is split instead: `s` into `s - hi` and `hi`, with `hi = floor(s u + 1/2)`, one axis at a time,
//! the last axis first. This takes six multiplications a sample, shared by all channels.

/// Fraction bits of a position inside a cell, U1.12.
pub const FRACTION_BITS: u32 = 12;

/// Splits each of the first `count` sums in two, in place.
fn split(sums: &mut [u16], count: usize, fraction: u16) {
    let fraction = u32::from(fraction).min(1 << FRACTION_BITS);
    for i in (0..count).rev() {
        let s = u32::from(sums[i]);
        let hi = (s * fraction + (1 << (FRACTION_BITS - 1))) >> FRACTION_BITS;
        sums[2 * i] = (s - hi) as u16;
        sums[2 * i + 1] = hi as u16;
    }
}

fn one(weight_bits: u32) -> u16 {
    1 << weight_bits.min(15)
}

/// Weights of the two ends of an edge, U1.W with `W = weight_bits` of at most 15. `u` is the U1.12
/// position along the edge; values above 1 count as 1.
#[must_use]
pub fn linear(u: u16, weight_bits: u32) -> [u16; 2] {
    let mut sums = [one(weight_bits), 0];
    split(&mut sums, 1, u);
    sums
}

/// Weights of a face's corners; bit 0 of the corner's index is x, bit 1 y.
/// Otherwise as [`linear`].
#[must_use]
pub fn bilinear([x, y]: [u16; 2], weight_bits: u32) -> [u16; 4] {
    let mut sums = [one(weight_bits), 0, 0, 0];
    split(&mut sums, 1, y);
    split(&mut sums, 2, x);
    sums
}

/// Weights of a cell's corners; bit 0 of the corner's index is x, bit 1 y,
/// bit 2 z. Otherwise as [`linear`].
#[must_use]
pub fn trilinear([x, y, z]: [u16; 3], weight_bits: u32) -> [u16; 8] {
    let mut sums = [one(weight_bits), 0, 0, 0, 0, 0, 0, 0];
    split(&mut sums, 1, z);
    split(&mut sums, 2, y);
    split(&mut sums, 4, x);
    sums
}

/// The fractions along x, y and z whose split tree yields the first `count` of `weights`: the
/// content of a compact RIT entry. Axes that do not exist get 0. If several fractions yield the
/// same weights, as with few bits, the lowest are returned; `None` if there are none.
#[must_use]
pub fn fractions(weights: &[u16; 8], count: usize, weight_bits: u32) -> Option<[u16; 3]> {
    let mut sums = weights.map(u32::from);
    let mut found = [0; 3];
    let mut pairs = count / 2;
    // The splits backwards: x, then y, then z.
    for fraction in found.iter_mut().take(count.ilog2() as usize) {
        let (mut least, mut most) = (0, 1u32 << FRACTION_BITS);
        for pair in sums[..2 * pairs].chunks_exact(2) {
            let (high, sum) = (pair[1], pair[0] + pair[1]);
            if sum == 0 {
                continue;
            }
            // high <= sum u + 1/2 < high + 1, in units of 2^-12.
            let half = 1 << (FRACTION_BITS - 1);
            let low = (high << FRACTION_BITS).saturating_sub(half).div_ceil(sum);
            let past = ((high + 1) << FRACTION_BITS)
                .saturating_sub(half)
                .div_ceil(sum);
            (least, most) = (least.max(low), most.min(past.checked_sub(1)?));
        }
        if least > most {
            return None;
        }
        *fraction = least as u16;
        for i in 0..pairs {
            sums[i] = sums[2 * i] + sums[2 * i + 1];
        }
        pairs /= 2;
    }
    (sums[0] == u32::from(one(weight_bits))).then_some(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Halves go up: half of an odd weight is the larger half at the far end.
    #[test]
    fn a_tie_goes_to_the_far_end() {
        let half = 1 << (FRACTION_BITS - 1);
        let mut sums = [15, 0];
        split(&mut sums, 1, half);
        assert_eq!(sums, [7, 8], "15 at one half is 7.5: rounded half up");
        let mut sums = [1 << 4, 0];
        split(&mut sums, 1, 128);
        assert_eq!(sums, [15, 1], "16 at 1/32 is 0.5: rounded half up");
    }

    /// Every split tree, in every width; invalid weights have no fractions.
    #[test]
    fn fractions_are_found_again() {
        for bits in 4..=15 {
            for fraction in fractions_of_cells() {
                let [x, y, z] = fraction;
                let eight = trilinear(fraction, bits);
                let found = super::fractions(&eight, 8, bits).unwrap_or([u16::MAX; 3]);
                assert_eq!(trilinear(found, bits), eight, "{fraction:?} {bits}");
                if bits == 15 && [x, y, z].iter().all(|f| (1..4096).contains(f)) {
                    assert_eq!(found, fraction);
                }
                let mut four = [0; 8];
                four[..4].copy_from_slice(&bilinear([x, y], bits));
                let found = super::fractions(&four, 4, bits).unwrap_or([u16::MAX; 3]);
                assert_eq!(
                    (bilinear([found[0], found[1]], bits), found[2]),
                    (four[..4].try_into().unwrap_or([0; 4]), 0)
                );
                let mut two = [0; 8];
                two[..2].copy_from_slice(&linear(x, bits));
                let found = super::fractions(&two, 2, bits).unwrap_or([u16::MAX; 3]);
                assert_eq!(linear(found[0], bits), two[..2]);
            }
        }
        let mut off = trilinear([100, 2000, 3000], 15);
        off[3] += 1;
        assert_eq!(super::fractions(&off, 8, 15), None);
        off[2] -= 1;
        assert_eq!(super::fractions(&off, 8, 15), None);
        assert_eq!(super::fractions(&[0; 8], 8, 15), None);
    }

    /// The sum of the weights' errors, in units of 2^-W.
    fn off(fraction: [u16; 3], weight_bits: u32, weights: [u16; 8]) -> f64 {
        let [x, y, z] = fraction.map(|f| f64::from(f) / 4096.0);
        let side = |bit: usize, u: f64| if bit == 1 { u } else { 1.0 - u };
        let exact = |c: usize| side(c & 1, x) * side(c >> 1 & 1, y) * side(c >> 2, z);
        let one = f64::from(1u32 << weight_bits);
        (0..8)
            .map(|c| (f64::from(weights[c]) - exact(c) * one).abs())
            .sum()
    }

    fn fractions_of_cells() -> impl Iterator<Item = [u16; 3]> {
        let faces = [0, 1, 2048, 4095, 4096];
        let on_faces = faces.into_iter().flat_map(move |x| {
            faces
                .into_iter()
                .flat_map(move |y| faces.map(|z| [x, y, z]))
        });
        let inside = (0..40_000u32)
            .map(|i| [3, 9, 17].map(|s| (i.wrapping_mul(0x9e37_79b1) >> s) as u16 & 0xfff));
        on_faces.chain(inside)
    }

    /// Weights sum to 1, and are within 6.04 units of 2^-W of the product form
    /// together: half a unit for each of the seven splits, and what a split's
    /// error becomes in the splits below it.
    #[test]
    fn split_trees_are_exact_in_sum_and_close_in_each() {
        for bits in [4, 8, 12, 15] {
            let mut worst = 0.0f64;
            for fraction in fractions_of_cells() {
                let w = trilinear(fraction, bits);
                let sum: u32 = w.iter().map(|w| u32::from(*w)).sum();
                assert_eq!(sum, 1 << bits, "{fraction:?}");
                worst = worst.max(off(fraction, bits, w));
                let [x, y, z] = fraction;
                assert_eq!(
                    bilinear([x, y], bits).map(u32::from).iter().sum::<u32>(),
                    1 << bits
                );
                assert_eq!(trilinear([x, y, 0], bits)[..4], bilinear([x, y], bits));
                assert_eq!(trilinear([x, 0, 0], bits)[..2], linear(x, bits));
                assert_eq!(trilinear([0, 0, z], bits)[4], linear(z, bits)[1]);
            }
            assert!(worst <= 6.04, "W = {bits}: {worst}");
            assert!(worst > 3.0, "the bound is not idle: {worst}");
        }
    }

    /// Every fraction of an edge: the sum is 1, each weight is the nearest, and
    /// the far one never falls as the fraction grows.
    #[test]
    fn all_edges_are_exact_in_sum() {
        for bits in 1..=15 {
            let mut last = 0;
            for u in 0..=4096u16 {
                let [low, high] = linear(u, bits);
                assert_eq!(u32::from(low) + u32::from(high), 1 << bits);
                let exact = f64::from(u) * 2f64.powi(bits as i32 - 12);
                assert!((f64::from(high) - exact).abs() <= 0.5, "W = {bits}, {u}");
                assert!(high >= last);
                last = high;
            }
            assert_eq!(linear(4096, bits), [0, 1 << bits]);
            assert_eq!(linear(u16::MAX, bits), [0, 1 << bits]);
        }
    }

    /// Every fraction of a face: the sum is 1, and the weights are within 3
    /// units of 2^-W of the product form together: half a unit for the first
    /// split, which both halves pass on, and one for each of the other two.
    #[test]
    fn all_faces_are_exact_in_sum() {
        for bits in [4, 15] {
            let one = 2f64.powi(bits as i32);
            let mut worst = 0.0f64;
            for y in 0..=4096u16 {
                for x in 0..=4096u16 {
                    let w = bilinear([x, y], bits);
                    assert_eq!(w.map(u32::from).iter().sum::<u32>(), 1 << bits);
                    let [u, v] = [x, y].map(|f| f64::from(f) / 4096.0);
                    let exact = [(1.0 - u) * (1.0 - v), u * (1.0 - v), (1.0 - u) * v, u * v];
                    let off = |c: usize| (f64::from(w[c]) - exact[c] * one).abs();
                    worst = worst.max(off(0) + off(1) + off(2) + off(3));
                }
            }
            assert!(worst <= 3.0, "W = {bits}: {worst}");
            assert!(worst >= 2.0, "the bound is not idle: {worst}");
        }
    }

    /// Rounded one by one, most weights do not sum to 1.
    #[test]
    fn weights_rounded_alone_do_not_sum_to_one() {
        let (mut wrong, mut count) = (0, 0);
        for fraction in fractions_of_cells() {
            let [x, y, z] = fraction.map(|f| f64::from(f) / 4096.0);
            let side = |bit: usize, u: f64| if bit == 1 { u } else { 1.0 - u };
            let sum: f64 = (0..8)
                .map(|c| (side(c & 1, x) * side(c >> 1 & 1, y) * side(c >> 2, z) * 256.0).round())
                .sum();
            wrong += u32::from(sum != 256.0);
            count += 1;
        }
        assert!(wrong * 10 > count * 4, "{wrong} of {count}");
    }
}
