//! Published methods of others, measured on the same inputs and rounded to the same output.

use potamoi_formats::config::Config;
use potamoi_reference::exact_exponential::ExactExponential;

use super::{INPUT_UNIT, OUTPUT_UNIT, Peer};
use crate::ExploreError;

/// The nearest code; 1 saturates at the largest.
fn code(value: f64) -> i32 {
    (value * OUTPUT_UNIT).round().min(OUTPUT_UNIT - 1.0) as i32
}

/// A table of `entries` over 0..8, each at its centre.
fn table(entries: i32, u: i32) -> i32 {
    let step = 65536 / entries;
    let middle = f64::from(u / step * step) + f64::from(step) / 2.0;
    code((-middle * INPUT_UNIT).exp())
}

/// The table of a public splat rasteriser: 2048 entries by squared distances below 8, which are
/// exponents below 4, each at its start; 0 beyond.
fn by_distance(u: i32) -> i32 {
    let squared = 2.0 * f64::from(u) * INPUT_UNIT;
    match squared < 8.0 {
        true => (65_535.0 * (-(squared * 256.0).floor() / 512.0).exp()).round() as i32,
        false => 0,
    }
}

/// S. Kim et al., "I-BERT: Integer-only BERT Quantization", ICML 2021: a quadratic over (-ln 2, 0]
/// with exact coefficients.
fn i_bert(u: i32) -> i32 {
    let u = f64::from(u) * INPUT_UNIT;
    let halvings = (u / std::f64::consts::LN_2).floor();
    let p = halvings * std::f64::consts::LN_2 - u;
    code((0.3585 * (p + 1.353).powi(2) + 0.344) * (-halvings).exp2())
}

/// N. Schraudolph, "A Fast, Compact Approximation of the Exponential Function", Neural Computation
/// 11, 1999: the exponent is written into a float's exponent field, without his correction.
fn schraudolph(u: i32) -> i32 {
    let x = -f64::from(u) * INPUT_UNIT;
    let bits = (x / std::f64::consts::LN_2 + 127.0) * f64::from(1 << 23);
    code(f64::from(f32::from_bits(bits as u32)))
}

/// A 32-bit floating-point result that is too large by so many ulp.
fn off_by(ulps: impl Fn(f32) -> f64, u: i32) -> i32 {
    let x = -(u as f32) * INPUT_UNIT as f32;
    let y = f64::from(x).exp();
    let last = 2f64.powi(y.log2().floor() as i32 - 23);
    code(y + ulps(x) * last)
}

pub(super) fn peers() -> Result<Vec<Peer>, ExploreError> {
    let paper = Config::paper().vu.exp;
    let fail = |e: &dyn std::fmt::Display| ExploreError::Inconclusive(e.to_string());
    let reference = ExactExponential::of(paper.input).map_err(|e| fail(&e))?;
    let peer = |name, of: &dyn Fn(i32) -> i32| Peer {
        name,
        max_ulp: reference.measure(paper.output_bits, of).max_ulp,
    };
    let within = |counts: &dyn Fn(i32) -> bool| {
        let own = reference.codes().filter(|u| counts(*u));
        let errors = own.map(|u| reference.error(u, by_distance(u), paper.output_bits).abs());
        errors.fold(0.0, f64::max)
    };
    Ok(vec![
        peer("the C library's expf", &|u| {
            code(f64::from((-(u as f32) * INPUT_UNIT as f32).exp()))
        }),
        peer("CUDA's ex2.approx (2 ulp of 32 bits)", &|u| {
            off_by(|_| 2.0, u)
        }),
        peer("CUDA's __expf (2 + |1.173 x| ulp)", &|u| {
            off_by(|x| 2.0 + f64::from((1.173 * x).abs()).floor(), u)
        }),
        peer("a table of 2048 entries", &|u| table(2048, u)),
        Peer {
            name: "a rasteriser's table of 2048, to d^2 = 8",
            max_ulp: within(&|u| f64::from(u) * INPUT_UNIT < 4.0),
        },
        Peer {
            name: "that table beyond, where it is 0",
            max_ulp: within(&|u| f64::from(u) * INPUT_UNIT >= 4.0),
        },
        peer("a table of 1024 entries", &|u| table(1024, u)),
        peer("I-BERT's quadratic", &i_bert),
        peer("Schraudolph's", &schraudolph),
    ])
}
