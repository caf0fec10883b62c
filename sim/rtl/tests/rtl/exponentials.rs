//! What can stand in the restoring engine's place: straight pieces, radix 4 and
//! early out, every input through the Verilated unit, and whole scenes.
use potamoi_cycles::{Exponents, Stalls, vector_cycles};
use potamoi_formats::config::Config;
use potamoi_formats::units::{OpCode, VectorOp};
use potamoi_reference::ReferenceUnits;
use potamoi_reference::exact_exponential::ExactExponential;
use potamoi_reference::exponential::ReferenceExponential;
use potamoi_reference::observer::Observed;
use potamoi_reference::trace_recorder::{Limits, Recorder};
use potamoi_reference::widths::budget;
use potamoi_rtl::verify::{Injection, Settings, Verifier};
use potamoi_rtl::{EngineKind, VectorBatch, VectorUnit};
use potamoi_units::vector_unit::error_bound;

use crate::scenes_common::{garden_through, lantern_through, verified};

/// The command that runs these tests again.
const AGAIN: &str = "cargo test -p potamoi-rtl --test rtl exponentials";

fn config(text: &str) -> Config {
    Config::from_toml(text, "test").unwrap_or_else(|e| panic!("{text}: {e}"))
}

/// Knobs, most that the error may be, vectors' interval (0 with an early out) and
/// latency.
const FORMS: [(&str, f64, u64, u64); 8] = [
    ("form = \"piecewise\"\npipelined = true", 1.04, 1, 3),
    (
        "form = \"piecewise\"\npipelined = true\npieces = 128",
        0.68,
        1,
        3,
    ),
    (
        "form = \"piecewise\"\npipelined = true\nbase = \"two\"",
        1.039,
        1,
        2,
    ),
    (
        "form = \"piecewise\"\npipelined = true\npieces = 128\nbase = \"two\"",
        0.675,
        1,
        2,
    ),
    (
        "form = \"radix-4\"\niterations = 4\ntail = true",
        0.812,
        7,
        8,
    ),
    (
        "form = \"radix-4\"\niterations = 4\ntail = true\npipelined = true",
        0.812,
        1,
        8,
    ),
    ("form = \"radix-4\"\niterations = 8", 0.99, 10, 11),
    ("early_out = true", 0.9906, 0, 21),
];

/// Equal to the twin in every bit, as far from the function as stated, monotone,
/// and without a bubble.
#[test]
fn every_input_of_each_kind_of_form() {
    every_input(&[FORMS[1], FORMS[5], FORMS[7]]);
}

#[test]
#[ignore = "exhaustive; run with make test-full"]
fn every_input_of_the_other_forms() {
    every_input(&[0, 2, 3, 4, 6].map(|form| FORMS[form]));
}

fn every_input(forms: &[(&str, f64, u64, u64)]) {
    let codes: Vec<i32> = (0..65_536).collect();
    let zeros = vec![0; codes.len()];
    for &(knobs, limit, interval, latency) in forms {
        let config = config(&format!(
            "[vu]\nlanes = 4\nops = [\"exp\"]\n[vu.exp]\n{knobs}"
        ));
        let exp = &config.vu.exp;
        let unit = VectorUnit::build(&config).unwrap();
        let batch = VectorBatch {
            op: VectorOp::new(OpCode::Exp),
            a: &codes,
            b: &zeros,
        };
        let run = unit.run(&[batch], &Stalls::NONE, 0).unwrap();
        let twin = ReferenceExponential::new(exp);
        for (u, y) in codes.iter().zip(&run.results) {
            let expected = twin.exp(*u);
            assert_eq!(
                *y, expected,
                "vector_unit: exp of code {u} is {y}, expected {expected}\n{knobs}\nagain: {AGAIN}"
            );
        }
        let reference = ExactExponential::in_base(exp.input, exp.base).unwrap();
        let error = reference.measure(exp.output_bits, |u| run.results[u as usize]);
        let (first, last) = (run.vectors[0], run.vectors[run.vectors.len() - 1]);
        let span = last.0 - first.0;
        println!(
            "{}: at most {:.4} ulp, mean {:.4}, budget {:.4}; a vector every {:.3} cycles, latency {}",
            knobs.replace('\n', ", "),
            error.max_ulp,
            error.mean,
            budget(exp),
            span as f64 / (run.vectors.len() - 1) as f64,
            first.1 - first.0,
        );
        assert!(
            error.max_ulp <= limit.min(budget(exp)),
            "{knobs}: {error:?}"
        );
        if let Some(bound) = error_bound(&config, OpCode::Exp).unwrap() {
            assert!(error.max_ulp <= bound.ulp, "{knobs}: {error:?} {bound:?}");
        }
        assert!(error.monotone, "{knobs}");
        assert_eq!(first.1 - first.0, latency, "{knobs}");
        let closed = vector_cycles(&config, &[(OpCode::Exp, codes.as_slice())]).unwrap();
        assert_eq!(run.totals.cycles, closed.elapsed, "{knobs}");
        assert_eq!(run.totals.busy, closed.busy, "{knobs}");
        if interval > 0 {
            let vectors = codes.len() as u64 / 4;
            assert_eq!(span, (vectors - 1) * interval, "{knobs}");
        } else {
            let average = span as f64 / (run.vectors.len() - 1) as f64;
            assert!((average - 15.63).abs() < 0.02, "{average}");
        }
    }
}

