//! The exponential at its ends, at each multiple of ln 2, and where rounding is hardest.

use std::sync::Arc;

use potamoi_formats::config::{ExpConfig, ExpForm};
use potamoi_formats::fixed::Format;

use super::{Case, Worst, cases};
use potamoi_reference::exact_exponential::ExactExponential;
use potamoi_reference::exponential::ReferenceExponential;
use potamoi_reference::widths::budget;

cases!(
    every_operand,
    negative_powers,
    zero,
    past_the_range,
    positive_powers,
    multiples_of_ln_2,
    hardest_to_round,
);

const ULP: &str = "ulp of U0.16";

fn twin() -> ReferenceExponential {
    ReferenceExponential::new(&ExpConfig::default())
}

fn reference() -> Arc<ExactExponential> {
    ExactExponential::of(ExpConfig::default().input).unwrap()
}

/// Largest error of results against 120 bits, over some operands.
fn errors(codes: impl Iterator<Item = i32>, exp: impl Fn(i32) -> i32) -> Worst {
    let reference = reference();
    Worst::of(codes.map(|u| reference.error(u, exp(u), 16)))
}

/// The recurrence in 16 fraction bits, with each shift truncated and the truncation error not
/// centred.
fn sixteen_bits(u: i32) -> i32 {
    let constant = |value: f64| (value * 65_536.0).round() as i64;
    let ln_2 = 2f64.ln();
    let mut remain = constant(12.0 * ln_2) - (i64::from(u) << 3);
    let mut k = 12;
    for digit in [8, 4, 2, 1] {
        let step = constant(f64::from(digit) * ln_2);
        if remain >= step {
            remain -= step;
            k -= digit;
        }
    }
    let mut power = 1i64 << 16;
    for i in 1..=16 {
        let step = constant(2f64.powi(-i).ln_1p());
        if remain >= step {
            remain -= step;
            power += power >> i;
        }
    }
    (power >> k).min(65_535) as i32
}

fn every_operand() -> Case {
    let all = || 0..65_536;
    Case {
        name: "exp of every operand, the smallest among them",
        naive: "the recurrence in 16 bits, cut off, not centred",
        unit: ULP,
        fails: errors(all(), sixteen_bits),
        bound: 1.0,
        from: "one unit of the format",
        ours: errors(all(), |u| twin().exp(u)),
    }
}

/// As printed, every logarithm is positive and no subtraction fires below zero.
fn negative_powers() -> Case {
    let literal = ExpConfig {
        form: ExpForm::Literal,
        input: Format::signed(1, 14),
        output_bits: 14,
        ..ExpConfig::default()
    };
    let (printed, ours) = (ReferenceExponential::new(&literal), twin());
    let unit = 2f64.powi(-16);
    // -1 to 0 in steps of both formats.
    let codes = || 0..=8192;
    let exact = |u: i32| (-f64::from(u) / 8192.0).exp();
    let fails = codes().map(|u| f64::from(printed.exp(-2 * u)) * 2f64.powi(-14) - exact(u));
    Case {
        name: "exp of a negative power",
        naive: "the recurrence as the paper prints it",
        unit: "absolute",
        fails: Worst::of(fails),
        bound: unit,
        from: "one unit of U0.16",
        ours: Worst(errors(codes(), |u| ours.exp(u)).0 * unit),
    }
}

fn zero() -> Case {
    Case {
        name: "exp of 0",
        naive: "65,536 cut to 16 bits",
        unit: ULP,
        fails: errors(0..1, |_| i32::from((1.0f64 * 65_536.0) as u32 as u16)),
        bound: 0.0,
        from: "the largest code is the nearest",
        ours: errors(0..1, |u| twin().exp(u)),
    }
}

fn past_the_range() -> Case {
    let codes = [65_536, 65_537, 70_000, 1 << 17, 1 << 20, 1 << 30, i32::MAX];
    let off = |exp: &dyn Fn(i32) -> i32| {
        let exact = |u: i32| (-f64::from(u) / 8192.0).exp() * 65_536.0;
        Worst::of(codes.map(|u| f64::from(exp(u)) - exact(u)))
    };
    let ours = twin();
    Case {
        name: "exp past the range, down to minus infinity",
        naive: "the operand's low 16 bits",
        unit: ULP,
        fails: off(&|u| ours.exp(u & 0xffff)),
        bound: (-8f64).exp() * 65_536.0 + 1.0,
        from: "all that is left there is exp(-8), and one unit",
        ours: off(&|u| ours.exp(u)),
    }
}

fn positive_powers() -> Case {
    let codes = [-1, -2, -8192, -65_535, -65_536, i32::MIN];
    let ours = twin();
    let off = |exp: &dyn Fn(i32) -> i32| Worst::of(codes.map(|u| f64::from(exp(u) - 65_535)));
    Case {
        name: "exp of a positive power",
        naive: "the operand's low 16 bits",
        unit: ULP,
        fails: off(&|u| ours.exp(u & 0xffff)),
        bound: 0.0,
        from: "held at the largest code",
        ours: off(&|u| ours.exp(u)),
    }
}

fn multiples_of_ln_2() -> Case {
    let codes = || {
        (0..=11).flat_map(|m| {
            let at = (f64::from(m) * 2f64.ln() * 8192.0).round() as i32;
            (at - 2..=at + 2).filter(|u| (0..65_536).contains(u))
        })
    };
    // Just below a multiple the quotient is one too large and the remainder wraps.
    let naive = |u: i32| {
        let log2_e = (2f64.ln().recip() * 256.0).ceil() as i32;
        let k = (u * log2_e) >> 21;
        let r = (u - (f64::from(k) * 2f64.ln() * 8192.0).round() as i32) as u16;
        let power = (-f64::from(r) / 8192.0).exp() * 2f64.powi(16 - k);
        power.round().min(65_535.0) as i32
    };
    Case {
        name: "exp around each m ln 2",
        naive: "k by log2(e) in 8 bits, the remainder unsigned",
        unit: ULP,
        fails: errors(codes(), naive),
        bound: 1.0,
        from: "one unit of the format on either side",
        ours: errors(codes(), |u| twin().exp(u)),
    }
}

/// Code 15967 lies 2^-16.1 units from a midpoint, closer than 32-bit floats tell.
fn hardest_to_round() -> Case {
    let fine = ReferenceExponential::new(&ExpConfig {
        iterations: 27,
        ..ExpConfig::default()
    });
    let float = |u: i32| (((-u as f32 / 8192.0).exp() * 65_536.0).round()).min(65_535.0) as i32;
    let misrounded = |exp: &dyn Fn(i32) -> i32| {
        let reference = reference();
        let wrong = (0..65_536).filter(|u| reference.error(*u, exp(*u), 16).abs() > 0.5);
        Worst(wrong.count() as f64)
    };
    Case {
        name: "exp at the hardest codes to round",
        naive: "32-bit floats, rounded",
        unit: "operands of 65,536 misrounded",
        fails: misrounded(&float),
        bound: 0.0,
        from: "27 iterations are correctly rounded",
        ours: misrounded(&|u| fine.exp(u)),
    }
}

#[test]
fn the_default_engine_is_within_its_budget() {
    assert!(errors(0..65_536, |u| twin().exp(u)).0 <= budget(&ExpConfig::default()));
}
