//! The engine's constants, `2^j ln 2` and `ln(1 + 2^-i)`, from integer series.

use std::sync::LazyLock;

/// Fraction bits of the series. Each of its at most 80 terms is truncated, so that a sum is below
/// its limit by less than 2^-113.
const SERIES_BITS: u32 = 120;

/// `2 atanh(p / m)` for p of 1 and 3 and `m >= 3 p`: the sum of
/// `2 / (2k + 1) (p / m)^(2k + 1)`.
fn twice_atanh(p: u128, m: u128) -> u128 {
    let mut power = ((2 * p) << SERIES_BITS) / m;
    let (mut sum, mut divisor) = (0, 1);
    while power > 0 {
        sum += power / divisor;
        // No factor overflows: power is at most 2^121, m at most 2^34.
        power = power / m * p / m * p;
        divisor += 2;
    }
    sum
}

/// ln 2, `ln(1 + 2^-i)` by `i` from 0 to 31, and `ln(1 + 3 2^-i)` by `i` from 2 to 31: each unit that is
/// built takes most of them.
static LN_2: LazyLock<u128> = LazyLock::new(|| twice_atanh(1, 3));
static LN_1_AND_POWER: LazyLock<[u128; 32]> =
    LazyLock::new(|| std::array::from_fn(|i| twice_atanh(1, (2 << i) + 1)));
static LN_1_AND_THREE_POWERS: LazyLock<[u128; 32]> = LazyLock::new(|| {
    std::array::from_fn(|i| {
        if i < 2 {
            0
        } else {
            twice_atanh(3, (2 << i) + 3)
        }
    })
});

fn nearest(value: u128, drop: u32) -> i64 {
    ((value + (1 << (drop - 1))) >> drop) as i64
}

/// `2^j ln 2` with `bits` fraction bits, to nearest. `j + bits` is at most 60.
pub(super) fn multiple_of_ln2(j: u32, bits: u32) -> i64 {
    nearest(*LN_2, SERIES_BITS - (j + bits).min(60))
}

/// `ln(1 + 2^-i)` with `bits` fraction bits, to nearest. `i` is at most 31,
/// `bits` at most 60.
pub(super) fn ln_one_plus_power(i: u32, bits: u32) -> i64 {
    // ln((1 + z) / (1 - z)) = 2 atanh z, here with z = 1 / (2^(i+1) + 1).
    nearest(
        LN_1_AND_POWER[i.min(31) as usize],
        SERIES_BITS - bits.min(60),
    )
}

/// ln 2 with `bits` fraction bits, at most 100, truncated.
pub(super) fn ln2(bits: u32) -> i128 {
    (*LN_2 >> (SERIES_BITS - bits)) as i128
}

/// `m ln 2` with `bits` fraction bits, to nearest. m is at most 64, `bits` 60.
pub(super) fn times_ln2(m: u32, bits: u32) -> i64 {
    nearest(*LN_2 * u128::from(m), SERIES_BITS - bits.min(60))
}

/// `ln(1 + d 2^-i)`, d of 1 to 3, with `bits` fraction bits, to nearest. `i` is 2
/// to 31, `bits` at most 60.
pub(super) fn ln_one_plus_ratio(d: u32, i: u32, bits: u32) -> i64 {
    // z = d / (2^(i+1) + d); of d = 2 the power before.
    match d {
        3 => nearest(
            LN_1_AND_THREE_POWERS[i.min(31) as usize],
            SERIES_BITS - bits.min(60),
        ),
        2 => ln_one_plus_power(i - 1, bits),
        _ => ln_one_plus_power(i, bits),
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use astro_float::{BigFloat, Consts, RoundingMode};

    /// Against an independent library: the scaled logarithm is within half a
    /// unit of the constant, at every index and width.
    #[test]
    fn constants_are_rounded_to_nearest() {
        let (p, rm) = (256, RoundingMode::ToEven);
        let mut consts = Consts::new().unwrap();
        let half = BigFloat::from_f64(0.5, p);
        let mut check = |argument: BigFloat, scale: i32, found: i64| {
            let exact = argument.ln(p, rm, &mut consts).mul(
                &BigFloat::from_f64(2f64.powi(scale), p),
                p,
                rm,
            );
            let off = exact.sub(&BigFloat::from_f64(found as f64, p), p, rm).abs();
            assert!(off < half, "scale {scale}: {found}");
        };
        for bits in 4..=40u32 {
            for j in 0..8 {
                check(
                    BigFloat::from_f64(2.0, p),
                    (j + bits) as i32,
                    multiple_of_ln2(j, bits),
                );
            }
            for i in 0..=31 {
                check(
                    BigFloat::from_f64(1.0 + 2f64.powi(-(i as i32)), p),
                    bits as i32,
                    ln_one_plus_power(i, bits),
                );
            }
            for i in (2..=30).step_by(2) {
                for d in 1..=3u32 {
                    check(
                        BigFloat::from_f64(1.0 + f64::from(d) * 2f64.powi(-(i as i32)), p),
                        bits as i32,
                        ln_one_plus_ratio(d, i, bits),
                    );
                }
            }
            check(
                BigFloat::from_f64(4096.0, p),
                bits as i32,
                times_ln2(12, bits),
            );
        }
    }
}
