#![allow(clippy::unwrap_used)]
use std::sync::LazyLock;

use super::*;
use crate::exponential::ReferenceExponential;
use potamoi_formats::config::Config;

const BOTH: [Logistic; 2] = [Logistic::Sigmoid, Logistic::Softplus];
static REFERENCE: LazyLock<LogisticReference> =
    LazyLock::new(|| LogisticReference::new(13).unwrap());

fn compute(twin: &ReferenceExponential, of: Logistic, code: i32) -> i32 {
    match of {
        Logistic::Sigmoid => twin.sigmoid(code),
        Logistic::Softplus => twin.softplus(code),
    }
}

/// n, tail, fraction bits of accumulator and constants, offset, F.
fn engine(n: u32, tail: bool, widths: (u32, u32, i32), f: u32) -> ExpConfig {
    ExpConfig {
        iterations: n,
        tail,
        accumulator_bits: Some(widths.0),
        constant_bits: Some(widths.1),
        offset: Some(widths.2),
        output_bits: f,
        ..ExpConfig::default()
    }
}

/// One call of the library a value, at 320 bits.
#[test]
fn values_are_good_to_120_bits() {
    let (p, rm) = (320, RoundingMode::ToEven);
    let mut consts = Consts::new().unwrap();
    let one = BigFloat::from_f64(1.0, p);
    let codes = (0..1 << 17)
        .step_by(1021)
        .chain([1, 511, 512, 513, (1 << 17) - 1, 1 << 17]);
    for code in codes {
        let argument = BigFloat::from_f64(-f64::from(code) / 8192.0, p);
        let e = argument.exp(p, rm, &mut consts);
        let y = one.add(&e, p, rm);
        let exact = [e.div(&y, p, rm), y.ln(p, rm, &mut consts)];
        let (sigmoid, softplus) = REFERENCE.falling[code as usize];
        for (exact, found) in exact.iter().zip([sigmoid, softplus]) {
            let scale = BigFloat::from_f64(2f64.powi(FRACTION as i32), p);
            let off = BigFloat::from_u128(found, p).sub(&exact.mul(&scale, p, rm), p, rm);
            assert!(off.abs() < BigFloat::from_f64(4.0, p), "{code}: {off}");
        }
    }
}

/// Both sides of 0, against double precision.
#[test]
fn values_agree_with_floating_point() {
    for code in (-REFERENCE.last()..=REFERENCE.last())
        .step_by(97)
        .chain([-1, 0, 1])
    {
        let x = f64::from(code) / 8192.0;
        let found = |of| REFERENCE.scaled(of, code, 16) as f64 * 2f64.powi(-ERROR_BITS);
        let sigmoid = (65_536.0 / (1.0 + (-x).exp())).min(65_535.0);
        let softplus = 65_536.0 * (x.max(0.0) + (-x.abs()).exp().ln_1p());
        assert!((found(Logistic::Sigmoid) - sigmoid).abs() < 1e-9, "{code}");
        assert!(
            (found(Logistic::Softplus) - softplus).abs() < 1e-9,
            "{code}"
        );
    }
}

/// Every code from -16 to 16 of the table in `docs/reference/vector-unit.md`.
#[test]
fn every_sigmoid_and_softplus() {
    let fields = include_str!("../../../../configs/fields.toml");
    let fields = Config::from_toml(fields, "fields").unwrap().vu.exp;
    let rows = [
        (ExpConfig::default(), [1.127, 0.832]),
        (fields, [0.731, 0.740]),
        (engine(9, true, (18, 19, 0), 16), [0.966, 1.013]),
        (engine(20, false, (22, 22, 0), 16), [0.553, 0.526]),
        (engine(12, true, (22, 22, 0), 16), [0.519, 0.526]),
        (engine(12, false, (17, 17, 0), 12), [1.1, 0.85]),
        (engine(14, false, (15, 15, 0), 8), [0.6, 0.6]),
    ];
    for (config, limits) in rows {
        let (twin, f) = (ReferenceExponential::new(&config), config.output_bits);
        for (of, limit) in BOTH.into_iter().zip(limits) {
            let found = REFERENCE.measure(of, f, |x| compute(&twin, of, x));
            let e = config.engine();
            println!(
                "n {}, tail {}, {}/{}/{}, F {f}: {of:?} at most {:.4} ulp, mean {:.4}",
                config.iterations,
                config.tail,
                e.accumulator_bits,
                e.constant_bits,
                e.offset,
                found.max_ulp,
                found.mean
            );
            assert!(found.max_ulp <= limit, "{config:?} {of:?}: {found:?}");
            assert!(found.monotone, "{config:?} {of:?}");
        }
    }
}

