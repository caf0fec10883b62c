//! Alternative integer algorithms for the same exponential, from which the engine's forms are
//! chosen. None is built; clocks are those that the structure takes between results.

use std::f64::consts::{LN_2, LOG2_E};

use potamoi_formats::config::Config;
use potamoi_reference::exact_exponential::ExactExponential;

use super::{INPUT_UNIT, Method, OUTPUT_UNIT};
use crate::ExploreError;

/// Fraction bits of intermediate values.
const BITS: u32 = 22;
const ONE: i64 = 1 << BITS;
/// Digits of the binary exponent that an iterative form finds first, one a clock.
const DIGITS: f64 = 4.0;

/// The nearest fixed-point code of a constant.
fn fixed(value: f64) -> i64 {
    (value * ONE as f64).round() as i64
}

/// A product, rounded half up.
fn times(a: i64, b: i64) -> i64 {
    (a * b + ONE / 2) >> BITS
}

/// A right shift, rounded half up.
fn shifted(value: i64, by: u32) -> i64 {
    (value + ((1i64 << by) >> 1)) >> by
}

/// Output code of a mantissa from 1 to 2 and a number of halvings; 1 saturates at the largest code.
fn code(mantissa: i64, halvings: u32) -> i32 {
    let down = BITS - OUTPUT_UNIT.log2() as u32 + halvings;
    shifted(mantissa, down).min(OUTPUT_UNIT as i64 - 1) as i32
}

/// Range reduction: `exp(-u)` as `exp(rest) 2^-halvings`, with a rest from 0 to ln 2.
fn reduced(u: i32) -> (i64, u32) {
    let u = fixed(f64::from(u) * INPUT_UNIT);
    let ln2 = fixed(LN_2);
    let halvings = u / ln2 + 1;
    (halvings * ln2 - u, halvings as u32)
}

/// Range reduction in base 2: `exp(-u)` as `2^rest 2^-halvings`, with a rest from 0 to 1.
fn in_base_two(u: i32) -> (i64, u32) {
    let v = times(fixed(f64::from(u) * INPUT_UNIT), fixed(LOG2_E));
    let halvings = (v >> BITS) + 1;
    ((halvings << BITS) - v, halvings as u32)
}

/// CORDIC in hyperbolic mode (Walther, "A unified algorithm for elementary functions", 1971). Sine
/// and cosine start equal, and their sum is the exponential. Steps 4 and 13 are repeated.
fn cordic(u: i32) -> i32 {
    const TURNS: [u32; 19] = [
        1, 2, 3, 4, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 13, 14, 15, 16, 17,
    ];
    let step = |i: u32| 2f64.powi(-(i as i32));
    let gain: f64 = TURNS
        .iter()
        .map(|i| (1.0 - step(*i).powi(2)).sqrt())
        .product();
    let (mut rest, halvings) = reduced(u);
    let mut power = fixed(1.0 / gain);
    for i in TURNS {
        let angle = fixed(step(i).atanh());
        let sign = if rest >= 0 { 1 } else { -1 };
        rest -= sign * angle;
        power += sign * shifted(power, i);
    }
    code(power, halvings)
}

/// Three bits a step: the largest digit d from 0 to 7 with `ln(1 + d 8^-j)` at most the rest; the
/// final rest is multiplied in.
fn radix_8(u: i32) -> i32 {
    let (mut rest, halvings) = reduced(u);
    let mut power = ONE;
    for j in 1..=3 {
        let logarithm = |d: i64| fixed((d as f64 * 8f64.powi(-j)).ln_1p());
        let digit = (0..8).rev().find(|d| logarithm(*d) <= rest).unwrap_or(0);
        rest -= logarithm(digit);
        power += shifted(power * digit, 3 * j as u32);
    }
    code(power + times(power, rest), halvings)
}

/// FloPoCo's algorithm (de Dinechin, Pasca, "Designing custom arithmetic data paths with FloPoCo",
/// 2011): a table of the first eight bits, and 1 + z + (e^z - 1 - z) of the others.
fn tabled(u: i32) -> i32 {
    let (rest, halvings) = reduced(u);
    let head = rest >> (BITS - 8);
    let tail = rest - (head << (BITS - 8));
    let of_head = fixed((head as f64 / 256.0).exp());
    // What the tail adds beyond its own value, by its first seven bits.
    let first = tail >> (BITS - 15);
    let z = (first as f64 + 0.5) / 32_768.0;
    let beyond = fixed(z.exp_m1() - z);
    code(times(of_head, ONE + tail + beyond), halvings)
}

