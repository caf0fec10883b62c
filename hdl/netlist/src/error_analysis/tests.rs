#![allow(clippy::unwrap_used)]

use std::sync::Arc;

use potamoi_formats::fixed::Rounding;

use super::IntervalInterpreter;
use crate::range::Interval;
use crate::{Interpreter, Module, ModuleBuilder, Signal, Ty};

/// A module of one input x, U8, and one output y.
fn built(make: impl Fn(&mut ModuleBuilder, Signal) -> Signal) -> Arc<Module> {
    let mut b = ModuleBuilder::new("sketch");
    let x = b.input("x", Ty::u(8), "");
    let y = make(&mut b, x);
    b.output("y", y, "");
    b.finish().unwrap()
}

/// What y is off for x of a range.
fn off(module: &Module, low: u8, high: u8) -> Option<[f64; 2]> {
    let mut machine = IntervalInterpreter::new(module, &["y"], &[]).unwrap();
    let (x, y) = (machine.find("x").unwrap(), machine.find("y").unwrap());
    machine.set(x, Interval::new(low, high));
    machine.settle();
    machine.off(y)
}

/// Bounds hold for every x, and some x comes to within `slack` of each of them.
fn is_off(module: &Arc<Module>, ideal: impl Fn(f64) -> f64, slack: f64) {
    let bounds = off(module, 0, 255).unwrap();
    let mut run = Interpreter::new(module, 1);
    let (x, y) = (run.port("x").unwrap(), run.port("y").unwrap());
    let (mut least, mut most) = (f64::MAX, f64::MIN);
    for value in 0..=255u8 {
        run.set_u64(x, value.into()).unwrap();
        run.eval().unwrap();
        let found = run.get_u64(y).unwrap() as f64 - ideal(f64::from(value));
        (least, most) = (least.min(found), most.max(found));
        let one = off(module, value, value).unwrap();
        assert!(
            one[0] <= found + 1e-9 && found <= one[1] + 1e-9,
            "{value}: {found} {one:?}"
        );
    }
    assert!(
        bounds[0] <= least && most <= bounds[1],
        "{least} {most} {bounds:?}"
    );
    assert!(
        least - bounds[0] <= slack && bounds[1] - most <= slack,
        "{least} {most} {bounds:?}"
    );
}

#[test]
fn bits_that_are_cut_off() {
    let cut = built(|b, x| b.slice(x, 3, 5));
    is_off(&cut, |x| x / 8.0, 1e-9);
    let shifted = built(|b, x| {
        let by = b.lit(2, Ty::u(3));
        b.shr(x, by)
    });
    is_off(&shifted, |x| x / 4.0, 1e-9);
    for rounding in [Rounding::Floor, Rounding::HalfUp, Rounding::HalfEven] {
        let rounded = built(|b, x| b.round(x, 3, rounding));
        is_off(&rounded, |x| x / 8.0, 0.13);
    }
}

/// The last bit that is dropped rounds: off by half, not by one and a half.
#[test]
fn a_bit_that_is_cut_and_added_again() {
    let rounded = built(|b, x| {
        let whole = b.slice(x, 1, 7);
        let up = b.bit(x, 0);
        let up = b.extend(up, 7);
        b.add(whole, up)
    });
    let bounds = off(&rounded, 0, 250).unwrap();
    assert!(
        bounds[0].abs() < 1e-300 && (bounds[1] - 0.5).abs() < 1e-9,
        "{bounds:?}"
    );
    assert_eq!(off(&rounded, 0, 255), None, "255 wraps");
}

#[test]
fn products_and_sums_of_what_is_off() {
    let module = built(|b, x| {
        let high = b.slice(x, 4, 4);
        let low = b.slice(x, 1, 7);
        let product = b.mul(high, low);
        let wide = b.extend(low, 11);
        b.add(product, wide)
    });
    is_off(&module, |x| (x / 16.0).mul_add(x / 2.0, x / 2.0), 9.0);
}

/// A remainder is below what it was compared with, so that it does not wrap.
#[test]
fn sides_know_what_was_compared() {
    let module = built(|b, x| {
        let mut rest = x;
        for weight in [128, 64, 32] {
            let weight = b.lit(weight, Ty::u(8));
            let take = b.ge(rest, weight);
            let less = b.sub(rest, weight);
            rest = b.mux(take, less, rest);
        }
        b.name(rest, "rest")
    });
    let mut machine = IntervalInterpreter::new(&module, &["y"], &[]).unwrap();
    machine.set(machine.find("x").unwrap(), Interval::new(0, 255));
    machine.settle();
    let y = machine.find("y").unwrap();
    assert_eq!(*machine.value(y), Interval::new(0, 31));
    assert_eq!(machine.off(y).unwrap().map(|v| v.abs() < 1e-300), [true; 2]);
}

