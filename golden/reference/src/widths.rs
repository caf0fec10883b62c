//! Search for the smallest widths of the exponential engine over every input.

use potamoi_formats::config::{ExpConfig, ExpForm};
use rayon::prelude::*;

use super::exact_exponential::{ExactError, ExactExponential};
use super::exponential::ReferenceExponential;

/// The accuracy that the widths must reach.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Target {
    /// Every result is the nearest code.
    CorrectlyRounded,
    /// The largest error is below this many units of the last place.
    Below(f64),
}

/// The widths found and the error they reach.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SufficientWidths {
    /// Fraction bits of `R_accum`.
    pub accumulator_bits: u32,
    /// Fraction bits of `R_remain` and the constants.
    pub constant_bits: u32,
    /// Start of `R_accum` in units of its last bit above 1.
    pub offset: i32,
    /// Largest error in units of the last place.
    pub max_ulp: f64,
}

/// The error of truncation after n iterations alone, in units of the last of `f` bits: centred
/// without tail, second order with it.
#[must_use]
pub fn truncation(n: u32, tail: bool, f: u32) -> f64 {
    let (n, f) = (n as i32, f as i32);
    2f64.powi(if tail { f - 2 * n - 1 } else { f - n - 1 })
}

/// An upper bound of the error of `config`, in units of the last place: rounding the result,
/// truncation, rounding each sum of the accumulator, and each constant.
///
/// `1/2 + T + (n 2^-a / 2 + |offset| 2^-a) + (n + 4) 2^-c / 2`, with `a` and `c` the fraction bits
/// of accumulator and constants beyond F; a tail, which truncates its product, counts as two more
/// sums. An early error may double until the end, and a result of less than 1 is halved at least
/// once. Holds for the restoring form's alpha output if the constants have more than n fraction
/// bits.
///
/// Radix 4 has one sum and one constant for two bits. An early out leaves a power of exponent k
/// the iterations with which truncation is at most half a unit. Linear pieces
/// have the error of a chord and of rounding. Infinite for a form without a known bound.
#[must_use]
pub fn budget(config: &ExpConfig) -> f64 {
    if config.form == ExpForm::Piecewise {
        return piecewise_budget(config);
    }
    let known = [ExpForm::Restoring, ExpForm::Literal, ExpForm::Radix4];
    if !known.contains(&config.form) {
        return f64::INFINITY;
    }
    let (n, f, engine) = (config.iterations, config.output_bits, config.engine());
    let beyond = |bits: u32| 2f64.powi(f as i32 - bits as i32);
    let sums = f64::from(n) / 2.0 + f64::from(engine.offset.abs());
    let sums = sums + if config.tail { 1.0 } else { 0.0 };
    let cut = truncation(config.resolved_bits(), config.tail, f);
    0.5 + if config.early_out { cut.max(0.5) } else { cut }
        + sums * beyond(engine.accumulator_bits)
        + f64::from(n + engine.digits) / 2.0 * beyond(engine.constant_bits)
}

/// The error of linear interpolation alone, in units of the last of `f` bits: `h^2 y'' / 16`, half
/// a chord's sagitta, with `h = 1 / pieces` and `y'' = 2 (ln 2)^2` at most, halved by the
/// exponent.
#[must_use]
pub fn straightness(pieces: u32, f: u32) -> f64 {
    let h = 1.0 / f64::from(pieces.max(1));
    2f64.powi(f as i32) * (h * std::f64::consts::LN_2).powi(2) / 16.0
}

/// An upper bound of the error of linear pieces, one-minus-exp included, in units of the last
/// place. A power of `2^-k y` with y at most 2 and k at least 1 halves the error of y.
///
/// The error of y: the interpolation itself; half a unit each for the start and the product; the
/// slope, whose last bit moves the end of a piece by `2^-s h`, half of which is rounding, halved
/// again because the start lies halfway; and the lowest point of the curve, which a slope error of
/// `2^-s / 2` moves from the middle of its piece: `(2^-s / 2)^2 / (2 y'')`. The error of the
/// power: half a unit for its own rounding, half a unit for that of the operand, and `x e^-x <=
/// 1/e` times the error of `log2 e`.
#[must_use]
pub(crate) fn piecewise_budget(config: &ExpConfig) -> f64 {
    let (engine, widths) = (config.engine(), config.piece_widths());
    let unit = 2f64.powi(config.output_bits as i32);
    let last = |bits: u32| 2f64.powi(-(bits as i32));
    let ln2 = std::f64::consts::LN_2;
    let slope = last(widths.slope_bits + 1);
    let y = last(engine.accumulator_bits)
        + slope * last(widths.index_bits + 1)
        + slope.powi(2) / (4.0 * ln2.powi(2));
    let power = last(engine.constant_bits + 1) * (1.0 + ln2);
    let scale = widths
        .scale_bits
        .map_or(0.0, |bits| last(bits + 1) * ln2 / std::f64::consts::E);
    0.5 + straightness(config.pieces, config.output_bits) + unit * (y / 2.0 + power + scale)
}

