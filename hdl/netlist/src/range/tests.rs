#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use std::sync::Arc;

use num_bigint::BigInt;
use potamoi_formats::fixed::Rounding;

use super::{Interval, ranges};
use crate::{InterpretError, Interpreter, Module, ModuleBuilder, Signal, Ty};

fn proves(b: ModuleBuilder) -> (Arc<Module>, super::Ranges) {
    let module = b.finish().unwrap();
    let found = ranges(&module).unwrap();
    (module, found)
}

fn refuses(b: ModuleBuilder) -> String {
    ranges(&b.finish().unwrap()).unwrap_err().to_string()
}

fn is(ranges: &super::Ranges, path: &str, low: impl Into<BigInt>, high: impl Into<BigInt>) {
    assert_eq!(ranges.of(path), Some((low.into(), high.into())), "{path}");
}

#[test]
fn wrapping_keeps_an_interval_that_does_not_cross_the_edge() {
    let wrap = |low: i64, high: i64, ty| Interval::new(low, high).wrap(ty);
    assert_eq!(wrap(256, 258, Ty::u(8)), Interval::new(0, 2));
    assert_eq!(wrap(250, 258, Ty::u(8)), Interval::new(0, 255));
    assert_eq!(wrap(-3, -1, Ty::u(8)), Interval::new(253, 255));
    assert_eq!(wrap(-3, 1, Ty::s(8)), Interval::new(-3, 1));
    assert_eq!(wrap(128, 130, Ty::s(8)), Interval::new(-128, -126));
    assert_eq!(Interval::new(-128, 127).ty(false), Ty::s(8));
    assert_eq!(Interval::new(0, 128).ty(true), Ty::s(9));
    assert_eq!(Interval::new(0, 0).ty(false), Ty::u(1));
    assert_eq!(Interval::new(-1, 0).ty(true), Ty::s(1));
}

#[test]
fn exact_sums_are_proven_or_refused_with_the_width_that_would_do() {
    let build = |bits: u32| {
        let mut b = ModuleBuilder::new("sum");
        let x = b.input("x", Ty::u(8), "");
        b.assume_range(x, 0, 200, "codes");
        let wide = b.extend(x, bits);
        let twice = b.add(wide, wide);
        let four = b.add(twice, twice);
        let four = b.exact(four);
        let four = b.name(four, "four");
        b.output("y", four, "");
        b
    };
    let (_, found) = proves(build(10));
    is(&found, "four", 0, 800);
    is(&found, "x", 0, 200);
    assert_eq!(
        refuses(build(9)),
        "module sum: four: is to be exact, but u9 does not hold 0 to 800; u10 would do"
    );
}

#[test]
fn cuts_of_signed_values_are_seen_through() {
    let mut b = ModuleBuilder::new("cuts");
    let x = b.input("x", Ty::s(16), "");
    b.assume_range(x, -100, 90, "small");
    let cut = b.truncate(x, 8);
    let cut = b.exact(cut);
    let cut = b.name(cut, "cut");
    let left = b.shl_const(cut, 1);
    let left = b.name(left, "left");
    let right = b.shr_const(x, 3);
    let right = b.name(right, "right");
    let rounded = b.round(x, 3, Rounding::HalfEven);
    let rounded = b.name(rounded, "rounded");
    let held = b.saturate(x, Ty::s(7));
    let held = b.name(held, "held");
    for (name, s) in [("a", left), ("b", right), ("c", rounded), ("d", held)] {
        b.output(name, s, "");
    }
    let (_, found) = proves(b);
    is(&found, "cut", -100, 90);
    is(&found, "left", -128, 127);
    is(&found, "right", -13, 11);
    is(&found, "rounded", -12, 11);
    is(&found, "held", -64, 63);
}

/// A sum that starts again when told, of `bits`, with a contract.
fn accumulator(bits: u32, most: u32) -> ModuleBuilder {
    let mut b = ModuleBuilder::new("total");
    let (first, en) = (
        b.input("first", Ty::bit(), ""),
        b.input("en", Ty::bit(), ""),
    );
    let term = b.input("term", Ty::s(8), "");
    let acc = b.reg("acc", Ty::s(bits), 0);
    let wide = b.extend(term, bits);
    let sum = b.add(acc, wide);
    let sum = b.exact(sum);
    let sum = b.name(sum, "sum");
    let next = b.mux(first, wide, sum);
    b.set_next_if(acc, en, next);
    b.accumulator(acc, term, most, "a vertex each");
    b.output("y", acc, "");
    b
}

