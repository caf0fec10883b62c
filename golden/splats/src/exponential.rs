//! The exponential of the float renderer's inner loop.
//!
//! Straight-line arithmetic without calls or tables, so that the compiler can vectorise over
//! pixels. No fused operation is used: every machine gives the same bits, whatever the width of
//! its vectors.

/// Lower arguments are clamped to this: the result is far too faint for any rule set.
const LEAST: f64 = -700.0;
/// Adding it leaves a rounded integer in the lowest bits of the sum.
const ROUND: f64 = 6_755_399_441_055_744.0; // 1.5 * 2^52
/// ln 2 in two parts; the first has 21 zero bits at its end, so that its
/// product with the exponent of a result is exact.
const LN_2: [f64; 2] = [0.693_147_180_369_123_8, 1.908_214_929_270_587_7e-10];

/// The polynomial of degree 11 that interpolates e^r at the twelve Chebyshev nodes of |r| <= ln 2
/// / 2, from 60-digit arithmetic; before rounding its coefficients it is within 4.3e-18 of e^r
/// there.
const POLYNOMIAL: [f64; 12] = [
    1.0,
    1.0,
    0.500_000_000_000_001_9,
    0.166_666_666_666_666_8,
    0.041_666_666_666_488_09,
    0.008_333_333_333_319_601,
    0.001_388_888_895_231_481_2,
    0.000_198_412_698_900_471_43,
    2.480_148_548_228_773e-5,
    2.755_724_091_854_762_5e-6,
    2.763_263_965_412_376e-7,
    2.511_003_761_756_205e-8,
];

/// e^x for x in -700..=0 with a relative error below 4e-16; below -700, e^-700 (1e-304). Not valid
/// for x above 700 or NaN.
#[inline(always)]
pub(super) fn exp(x: f64) -> f64 {
    let x = if x > LEAST { x } else { LEAST };
    let shifted = x * std::f64::consts::LOG2_E + ROUND;
    let power = shifted - ROUND;
    let r = (x - power * LN_2[0]) - power * LN_2[1];
    let c = &POLYNOMIAL;
    let (r2, r4, r8);
    r2 = r * r;
    r4 = r2 * r2;
    r8 = r4 * r4;
    // 1 + r last, so that its rounding is the only one of weight.
    let low = (c[2] + c[3] * r) * r2;
    let mid = ((c[4] + c[5] * r) + (c[6] + c[7] * r) * r2) * r4;
    let high = ((c[8] + c[9] * r) + (c[10] + c[11] * r) * r2) * r8;
    let value = 1.0 + (r + (low + (mid + high)));
    // The lowest 12 bits of `shifted` hold the power; the shift leaves them
    // alone, biased, as the exponent of a double.
    let scale = f64::from_bits(shifted.to_bits().wrapping_add(1023) << 52);
    value * scale
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn within_two_units_of_the_last_place() {
        let mut worst = 0.0f64;
        for i in 0..2_000_000 {
            // Dense near 0, down to -700.
            let u = f64::from(i) / 2e6;
            for x in [-700.0 * u, -8.0 * u, -u * u * u * 1e-3] {
                worst = worst.max((exp(x) / x.exp() - 1.0).abs());
            }
        }
        assert!(worst < 4e-16, "{worst:e}");
        // Where the reduction changes its power of two, from both sides.
        for k in 0..1000 {
            let edge = -(f64::from(k) + 0.5) * std::f64::consts::LN_2;
            for x in [edge.next_down(), edge, edge.next_up()] {
                let expected = x.max(LEAST).exp();
                assert!((exp(x) / expected - 1.0).abs() < 4e-16, "{x}");
            }
        }
    }

    #[test]
    fn ends_of_the_range() {
        assert_eq!(exp(0.0), 1.0);
        assert_eq!(exp(-0.0), 1.0);
        for far in [-700.0, -701.0, -1e300, f64::NEG_INFINITY] {
            assert_eq!(exp(far), exp(-700.0));
        }
        assert!(exp(-700.0) < 1.1e-304 && exp(-700.0) > 0.9e-304);
    }
}