/// A lane's result does not depend on its neighbours, who make it wait: the
/// same operands in vectors of 24 mixed ones, and one by one.
#[test]
fn an_early_out_gives_the_same_whatever_the_neighbours() {
    let codes: Vec<i32> = (0..4800).map(|i| (i * 40_503) & 0xffff).collect();
    let zeros = vec![0; codes.len()];
    let mut runs = [1, 24].map(|lanes| {
        let config = config(&format!(
            "[vu]\nlanes = {lanes}\nops = [\"exp\"]\n[vu.exp]\nearly_out = true"
        ));
        let batch = VectorBatch {
            op: VectorOp::new(OpCode::Exp),
            a: &codes,
            b: &zeros,
        };
        let unit = VectorUnit::build(&config).unwrap();
        unit.run(&[batch], &Stalls::NONE, 0).unwrap()
    });
    let [alone, together] = &mut runs;
    assert_eq!(alone.results, together.results);
    let average = |cycles: u64, vectors: u64| cycles as f64 / vectors as f64;
    let (one, all) = (
        average(alone.totals.cycles, 4800),
        average(together.totals.cycles, 200),
    );
    println!("scattered operands: {one:.2} cycles a vector of one lane, {all:.2} of 24");
    assert!(one < 15.8 && all > 19.8, "{one} {all}");
}

/// Of the gathering unit next to nothing, which is the same for all.
fn settings(engine: EngineKind, vector_every: u64, inject: Option<Injection>) -> Settings {
    Settings {
        engine,
        seed: 3,
        gather_every: 1000,
        vector_every,
        splat_every: 1,
        inject,
        rtl: None,
        excerpt: None,
    }
}

/// Splats and voxels, with and without stalls; and a fault in each form is
/// found.
#[test]
fn both_scenes_pass_with_straight_pieces() {
    both_scenes_pass(&[FORMS[1].0]);
}

#[test]
#[ignore = "exhaustive; run with make test-full"]
fn both_scenes_pass_with_every_form() {
    both_scenes_pass(&[0, 4, 5, 6, 7].map(|form| FORMS[form].0));
}

/// Not with base two: no renderer folds log2 e into its powers.
fn both_scenes_pass(forms: &[&str]) {
    for knobs in forms {
        let config = config(&format!(
            "[gu]\nbanks = 4\nports = 1\nsegments = 4\n[vu]\nlanes = 2\n[vu.exp]\n{knobs}"
        ));
        let mut none = |_| {};
        let every = settings(EngineKind::Verilator, 6, None);
        let mut verifier = Verifier::new(&config, every, &mut none);
        verified(&mut verifier, |units| garden_through(units, 12)).unwrap();
        verified(&mut verifier, |units| lantern_through(units, &config, 16)).unwrap();
        assert_eq!(verifier.failure(), None, "{knobs}");
        let v = verifier.vector_report();
        assert_eq!(v.cycles, v.cycles_predicted, "{knobs}");
        assert!(v.elements > 4_000, "{knobs}: {v:?}");

        let faulty = settings(EngineKind::Interpreter, 60, Some(Injection::Exp));
        let mut verifier = Verifier::new(&config, faulty, &mut none);
        verified(&mut verifier, |units| lantern_through(units, &config, 16)).unwrap_err();
        let failure = verifier.failure().unwrap();
        assert_eq!(failure.mismatch.module, "vector_unit", "{knobs}");
    }
}