#[test]
fn a_count_of_terms_bounds_an_accumulator() {
    let (_, found) = proves(accumulator(11, 8));
    is(&found, "acc", -1024, 1016);
    is(&found, "sum", -1024, 1016);
    let text = refuses(accumulator(10, 8));
    assert_eq!(
        text,
        "module total: acc: holds at most 8 terms (a vertex each): -1024 to 1016, which s10 does \
         not hold; s11 would do"
    );
    assert!(refuses(accumulator(11, 9)).contains("s12 would do"));
}

#[test]
fn without_a_contract_a_sum_is_not_proven() {
    let mut b = ModuleBuilder::new("total");
    let term = b.input("term", Ty::u(8), "");
    let acc = b.reg("acc", Ty::u(40), 0);
    let wide = b.extend(term, 40);
    let sum = b.add(acc, wide);
    let sum = b.exact(sum);
    b.set_next(acc, sum);
    b.output("y", acc, "");
    let text = refuses(b);
    assert!(
        text.contains("of acc, an unnamed node: is to be exact, but u40"),
        "{text}"
    );
    assert!(text.contains("u41 would do"), "{text}");
}

#[test]
fn what_is_no_sum_of_terms_is_refused() {
    type Change = fn(&mut ModuleBuilder, Signal, Signal) -> Signal;
    let build = |next: Change| {
        let mut b = ModuleBuilder::new("total");
        let term = b.input("term", Ty::s(8), "");
        let acc = b.reg("acc", Ty::s(16), 0);
        let wide = b.extend(term, 16);
        let next = next(&mut b, acc, wide);
        let next = b.name(next, "next");
        b.set_next(acc, next);
        b.accumulator(acc, term, 8, "eight");
        b.output("y", acc, "");
        b.output("same", term, "");
        b
    };
    proves(build(ModuleBuilder::add));
    let changes: [Change; 4] = [
        ModuleBuilder::sub,
        |b, acc, term| {
            let twice = b.add(term, term);
            b.add(acc, twice)
        },
        |b, acc, _| b.not(acc),
        |b, acc, term| {
            let low = b.truncate(acc, 5);
            let low = b.extend(low, 16);
            b.add(low, term)
        },
    ];
    for (i, change) in changes.into_iter().enumerate() {
        let text = refuses(build(change));
        assert!(
            text.contains("acc is declared to hold at most 8 terms")
                || text.contains("acc is summed up through this"),
            "{i}: {text}"
        );
    }
    let text = refuses(build(|b, _, _| b.lit(5000, Ty::s(16))));
    assert!(
        text.contains("starts again from this, 5000 to 5000, outside -1024 to 1016"),
        "{text}"
    );
}

/// Features weighted by codes that sum to 2^8, as in a reducer.
fn weighted(acc_bits: u32, piped: bool) -> ModuleBuilder {
    let mut b = ModuleBuilder::new("reducer");
    let (first, skip) = (
        b.input("first", Ty::bit(), ""),
        b.input("skip", Ty::bit(), ""),
    );
    let feature = b.input("feature", Ty::s(8), "");
    let weight = b.input("weight", Ty::s(10), "");
    let product = b.mul(feature, weight);
    let product = if piped {
        let held = b.reg("product", product.ty(), 0);
        b.set_next(held, product);
        held
    } else {
        product
    };
    let product = if acc_bits < 18 {
        b.truncate(product, acc_bits)
    } else {
        b.extend(product, acc_bits)
    };
    let none = b.lit(0, Ty::u(8));
    let bits = b.as_unsigned(feature);
    let whole = b.cat(&[bits, none]);
    let whole = b.as_signed(whole);
    let whole = if acc_bits < 16 {
        b.truncate(whole, acc_bits)
    } else {
        b.extend(whole, acc_bits)
    };
    let term = b.mux(skip, whole, product);
    let acc = b.reg("acc", Ty::s(acc_bits), 0);
    let sum = b.add(acc, term);
    let sum = b.exact(sum);
    let next = b.mux(first, term, sum);
    b.set_next(acc, next);
    b.weighted_accumulator(acc, feature, 256, "weights sum to one");
    let rounded = b.round(acc, 8, Rounding::HalfEven);
    let rounded = b.name(rounded, "rounded");
    b.output("y", rounded, "");
    b
}

#[test]
fn weights_that_sum_to_one_bound_an_accumulator() {
    for piped in [false, true] {
        for bits in [16, 18, 30] {
            let (_, found) = proves(weighted(bits, piped));
            is(&found, "acc", -32768, 32512);
            is(&found, "rounded", -128, 127);
        }
        let text = refuses(weighted(15, piped));
        assert!(text.contains("s15 does not hold; s16 would do"), "{text}");
    }
}