/// Truncation (2^-n, or 2^-2n with tail) and widths finer than the input's step
/// of 2^-13 make results monotone, whatever F; coarser ones need not.
#[test]
fn engines_finer_than_the_input_are_monotone() {
    finer_engines_are_monotone(&[8, 16], &[(14, false), (7, true)]);
}

#[test]
#[ignore = "exhaustive; run with make test-full"]
fn more_engines_finer_than_the_input_are_monotone() {
    let engines = [14, 15, 17, 20].map(|n| (n, false));
    finer_engines_are_monotone(&[8, 12, 16], &engines);
    finer_engines_are_monotone(&[8, 12, 16], &[(7, true), (10, true)]);
}

/// Of result bits, and iterations with or without tail.
fn finer_engines_are_monotone(results: &[u32], engines: &[(u32, bool)]) {
    let monotone = |config: &ExpConfig| {
        let twin = ReferenceExponential::new(config);
        BOTH.map(|of| {
            let found = REFERENCE.measure(of, config.output_bits, |x| compute(&twin, of, x));
            found.monotone
        })
    };
    results.into_par_iter().for_each(|&f| {
        for &(n, tail) in engines {
            for bits in [f + 2, f + 4, 20].map(|bits| bits.max(15)) {
                let config = engine(n, tail, (bits, bits, 0), f);
                assert_eq!(monotone(&config), [true; 2], "{config:?}");
            }
        }
    });
    for (f, n, bits) in [(8, 8, 18), (8, 10, 18), (10, 12, 12), (12, 12, 15)] {
        assert_ne!(
            monotone(&engine(n, false, (bits, bits, 0), f)),
            [true; 2],
            "{f} {n} {bits}"
        );
    }
}

/// At -16 and below the result is 0; at 16 and above it is the operand itself, in F bits, or
/// sigmoid's largest code.
#[test]
fn ends_are_exact() {
    for config in [
        ExpConfig::default(),
        engine(9, true, (18, 19, 0), 16),
        engine(27, false, (40, 40, 3), 20),
        engine(4, false, (8, 13, -1), 8),
    ] {
        let (twin, f) = (ReferenceExponential::new(&config), config.output_bits);
        for x in [16, 17, 100, 5000] {
            let code = x << 13;
            assert_eq!(
                (twin.sigmoid(-code), twin.softplus(-code)),
                (0, 0),
                "{config:?} {x}"
            );
            assert_eq!(twin.sigmoid(code), (1 << f) - 1, "{config:?} {x}");
            let linear = (i64::from(x) << f).min(i64::from(i32::MAX)) as i32;
            assert_eq!(twin.softplus(code), linear, "{config:?} {x}");
        }
        assert_eq!(twin.softplus(i32::MIN), 0);
        assert_eq!(twin.sigmoid(i32::MIN), 0);
        assert_eq!(twin.sigmoid(i32::MAX), (1 << f) - 1);
    }
}