/// Cycles of a splat scene's exponentials with an early out: of one lane, and of
/// vectors as long as their slowest lane.
#[test]
fn an_early_out_on_splats() {
    let early = config("[vu.exp]\nearly_out = true");
    let mut twins = ReferenceUnits::new(&early);
    let mut recorder = Recorder::new(Limits::NONE);
    let mut units = Observed::new(&mut twins, &early).by(&mut recorder);
    garden_through(&mut units, 96).unwrap();
    let exps: Vec<_> = recorder
        .computed
        .iter()
        .filter(|c| c.op.code == OpCode::Exp)
        .map(|c| (OpCode::Exp, c.a.as_slice()))
        .collect();
    let mut averages = vec![];
    for lanes in [1, 4, 8, 24] {
        let config = config(&format!(
            "[vu]\nlanes = {lanes}\n[vu.exp]\nearly_out = true"
        ));
        let cycles = vector_cycles(&config, &exps).unwrap();
        let average = cycles.busy as f64 / cycles.vectors as f64;
        let elements: usize = exps.iter().map(|(_, a)| a.len()).sum();
        println!(
            "garden, {elements} exponentials, {lanes} lanes: {average:.2} of 20 cycles a vector"
        );
        averages.push(average);
    }
    let exponents = Exponents::of(&config("[vu.exp]\nearly_out = true"));
    let (op, a) = exps[0];
    assert_eq!(
        exponents.least(op, a),
        a.iter().map(|a| exponents.least(op, &[*a])).min().unwrap()
    );
    assert!(averages.is_sorted(), "{averages:?}");
    assert!(averages[0] < 20.0 && averages[3] <= 20.0, "{averages:?}");
}

/// What bounds of pixels are made of, the formula, is never below what the netlist's own analysis
/// finds, and that is never below the largest error of all inputs.
#[test]
fn the_netlist_loses_no_more_than_the_formula_allows() {
    let mut closest = [0.0f64; 2];
    for n in [6, 8, 11, 14, 16, 20, 27] {
        for (guard_a, guard_c, f) in [(0, 1, 16), (2, 3, 12), (6, 1, 16), (3, 3, 20)] {
            for form in ["", "tail = true", "form = \"radix-4\"\ntail = true"] {
                let steps = if form.contains("radix") { n / 2 } else { n };
                let config = config(&format!(
                    "[vu]\nlanes = 1\nops = [\"exp\"]\n[vu.exp]\niterations = {}\naccumulator_bits = {}\nconstant_bits = {}\noffset = {}\noutput_bits = {f}\n{form}",
                    steps.max(2),
                    f + guard_a,
                    (f + guard_c).max(n + 1),
                    n % 3 - 1
                ));
                let exp = &config.vu.exp;
                let bound = error_bound(&config, OpCode::Exp).unwrap().unwrap();
                let twin = ReferenceExponential::new(exp);
                let reference = ExactExponential::in_base(exp.input, exp.base).unwrap();
                let error = reference.measure(exp.output_bits, |u| twin.exp(u)).max_ulp;
                let limit = budget(exp);
                let of = format!("{}\nagain: {AGAIN}::the_netlist", bound.ulp);
                assert!(error <= bound.ulp, "{exp:?}: {error}, bound {of}");
                assert!(bound.ulp <= limit, "{exp:?}: formula {limit}, bound {of}");
                closest[0] = closest[0].max(error / bound.ulp);
                closest[1] = closest[1].max(bound.ulp / limit);
            }
        }
    }
    // Neither is idle.
    assert!(closest.iter().all(|c| *c > 0.98), "{closest:?}");
}

/// The same of one-minus-exp, at operands of all sizes, which are brought to the constants' bits
/// first.
#[test]
fn one_minus_exp_is_within_its_netlists_bound() {
    for knobs in [
        "",
        "iterations = 8",
        "tail = true\niterations = 8",
        "early_out = true",
        "form = \"piecewise\"\npipelined = true\npieces = 128",
    ] {
        let config = config(&format!(
            "[vu]\nlanes = 1\nops = [\"exp\", \"one-minus-exp\"]\n[vu.exp]\n{knobs}"
        ));
        let exp = &config.vu.exp;
        let bound = error_bound(&config, OpCode::OneMinusExp).unwrap().unwrap();
        let (twin, bits) = (ReferenceExponential::new(exp), exp.one_minus_frac_bits);
        let one = 2f64.powi(exp.output_bits as i32);
        let worst = (0..1i32 << 20)
            .map(|i| {
                let s = ((i64::from(i) * i64::from(i)) >> (36 - bits)) as i32;
                let exact = -one * (-f64::from(s) * 2f64.powi(-(bits as i32))).exp_m1();
                // The largest code stands for 1, too.
                (f64::from(twin.one_minus_exp(s)) - exact.min(one - 1.0)).abs()
            })
            .fold(0.0, f64::max);
        println!("{knobs:?}: {worst:.4} of {:.4}", bound.ulp);
        assert!(
            worst <= bound.ulp,
            "{knobs}: {worst}, bound {bound:?}\nagain: {AGAIN}::one_minus"
        );
        assert!(worst > 0.3 * bound.ulp, "{knobs}: {worst}, bound {bound:?}");
    }
}
