//! Constants in SR_sub, and shift amounts in SR_mul.

use num_bigint::BigInt;
use num_traits::ToPrimitive;
use potamoi_formats::config::ExpConfig;

use super::form::Recurrence;

/// Fraction bits of the series' sums, far beyond the largest request of 40.
const PRECISION: u32 = 110;

/// `ln(1 + 2^-i)`, rounded to nearest at `bits` fraction bits.
///
/// `ln((1 + z) / (1 - z)) = 2 (z + z^3/3 + z^5/5 + ..)` with
/// `z = 1 / (2^(i+1) + 1)`.
#[must_use]
pub fn ln_one_plus(i: u32, bits: u32) -> BigInt {
    round(&series(1, i), bits)
}

/// `2^j ln 2`, rounded to nearest at `bits` fraction bits.
#[must_use]
pub fn ln_two_times(j: u32, bits: u32) -> BigInt {
    round(&(series(1, 0) << j), bits)
}

/// `d ln 2`, rounded to nearest at `bits` fraction bits.
pub(super) fn ln_two_multiple(d: u32, bits: u32) -> BigInt {
    round(&(series(1, 0) * d), bits)
}

/// `ln(1 + p 2^-i)`, p of 1 to 3: `z = p / (2^(i+1) + p)`.
fn series(p: u32, i: u32) -> BigInt {
    let q = (BigInt::from(1) << (i + 1)) + p;
    let (numerator, denominator) = (BigInt::from(p * p), &q * &q);
    let mut power = (BigInt::from(p) << (PRECISION + 1)) / &q;
    let mut sum = BigInt::ZERO;
    let mut k = 1;
    while power != BigInt::ZERO {
        sum += &power / k;
        power = power * &numerator / &denominator;
        k += 2;
    }
    sum
}

/// The excess of `ln(1 + p 2^-i)` over a constant of `bits` fraction bits.
pub(in crate::vector_unit) fn less_than_log(constant: &BigInt, bits: u32, p: u32, i: u32) -> f64 {
    let less = series(p, i) - (constant << (PRECISION - bits));
    less.to_f64().unwrap_or(f64::INFINITY) * 2f64.powi(-(PRECISION as i32))
}

/// `log2 e`, rounded to nearest at `bits` fraction bits.
pub(super) fn log2_e(bits: u32) -> BigInt {
    round(&((BigInt::from(1) << (2 * PRECISION)) / series(1, 0)), bits)
}

/// The linear pieces of `2^(1-f)`, f in [0, 1): start and slope of each.
///
/// The slope is the chord's, rounded at `slope_bits`. The start, rounded at `start_bits`, is
/// halfway between the largest and the smallest value required at the ends of the piece and in its
/// middle.
pub(super) fn pieces(index_bits: u32, start_bits: u32, slope_bits: u32) -> Vec<[BigInt; 2]> {
    let halves = index_bits + 1;
    // 2^(2^-halves), by square roots, and its powers.
    let mut root = BigInt::from(2) << PRECISION;
    for _ in 0..halves {
        root = (root << PRECISION).sqrt();
    }
    let mut powers = vec![BigInt::from(1) << PRECISION];
    for j in 0..1usize << halves {
        let next = (&powers[j] * &root) >> PRECISION;
        powers.push(next);
    }
    // From 2 downwards.
    powers.reverse();
    let count = 1usize << index_bits;
    let piece = |i: usize| {
        let [left, middle, right] = [0, 1, 2].map(|h| &powers[2 * i + h]);
        let slope = round(&((left - right) << index_bits), slope_bits);
        let fall = (&slope << (PRECISION - slope_bits)) >> index_bits;
        let high = left.max(&(right + &fall)).clone();
        let start = high + middle + (fall >> 1);
        [round(&(start >> 1), start_bits), slope]
    };
    (0..count).map(piece).collect()
}

fn round(value: &BigInt, bits: u32) -> BigInt {
    let drop = PRECISION - bits;
    (value + (BigInt::from(1) << (drop - 1))) >> drop
}

