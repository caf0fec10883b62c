//! `2^-v` from a table of linear pieces, `v = u log2 e`.
//!
//! With `v = k + f` the power is `2^-(k+1) y`, `y = 2^(1-f)` in (1, 2]. On each piece y is a start
//! less a slope times the part of f within the piece.

use potamoi_formats::config::{Engine, ExpConfig};

use super::c_header::table;
use super::form::{Form, Raw};
use crate::logarithms::ln2;

/// Fraction bits in which pieces are computed.
const BITS: u32 = 62;

/// The table, and the factor that converts the operand to base two.
#[derive(Debug, Clone)]
pub(super) struct Piecewise {
    engine: Engine,
    /// Bits of f that select a piece.
    index_bits: u32,
    slope_bits: u32,
    /// `log2 e` and its fraction bits.
    scale: Option<(i64, u32)>,
    /// Start and slope of each piece.
    table: Vec<(i64, i64)>,
}

impl Piecewise {
    /// The table of a configuration. A configuration that breaks its rules yields a table that
    /// does not panic.
    pub(super) fn new(config: &ExpConfig) -> Self {
        let (engine, widths) = (config.engine(), config.piece_widths());
        let accumulator_bits = engine.accumulator_bits.min(40);
        let constant_bits = engine.constant_bits.min(40);
        let index_bits = widths.index_bits.min(10);
        let slope_bits = widths.slope_bits.min(40);
        let table = (0..1 << index_bits)
            .map(|i| piece(i, index_bits, accumulator_bits, slope_bits))
            .collect();
        Self {
            engine: Engine {
                accumulator_bits,
                constant_bits,
                ..engine
            },
            index_bits,
            slope_bits,
            scale: widths.scale_bits.map(|bits| {
                let bits = bits.min(38);
                (log2_e(bits), bits)
            }),
            table,
        }
    }
}

impl Form for Piecewise {
    fn power(&self, value: i64, _far: bool) -> Raw {
        let (bits, mut v) = (self.engine.constant_bits, i128::from(value));
        if let Some((factor, drop)) = self.scale {
            v = half_up(v * i128::from(factor), drop);
        }
        let within = bits.saturating_sub(self.index_bits);
        let fraction = v & ((1 << bits) - 1);
        let rest = fraction & ((1 << within) - 1);
        let piece = self.table.get((fraction >> within) as usize);
        let (start, slope) = piece.copied().unwrap_or_default();
        let drop = (self.slope_bits + bits).saturating_sub(self.engine.accumulator_bits);
        let fall = half_up(i128::from(slope) * rest, drop);
        Raw {
            accumulator: start - fall as i64,
            remain: rest as i64,
            exponent: -((v >> bits) as i32) - 1,
        }
    }

    fn c_power(&self) -> String {
        let (bits, slope_bits) = (self.engine.constant_bits, self.slope_bits);
        let accumulator_bits = self.engine.accumulator_bits;
        let within = bits.saturating_sub(self.index_bits);
        let (starts, slopes): (Vec<_>, Vec<_>) = self.table.iter().copied().unzip();
        let (scale, v) = match self.scale {
            None => ("", "(uint64_t)value".to_owned()),
            Some((factor, drop)) => (
                ", times log2 e and rounded half-up",
                format!("potamoi_exp_rounded_product((uint64_t)value, UINT64_C({factor}), {drop})"),
            ),
        };
        let drop = (slope_bits + bits).saturating_sub(accumulator_bits);
        format!(
            r"    /* A piece of 2^(1 - f), f the fraction of v: its start with {accumulator_bits} fraction bits, its
       slope with {slope_bits}. */
{starts}
{slopes}
    /* The exponent of two with {bits} fraction bits: the operand{scale}. */
    const uint64_t v = {v};
    const uint64_t fraction = v & UINT64_C({fraction_mask});
    const uint64_t rest = fraction & UINT64_C({rest_mask});
    const uint64_t piece = fraction >> {within};
    /* The fall within the piece is rounded half-up. */
    accumulator = starts[piece]
        - (int64_t)potamoi_exp_rounded_product((uint64_t)slopes[piece], rest, {drop});
    exponent = -(int32_t)(v >> {bits}) - 1;
",
            starts = table("int64_t", "starts", &starts),
            slopes = table("int64_t", "slopes", &slopes),
            fraction_mask = (1u64 << bits) - 1,
            rest_mask = (1u64 << within) - 1,
        )
    }
}