/// Piecewise linear or quadratic approximation of 2^g at Chebyshev points, with rounded constants.
fn pieces(u: i32, pieces: i64, degree: usize) -> i32 {
    let (g, halvings) = in_base_two(u);
    let piece = ((g * pieces) >> BITS).min(pieces - 1);
    let width = 1.0 / pieces as f64;
    let start = piece as f64 * width;
    let middle = start + width / 2.0;
    // About the middle, t from -1 to 1: 2^middle times the series of exp(a t).
    let a = LN_2 * width / 2.0;
    let scale = middle.exp2();
    // Of exp(a t), Chebyshev coefficients to the fourth order of a.
    let c0 = 1.0 + a * a / 4.0 + a.powi(4) / 64.0;
    let c1 = a + a.powi(3) / 8.0;
    let c2 = a * a / 4.0 + a.powi(4) / 48.0;
    let (constant, slope, curve) = match degree {
        1 => (c0, c1, 0.0),
        _ => (c0 - c2, c1, 2.0 * c2),
    };
    let t = (g - fixed(middle)) * 2 * pieces;
    let line = times(fixed(scale * slope), t) + fixed(scale * constant);
    code(line + times(times(fixed(scale * curve), t), t), halvings)
}

/// The paper's range reduction, literally: the exponent is divided by eight, the recurrence starts
/// from 1 + 1, and its result is squared three times.
fn squared(u: i32) -> i32 {
    const WITHIN: u32 = 26;
    let one = 1i64 << WITHIN;
    let of = |value: f64| (value * one as f64).round() as i64;
    // exp(1 - u / 8) over e: from 0 to 1 is within the recurrence's reach. Half of what the last
    // step leaves is added.
    let mut rest = of(1.0 - f64::from(u) * INPUT_UNIT / 8.0 + 2f64.powi(-20));
    let mut power = of((-1f64).exp());
    for i in 0..20u32 {
        let logarithm = of(2f64.powi(-(i as i32)).ln_1p());
        if rest >= logarithm {
            rest -= logarithm;
            power += shifted(power, i);
        }
    }
    for _ in 0..3 {
        power = (power * power + one / 2) >> WITHIN;
    }
    shifted(power, WITHIN - OUTPUT_UNIT.log2() as u32).min(OUTPUT_UNIT as i64 - 1) as i32
}

/// All alternatives over every input.
pub(super) fn others() -> Result<Vec<Method>, ExploreError> {
    let paper = Config::paper().vu.exp;
    let fail = |e: &dyn std::fmt::Display| ExploreError::Inconclusive(e.to_string());
    let reference = ExactExponential::of(paper.input).map_err(|e| fail(&e))?;
    let of = |[family, name]: [&'static str; 2], clocks: f64, result: &dyn Fn(i32) -> i32| {
        let error = reference.measure(paper.output_bits, result);
        Method {
            name: name.to_owned(),
            family,
            clocks,
            max_ulp: error.max_ulp,
            mean_ulp: error.mean,
            bound_ulp: None,
            netlist_ulp: None,
            monotone: error.monotone,
            area_mm2: None,
            energy_pj: None,
        }
    };
    let iterative = |turns: u32| DIGITS + f64::from(turns);
    Ok(vec![
        of(["CORDIC", "CORDIC, 19 turns"], iterative(19), &cordic),
        of(
            ["radix 8", "radix 8, J = 3, tail"],
            iterative(3 + 1),
            &radix_8,
        ),
        of(
            ["squarings", "divided by 8, squared three times"],
            20.0 + 3.0,
            &squared,
        ),
        of(
            ["a table, e^z - 1 - z", "table and e^z - 1 - z (as FloPoCo)"],
            1.0,
            &tabled,
        ),
        of(["8 parabolas of 2^-u"; 2], 1.0, &|u| pieces(u, 8, 2)),
        of(["8, 16 pieces of 2^-u", "8 pieces of 2^-u"], 1.0, &|u| {
            pieces(u, 8, 1)
        }),
        of(["8, 16 pieces of 2^-u", "16 pieces of 2^-u"], 1.0, &|u| {
            pieces(u, 16, 1)
        }),
    ])
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    /// Within the approximation error of the structure and one ulp of rounding: for linear pieces
    /// half a chord's sagitta, for all others less.
    #[test]
    fn errors_are_those_of_their_structure() {
        let found = others().unwrap();
        let of = |name: &str| found.iter().find(|m| m.name == name).unwrap().max_ulp;
        for (name, pieces) in [("8 pieces of 2^-u", 8.0), ("16 pieces of 2^-u", 16.0)] {
            let sagitta: f64 = OUTPUT_UNIT * (LN_2 / pieces).powi(2) / 16.0;
            assert!(
                of(name) > sagitta * 0.9 && of(name) < sagitta + 1.0,
                "{name}: {}",
                of(name)
            );
        }
        for name in [
            "CORDIC, 19 turns",
            "radix 8, J = 3, tail",
            "8 parabolas of 2^-u",
            "table and e^z - 1 - z (as FloPoCo)",
            "divided by 8, squared three times",
        ] {
            assert!(of(name) > 0.5 && of(name) < 1.0, "{name}: {}", of(name));
        }
    }
}