/// Of three multiples the largest that fits: each is subtracted where it was chosen.
#[test]
fn choices_know_what_chose_them() {
    let module = built(|b, x| {
        let mut part = b.lit(0, Ty::u(8));
        for multiple in [64, 128, 192] {
            let multiple = b.lit(multiple, Ty::u(8));
            let take = b.ge(x, multiple);
            part = b.mux(take, multiple, part);
        }
        b.sub(x, part)
    });
    let mut machine = IntervalInterpreter::new(&module, &["y"], &[]).unwrap();
    machine.set(machine.find("x").unwrap(), Interval::new(0, 255));
    machine.settle();
    let y = machine.find("y").unwrap();
    assert_eq!(*machine.value(y), Interval::new(0, 63));
    assert!(machine.off(y).is_some());
}

#[test]
fn registers_keep_what_they_are_off() {
    let mut b = ModuleBuilder::new("halves");
    let (x, load) = (b.input("x", Ty::u(8), ""), b.input("load", Ty::bit(), ""));
    let held = b.reg("held", Ty::u(8), 0);
    let by = b.lit(1, Ty::u(1));
    let half = b.shr(held, by);
    let next = b.mux(load, x, half);
    b.set_next(held, next);
    b.output("y", held, "");
    let module = b.finish().unwrap();
    let mut machine = IntervalInterpreter::new(&module, &["y"], &[]).unwrap();
    let [x, load, y] = ["x", "load", "y"].map(|n| machine.find(n).unwrap());
    machine.set(x, Interval::new(0, 255));
    let mut found = vec![];
    for first in [1, 0, 0, 0] {
        machine.set(load, Interval::new(first, first));
        machine.settle();
        machine.clock();
        machine.settle();
        found.push(machine.off(y).unwrap()[0]);
    }
    for (found, expected) in found.into_iter().zip([0.0, -0.5, -0.75, -0.875]) {
        assert!((found - expected).abs() < 1e-9, "{found} {expected}");
    }
}

/// The last value that a comparison lets through is let through, and the next is not.
#[test]
fn comparisons_end_where_they_say() {
    let range = |less_or_equal: bool, kept: bool| {
        let module = built(|b, x| {
            let (limit, other) = (b.lit(100, Ty::u(8)), b.lit(95, Ty::u(8)));
            let other = if kept { other } else { b.lit(105, Ty::u(8)) };
            let so = if less_or_equal {
                b.le(x, limit)
            } else {
                b.lt(x, limit)
            };
            let [t, e] = if kept { [x, other] } else { [other, x] };
            b.mux(so, t, e)
        });
        let mut machine = IntervalInterpreter::new(&module, &["y"], &[]).unwrap();
        machine.set(machine.find("x").unwrap(), Interval::new(90, 110));
        machine.settle();
        machine.value(machine.find("y").unwrap()).clone()
    };
    assert_eq!(range(true, true), Interval::new(90, 100));
    assert_eq!(range(false, true), Interval::new(90, 99));
    assert_eq!(range(true, false), Interval::new(101, 110));
    assert_eq!(range(false, false), Interval::new(100, 110));
}

#[test]
fn a_register_that_may_have_taken_over_holds_either() {
    let mut b = ModuleBuilder::new("either");
    let (x, take) = (b.input("x", Ty::u(8), ""), b.input("take", Ty::bit(), ""));
    let held = b.reg("held", Ty::u(8), 3);
    b.set_next_if(held, take, x);
    b.output("y", held, "");
    let module = b.finish().unwrap();
    let mut machine = IntervalInterpreter::new(&module, &["y"], &[]).unwrap();
    let [x, take, y] = ["x", "take", "y"].map(|n| machine.find(n).unwrap());
    machine.set(x, Interval::new(7, 9));
    for (low, high, expected) in [(0, 0, [3, 3]), (0, 1, [3, 9]), (1, 1, [7, 9])] {
        machine.reset();
        machine.set(take, Interval::new(low, high));
        machine.settle();
        machine.clock();
        machine.settle();
        assert_eq!(*machine.value(y), Interval::new(expected[0], expected[1]));
    }
}