/// `value / 2^drop`, to nearest.
fn half_up(value: i128, drop: u32) -> i128 {
    if drop == 0 {
        value
    } else {
        (value + (1 << (drop - 1))) >> drop
    }
}

/// Start and slope of piece i. The slope is that of the chord, rounded. With it the curve bulges
/// downwards from its higher end to about the middle of the piece; the start lies halfway, so that
/// the errors are equal in magnitude.
fn piece(i: u32, index_bits: u32, accumulator_bits: u32, slope_bits: u32) -> (i64, i64) {
    let halves = index_bits + 1;
    let [left, middle, right] = [0, 1, 2].map(|h| falling(2 * i + h, halves));
    let slope = half_up((left - right) << index_bits, BITS - slope_bits);
    let fall = (slope << (BITS - slope_bits)) >> index_bits;
    let high = left.max(right + fall);
    let low = middle + fall / 2;
    let start = half_up(high + low, BITS + 1 - accumulator_bits);
    (start as i64, slope as i64)
}

/// `2^(1 - j / 2^bits)` by the series of `exp(-t)`, `t = j ln 2 / 2^bits`.
fn falling(j: u32, bits: u32) -> i128 {
    let t = (ln2(BITS) * i128::from(j)) >> bits;
    let (mut sum, mut term, mut n) = (0, 2i128 << BITS, 0);
    while term != 0 {
        sum += term;
        n += 1;
        term = -((term * t) >> BITS) / n;
    }
    sum
}

/// `log2 e`, to nearest.
fn log2_e(bits: u32) -> i64 {
    let one = 1i128 << (BITS + bits + 1);
    half_up(one / ln2(BITS), 1) as i64
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against double precision, whose error is far below a unit of 2^-40.
    #[test]
    fn powers_and_log2_e_agree_with_floating_point() {
        let unit = 2f64.powi(-(BITS as i32));
        for bits in 1..=11 {
            for j in 0..=1u32 << bits {
                let exact = (1.0 - f64::from(j) * 2f64.powi(-(bits as i32))).exp2();
                assert!(
                    (falling(j, bits) as f64 * unit - exact).abs() < 1e-15,
                    "{j}"
                );
            }
        }
        for bits in 4..=38 {
            let exact = std::f64::consts::LOG2_E * 2f64.powi(bits as i32);
            assert!((log2_e(bits) as f64 - exact).abs() <= 0.5001, "{bits}");
        }
    }

    /// A line from end to end lies above the curve everywhere: up to twice as
    /// far off as one moved halfway down.
    #[test]
    fn chords_are_twice_as_far_off() {
        for index_bits in [4i32, 6, 7] {
            let (mut moved, mut chord) = (0.0f64, 0.0f64);
            for i in 0..1u32 << index_bits {
                let (start, slope) = piece(i, index_bits as u32, 40, 40);
                let at = |x: f64| (1.0 - x * 2f64.powi(-index_bits)).exp2();
                let slope = slope as f64 * 2f64.powi(-40 - index_bits);
                for step in 0..=64 {
                    let part = f64::from(step) / 64.0;
                    let exact = at(f64::from(i) + part);
                    let off = |start: f64| (start - slope * part - exact).abs();
                    moved = moved.max(off(start as f64 * 2f64.powi(-40)));
                    chord = chord.max(off(at(f64::from(i))));
                }
            }
            // h^2 y'' / 16 with y'' = 2 (ln 2)^2 at f = 0.
            let formula = 2f64.powi(-2 * index_bits - 3) * std::f64::consts::LN_2.powi(2);
            assert!((moved / formula - 1.0).abs() < 0.05, "{moved} {formula}");
            assert!((chord / moved - 2.0).abs() < 0.05, "{chord} {moved}");
        }
    }
}