/// No engine exceeds its error bound, and few bounds are loose.
#[test]
fn errors_stay_within_their_budgets() {
    let mut closest = [0.0f64; 2];
    for n in [2, 3, 5, 8, 11, 14, 17, 22, 31u32] {
        for (guard_a, guard_c, f) in [(0, 1, 16), (6, 6, 12), (4, 5, 16)] {
            for tail in [false, true] {
                let widths = (f + guard_a, (f + guard_c).max(n + 1), n as i32 % 3 - 1);
                let config = engine(n, tail, widths, f);
                let twin = ReferenceExponential::new(&config);
                for (of, closest) in BOTH.into_iter().zip(&mut closest) {
                    let found = REFERENCE.measure(of, f, |x| compute(&twin, of, x)).max_ulp;
                    let limit = logistic_budget(of, &config);
                    assert!(found <= limit, "{config:?} {of:?}: {found}, budget {limit}");
                    *closest = closest.max(found / limit);
                }
            }
        }
    }
    println!("closest to their budgets: {closest:?}");
    assert!(closest.iter().all(|c| *c > 0.45), "{closest:?}");
}

/// `ln(1 + exp(x))` and `1 / (1 + exp(-x))` evaluated literally, in the same 32 bits with F = 16
/// fraction bits, correctly rounded after every operation.
#[test]
fn naive_forms_fail() {
    let power = |x: i32| {
        let exact = (f64::from(x) / 8192.0).exp() * 65_536.0;
        exact.round().min(f64::from(i32::MAX))
    };
    let softplus = |x: i32| ((power(x) / 65_536.0).ln_1p() * 65_536.0).round() as i32;
    // exp(x) is past 2^15 from x = 10.4 on: softplus stays there.
    let naive = REFERENCE.measure(Logistic::Softplus, 16, softplus);
    assert!(naive.max_ulp > 360_000.0, "{naive:?}");
    // And 1 / (1 + exp(-x)) is some 2^-15 where it should be 0.
    let other = REFERENCE.measure(Logistic::Sigmoid, 16, |x| {
        (65_536.0 * 65_536.0 / (65_536.0 + power(-x)))
            .round()
            .min(65_535.0) as i32
    });
    assert!(other.max_ulp > 1.4, "{other:?}");
    // Without the split at 0, of the engine's own exponentials: they end at 1.
    let twin = ReferenceExponential::new(&ExpConfig::default());
    let own = |x: i32| ((f64::from(twin.exp(-x)) / 65_536.0).ln_1p() * 65_536.0).round() as i32;
    let naive = REFERENCE.measure(Logistic::Softplus, 16, own);
    assert!(naive.max_ulp > 1_000_000.0, "{naive:?}");
    // Single precision: exp(x) overflows at 89, and 1 + exp(-17) is 1.
    assert!(89f32.exp().ln_1p().is_infinite());
    assert_eq!((1.0 + (-17f32).exp()).ln(), 0.0);
}

/// A voxel's opacity `1 - (1 + exp(d))^(-interval)` is `1 - exp(-interval
/// softplus(d))`: softplus, a multiplication, one-minus-exp.
#[test]
fn densities_become_opacities() {
    let config = ExpConfig::default();
    let twin = ReferenceExponential::new(&config);
    let mut worst = 0.0f64;
    for d in (-16 << 13..16 << 13).step_by(37) {
        for interval in [1i64, 1 << 14, 40_000, 65_536] {
            // F and 16 fraction bits in, 20 out, half-up.
            let product = i64::from(twin.softplus(d)) * interval;
            let depth = ((product + (1 << 11)) >> 12).min(i64::from(i32::MAX)) as i32;
            let found = f64::from(twin.one_minus_exp(depth));
            let step = interval as f64 / 65_536.0;
            let exact = 1.0 - (1.0 + (f64::from(d) / 8192.0).exp()).powf(-step);
            worst = worst.max((found - (exact * 65_536.0).min(65_535.0)).abs());
        }
    }
    println!("opacities: at most {worst:.3} ulp");
    assert!(worst < 2.0, "{worst}");
}
