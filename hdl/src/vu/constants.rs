//! The constants in SR_sub, and what SR_mul holds beside them.

use num_bigint::BigInt;
use potamoi_formats::config::{ExpConfig, ExpForm};

/// Fraction bits that the series are summed with; far past the 40 ever asked.
const PRECISION: u32 = 110;

/// `ln(1 + 2^-i)`, rounded to nearest at `bits` fraction bits.
///
/// `ln((1 + z) / (1 - z)) = 2 (z + z^3/3 + z^5/5 + ..)` with
/// `z = 1 / (2^(i+1) + 1)`.
#[must_use]
pub fn ln_one_plus(i: u32, bits: u32) -> BigInt {
    round(&series(i), bits)
}

/// `2^j ln 2`, rounded to nearest at `bits` fraction bits.
#[must_use]
pub fn ln_two_times(j: u32, bits: u32) -> BigInt {
    round(&(series(0) << j), bits)
}

fn series(i: u32) -> BigInt {
    let q = (BigInt::from(1) << (i + 1)) + 1;
    let square = &q * &q;
    let mut power = (BigInt::from(1) << (PRECISION + 1)) / &q;
    let mut sum = BigInt::ZERO;
    let mut k = 1;
    while power != BigInt::ZERO {
        sum += &power / k;
        power /= &square;
        k += 2;
    }
    sum
}

fn round(value: &BigInt, bits: u32) -> BigInt {
    let drop = PRECISION - bits;
    (value + (BigInt::from(1) << (drop - 1))) >> drop
}

/// One place of the shift registers.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Step {
    /// What is compared with `R_remain`, and subtracted from it.
    pub(super) constant: BigInt,
    /// Shift amount of `R_accum`.
    pub(super) shift: u32,
    /// An exponent digit: `R_accum` stays.
    pub(super) digit: bool,
}

/// The steps, filled up to whole clocks with ones that never subtract.
pub(super) fn steps(exp: &ExpConfig, remain_bits: u32) -> Vec<Step> {
    let engine = exp.engine();
    let bits = engine.constant_bits;
    let mut steps: Vec<Step> = (0..engine.digits)
        .rev()
        .map(|j| Step {
            constant: ln_two_times(j, bits),
            shift: 0,
            digit: true,
        })
        .collect();
    let first = u32::from(exp.form == ExpForm::Restoring);
    steps.extend((first..first + exp.iterations).map(|i| Step {
        constant: ln_one_plus(i, bits),
        shift: i,
        digit: false,
    }));
    let magnitude = remain_bits - u32::from(exp.form == ExpForm::Literal);
    while !steps
        .len()
        .is_multiple_of(exp.iterations_per_clock as usize)
    {
        steps.push(Step {
            constant: (BigInt::from(1) << magnitude) - 1,
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
}