/// The target for an engine of n iterations. A truncation T of one unit or more may grow by one
/// unit: half for the rounding, half for the arithmetic. At T of half a unit the result stays
/// below one unit. For smaller T the arithmetic gets a quarter, until T is so small that every
/// result can be the nearest code.
#[must_use]
pub fn target(n: u32, tail: bool, f: u32) -> Target {
    let t = truncation(n, tail, f);
    if t >= 1.0 {
        Target::Below(t + 1.0)
    } else if t >= 0.5 {
        Target::Below(1.0)
    } else if t > 2f64.powi(-11) {
        Target::Below(0.75 + t)
    } else {
        Target::CorrectlyRounded
    }
}

impl Target {
    /// Whether a largest error meets the target.
    #[must_use]
    pub fn is_met(self, max_ulp: f64) -> bool {
        match self {
            Self::CorrectlyRounded => max_ulp <= 0.5,
            Self::Below(limit) => max_ulp < limit,
        }
    }
}

/// Limits of the search: guard bits and offset.
const GUARD: u32 = 14;
const OFFSETS: i32 = 3;

/// The smallest widths that meet a target over every input: fewest bits of accumulator and
/// constants together, then fewest bits of the accumulator, then the smallest error, then the
/// smallest offset. Results must be monotone.
///
/// # Errors
/// Those of [`ExactExponential::of`].
pub fn smallest(
    config: &ExpConfig,
    target: Target,
) -> Result<Option<SufficientWidths>, ExactError> {
    let reference = ExactExponential::of(config.input)?;
    let f = config.output_bits;
    let least = config.input.frac_bits();
    for sum in (f + least)..=(2 * (f + GUARD)) {
        for accumulator_bits in f..=(f + GUARD) {
            let Some(constant_bits) = sum.checked_sub(accumulator_bits) else {
                continue;
            };
            if !(least..=f + GUARD).contains(&constant_bits) {
                continue;
            }
            let best = (-OFFSETS..=OFFSETS)
                .into_par_iter()
                .filter_map(|offset| {
                    let widths = ExpConfig {
                        accumulator_bits: Some(accumulator_bits),
                        constant_bits: Some(constant_bits),
                        offset: Some(offset),
                        ..config.clone()
                    };
                    let twin = ReferenceExponential::new(&widths);
                    let max_ulp = largest(&reference, &twin, f, target)?;
                    Some(SufficientWidths {
                        accumulator_bits,
                        constant_bits,
                        offset,
                        max_ulp,
                    })
                })
                .min_by(|a, b| {
                    let by_error = a.max_ulp.total_cmp(&b.max_ulp);
                    by_error.then(a.offset.abs().cmp(&b.offset.abs()))
                });
            if best.is_some() {
                return Ok(best);
            }
        }
    }
    Ok(None)
}