#[test]
fn registers_reach_a_fixpoint_and_counters_all_of_their_type() {
    let mut b = ModuleBuilder::new("pipe");
    let x = b.input("x", Ty::u(8), "");
    b.assume_range(x, 3, 7, "digits");
    let mut s = x;
    for i in 0..20 {
        let r = b.reg(&format!("stage_{i}"), Ty::u(8), 5);
        b.set_next(r, s);
        s = r;
    }
    let count = b.reg("count", Ty::u(8), 0);
    let one = b.lit(1, Ty::u(8));
    let more = b.add(count, one);
    b.set_next(count, more);
    b.output("y", s, "");
    b.output("n", count, "");
    let (_, found) = proves(b);
    is(&found, "stage_19", 3, 7);
    is(&found, "count", 0, 255);
}

#[test]
fn instances_are_judged_by_what_they_are_given() {
    let inner = |assume: bool| {
        let mut b = ModuleBuilder::new("twice");
        let x = b.input("x", Ty::u(8), "");
        if assume {
            b.assume_range(x, 0, 100, "a percentage");
        }
        let y = b.add(x, x);
        b.output("y", y, "");
        b.finish().unwrap()
    };
    let outer = |assume: bool, most: u32| {
        let mut b = ModuleBuilder::new("top");
        let x = b.input("x", Ty::u(8), "");
        b.assume_range(x, 0, most, "codes");
        let module = inner(assume);
        let first = b.instance("first", &module, &[("x", x)]);
        let y = b.out(first, "y");
        let low = b.slice(y, 0, 4);
        let low = b.extend(low, 8);
        let second = b.instance("second", &module, &[("x", low)]);
        let z = b.out(second, "y");
        b.output("y", y, "");
        b.output("z", z, "");
        b
    };
    let (_, found) = proves(outer(false, 100));
    is(&found, "first.x", 0, 100);
    is(&found, "first_y", 0, 200);
    is(&found, "second.x", 0, 15);
    is(&found, "second_y", 0, 30);
    proves(outer(true, 100));
    assert_eq!(
        refuses(outer(true, 101)),
        "module top: x: input x of instance first is 0 to 101, but twice relies on 0 to 100"
    );
}

#[test]
fn the_interpreter_keeps_to_what_was_proven() {
    let (module, found) = proves(accumulator(11, 8));
    let mut run = Interpreter::new(&module, 3).with_ranges(&found).unwrap();
    let [rst_n, first, en, term] = ["rst_n", "first", "en", "term"].map(|n| run.port(n).unwrap());
    run.clock().unwrap();
    run.set_u64(rst_n, 1).unwrap();
    run.set_u64(en, 1).unwrap();
    run.set_u64(term, 0x80).unwrap();
    for _ in 0..3 {
        run.set_u64(first, 1).unwrap();
        run.clock().unwrap();
        run.set_u64(first, 0).unwrap();
        for _ in 1..8 {
            run.clock().unwrap();
        }
    }
    // The ninth term breaks the promise: -1152 wraps to 896.
    run.set_u64(term, 0x81).unwrap();
    run.set_u64(en, 0).unwrap();
    run.clock().unwrap();
    let (other, _) = proves(accumulator(12, 8));
    let foreign = Interpreter::new(&other, 3).with_ranges(&found);
    assert!(matches!(foreign, Err(InterpretError::ForeignRanges(_))));

    let (module, found) = proves(accumulator(12, 8));
    let mut run = Interpreter::new(&module, 3).with_ranges(&found).unwrap();
    let [rst_n, en, term] = ["rst_n", "en", "term"].map(|n| run.port(n).unwrap());
    run.clock().unwrap();
    run.set_u64(rst_n, 1).unwrap();
    run.set_u64(en, 1).unwrap();
    run.set_u64(term, 0x80).unwrap();
    for _ in 0..8 {
        run.clock().unwrap();
    }
    let text = run.clock().unwrap_err().to_string();
    assert_eq!(
        text,
        "acc is -1152 after 10 clock edges: expected -1024 to 1016, a vertex each"
    );
}

#[test]
fn a_declared_input_range_is_checked_as_it_runs() {
    let mut b = ModuleBuilder::new("percent");
    let x = b.input("x", Ty::u(8), "");
    b.assume_range(x, 0, 100, "a percentage");
    b.output("y", x, "");
    let (module, found) = proves(b);
    let mut run = Interpreter::new(&module, 1).with_ranges(&found).unwrap();
    let x = run.port("x").unwrap();
    run.set_u64(x, 100).unwrap();
    run.eval().unwrap();
    run.set_u64(x, 101).unwrap();
    assert!(matches!(run.eval(), Err(InterpretError::OutOfRange { signal, .. }) if signal == "x"));
}