/// One position of the shift registers.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Step {
    /// Constants compared with `R_remain` and subtracted from it: one, or for radix 4 those of the
    /// digits 1, 2 and 3.
    pub(super) constants: Vec<BigInt>,
    /// What the constants are, in words; `d` is the digit of radix 4.
    pub(super) constant: String,
    /// Shift amount of `R_accum`.
    pub(super) shift: u32,
    /// Whether it is an exponent digit, which leaves `R_accum` unchanged.
    pub(super) digit: bool,
}

/// The non-zero digits of a step.
pub(in crate::vector_unit) fn multiples(own: &dyn Recurrence) -> std::ops::RangeInclusive<u32> {
    1..=(1 << own.radix_bits()) - 1
}

/// The steps, padded to whole clocks with steps that never subtract.
pub(super) fn steps(own: &dyn Recurrence, exp: &ExpConfig, remain_bits: u32) -> Vec<Step> {
    let engine = exp.engine();
    let bits = engine.constant_bits;
    let (multiples, radix_bits) = (multiples(own), own.radix_bits());
    let of_digits = if radix_bits == 1 { "" } else { "d " };
    let mut steps: Vec<Step> = (0..engine.digits)
        .rev()
        .map(|j| Step {
            constants: multiples
                .clone()
                .map(|d| ln_two_multiple(d << (radix_bits * j), bits))
                .collect(),
            constant: format!("{of_digits}{} ln 2", 1u64 << (radix_bits * j)),
            shift: 0,
            digit: true,
        })
        .collect();
    let first = own.first();
    steps.extend((first..first + exp.iterations).map(|i| {
        Step {
            constants: multiples
                .clone()
                .map(|d| round(&series(d, radix_bits * i), bits))
                .collect(),
            constant: format!("ln(1 + {of_digits}2^-{})", radix_bits * i),
            shift: radix_bits * i,
            digit: false,
        }
    }));
    let magnitude = remain_bits - u32::from(own.is_literal());
    while !steps
        .len()
        .is_multiple_of(exp.iterations_per_clock as usize)
    {
        let never: BigInt = (BigInt::from(1) << magnitude) - 1;
        steps.push(Step {
            constants: multiples.clone().map(|_| never.clone()).collect(),
            constant: "never taken".to_owned(),
            shift: 0,
            digit: false,
        });
    }
    steps
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn constants_agree_with_double_precision() {
        for i in 0..=31u32 {
            let expected = (2f64.powi(-(i as i32))).ln_1p() * 2f64.powi(40);
            let found = ln_one_plus(i, 40)
                .to_string()
                .parse::<f64>()
                .unwrap_or(f64::NAN);
            assert!(
                (expected - found).abs() <= 0.501,
                "i = {i}: {found} for {expected}"
            );
        }
        assert_eq!(ln_two_times(0, 40), ln_one_plus(0, 40));
        // ln 2 = 0.B17217F7D1CF79ABC9E3B398.. in hexadecimal.
        assert_eq!(format!("{:X}", ln_two_times(0, 40)), "B17217F7D2");
    }

    #[test]
    fn ratios_and_pieces_agree_with_double_precision() {
        let number = |found: &BigInt| found.to_string().parse::<f64>().unwrap_or(f64::NAN);
        for i in 2..=30u32 {
            for d in 1..=3u32 {
                let exact = (f64::from(d) * 2f64.powi(-(i as i32))).ln_1p() * 2f64.powi(40);
                let found = number(&round(&series(d, i), 40));
                assert!(
                    (exact - found).abs() <= 0.501,
                    "{d} {i}: {found} for {exact}"
                );
            }
        }
        let exact = std::f64::consts::LOG2_E * 2f64.powi(40);
        assert!((number(&log2_e(40)) - exact).abs() <= 0.501);
        for index_bits in [4, 6, 10] {
            let h = 2f64.powi(-(index_bits as i32));
            // Half a chord's sagitta, and a bit for the start's rounding.
            let most = h * h * std::f64::consts::LN_2.powi(2) / 8.0 + 2f64.powi(-31);
            for (i, [start, slope]) in pieces(index_bits, 31, 31).iter().enumerate() {
                for part in [0.0, 0.25, 0.5, 0.75, 1.0] {
                    let exact = (1.0 - (i as f64 + part) * h).exp2();
                    let found = (number(start) - number(slope) * part * h) * 2f64.powi(-31);
                    assert!((exact - found).abs() <= most, "{index_bits} {i} {part}");
                }
            }
        }
    }
}