/// The largest error; `None` if it misses the target or the results are not monotone.
fn largest(
    reference: &ExactExponential,
    twin: &ReferenceExponential,
    f: u32,
    target: Target,
) -> Option<f64> {
    let falls = !reference.input().is_signed();
    let (mut worst, mut before) = (0.0f64, None);
    for code in reference.codes() {
        let found = twin.exp(code);
        worst = worst.max(reference.error(code, found, f).abs());
        let ordered = before.is_none_or(|b| if falls { found <= b } else { found >= b });
        if !ordered || !target.is_met(worst) {
            return None;
        }
        before = Some(found);
    }
    Some(worst)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    /// Numbers of iterations, each built with and without tail.
    const ITERATIONS: [u32; 5] = [8, 12, 16, 20, 27];

    fn engine(n: u32, tail: bool, f: u32) -> ExpConfig {
        ExpConfig {
            iterations: n,
            tail,
            output_bits: f,
            ..ExpConfig::default()
        }
    }

    /// Error of the default widths of a configuration.
    fn error(config: &ExpConfig) -> super::super::exact_exponential::ExpError {
        let twin = ReferenceExponential::new(config);
        let reference = ExactExponential::of(config.input).unwrap();
        reference.measure(config.output_bits, |code| twin.exp(code))
    }

    #[test]
    fn default_widths_meet_their_targets_over_every_input() {
        for n in ITERATIONS {
            for tail in [false, true] {
                let config = engine(n, tail, 16);
                let found = error(&config);
                let target = target(n, tail, 16);
                let e = config.engine();
                println!(
                    "n {n:2} tail {tail:5}: {:.4} ulp, widths {}/{}/{}, {} cycles, {target:?}",
                    found.max_ulp,
                    e.accumulator_bits,
                    e.constant_bits,
                    e.offset,
                    config.interval()
                );
                assert!(target.is_met(found.max_ulp), "{n} {tail}: {found:?}");
                assert!(found.monotone, "{n} {tail}");
            }
        }
        assert!(error(&ExpConfig::default()).max_ulp < 1.0);
    }

    /// F, n, accumulator, constants, offset, tail, largest error: figures that
    /// are known from elsewhere for the same recurrence.
    #[test]
    fn published_rows_hold_or_are_beaten() {
        for (f, n, tail, limit) in [
            (8, 8, false, 1.0),
            (8, 4, true, 1.0),
            (12, 12, false, 1.0),
            (12, 6, true, 1.0),
            (16, 16, false, 0.973),
            (16, 8, true, 0.9985),
            (16, 9, true, 0.6835),
            (24, 24, false, 1.0),
            (24, 12, true, 1.0),
            (16, 27, false, 0.5),
            (16, 14, true, 0.5),
            (12, 25, false, 0.5),
            (12, 13, true, 0.5),
            (8, 23, false, 0.5),
            (8, 11, true, 0.5),
            (24, 18, true, 0.5),
        ] {
            let found = error(&engine(n, tail, f));
            assert!(found.max_ulp <= limit, "F {f} n {n} {tail}: {found:?}");
            assert!(found.monotone, "F {f} n {n} {tail}");
        }
    }

    /// No engine exceeds its error bound, and few bounds are loose.
    #[test]
    fn errors_stay_within_their_budgets() {
        let mut closest = 0.0f64;
        for n in 2..=31u32 {
            for (guard_a, guard_c, f) in [(0, 1, 16), (2, 3, 12), (6, 0, 16), (3, 3, 24)] {
                for tail in [false, true] {
                    let config = ExpConfig {
                        accumulator_bits: Some(f + guard_a),
                        constant_bits: Some((f + guard_c).max(n + 1)),
                        offset: Some(n as i32 % 3 - 1),
                        ..engine(n, tail, f)
                    };
                    let (found, limit) = (error(&config).max_ulp, budget(&config));
                    assert!(found <= limit, "{config:?}: {found}, budget {limit}");
                    closest = closest.max(found / limit);
                }
            }
        }
        assert!(closest > 0.9, "{closest}");
    }

    /// Without its offset the default recipe is above one unit; rounding the
    /// input by adding in 16 bits overflows where only large inputs show it.
    #[test]
    fn naive_forms_fail() {
        let plain = ExpConfig {
            accumulator_bits: Some(19),
            constant_bits: Some(19),
            offset: Some(0),
            ..ExpConfig::default()
        };
        let found = error(&plain);
        assert!(found.max_ulp > 1.1, "{found:?}");
        let reference = ExactExponential::of(ExpConfig::default().input).unwrap();
        let table = |index: u32| reference.scaled((index << 12) as i32, 16) >> 80;
        let naive = reference.measure(16, |u| {
            table(u32::from((u as u16).wrapping_add(2048)) >> 12) as i32
        });
        let right = reference.measure(16, |u| table((u as u32 + 2048) >> 12) as i32);
        assert!(
            naive.max_ulp > 60_000.0 && right.max_ulp < 20_000.0,
            "{naive:?} {right:?}"
        );
    }

    /// All widths up to 14 guard bits each, most of them refused by the first
    /// few inputs that they get wrong.
    #[test]
    fn the_search_finds_the_default_widths() {
        let both = ITERATIONS.map(|n| [(n, false), (n, true)]);
        for (n, tail) in both.into_iter().flatten().chain([(14, true)]) {
            let config = engine(n, tail, 16);
            let found = smallest(&config, target(n, tail, 16)).unwrap().unwrap();
            let e = config.engine();
            assert_eq!(
                (e.accumulator_bits, e.constant_bits, e.offset),
                (found.accumulator_bits, found.constant_bits, found.offset),
                "n {n} tail {tail}: {found:?}"
            );
        }
    }
}
