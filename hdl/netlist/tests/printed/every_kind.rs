//! One module a width, in which every kind of node stands once by itself.

use std::collections::BTreeSet;
use std::sync::Arc;

use num_bigint::BigInt;
use potamoi_formats::fixed::Rounding;
use potamoi_netlist::{Module, ModuleBuilder, Signal, Ty};

/// Widths around the word sizes of the simulators.
pub(crate) const WIDTHS: [u32; 16] = [
    1, 2, 3, 31, 32, 33, 63, 64, 65, 127, 128, 129, 511, 512, 513, 1024,
];

pub(crate) const ROUNDINGS: [Rounding; 3] = [Rounding::Floor, Rounding::HalfUp, Rounding::HalfEven];

struct Sheet {
    m: ModuleBuilder,
    prefix: &'static str,
}

impl Sheet {
    fn show(&mut self, name: &str, s: Signal) {
        self.m.output(&format!("{}_{name}", self.prefix), s, "");
    }
}

/// Every operation on values of this width, unsigned and signed.
pub(crate) fn module(width: u32) -> Arc<Module> {
    let mut sheet = Sheet {
        m: ModuleBuilder::new(&format!("every_kind_{width}")),
        prefix: "u",
    };
    let amount = sheet.m.input("amount", Ty::u(11), "shift amount");
    let choose = sheet.m.input("choose", Ty::bit(), "");
    let index = sheet.m.input("index", Ty::u(2), "");
    for (prefix, ty) in [("u", Ty::u(width)), ("s", Ty::s(width))] {
        sheet.prefix = prefix;
        let a = sheet.m.input(&format!("{prefix}_a"), ty, "");
        let b = sheet.m.input(&format!("{prefix}_b"), ty, "");
        let c = sheet.m.input(&format!("{prefix}_c"), ty, "");
        arithmetic(&mut sheet, a, b);
        comparisons(&mut sheet, a, b);
        pieces(&mut sheet, a, b);
        shifts(&mut sheet, a, amount);
        conversions(&mut sheet, a);
        choices(&mut sheet, [a, b, c], choose, index);
        state(&mut sheet, [a, b], choose);
    }
    sheet.m.finish().expect("a sound module")
}

/// The cases of a width, in order: all, or the first two where values are so
/// wide that simulators take their time.
fn some(width: u32, cases: &[u32]) -> BTreeSet<u32> {
    let count = if width > 129 { 2 } else { cases.len() };
    cases[..count].iter().copied().collect()
}

fn arithmetic(t: &mut Sheet, a: Signal, b: Signal) {
    let s = [
        ("and", t.m.and(a, b)),
        ("or", t.m.or(a, b)),
        ("xor", t.m.xor(a, b)),
        ("not", t.m.not(a)),
        ("neg", t.m.neg(a)),
        ("add", t.m.add(a, b)),
        ("sub", t.m.sub(a, b)),
        ("mul", t.m.mul(a, b)),
        ("any", t.m.any(a)),
        ("all", t.m.all(a)),
        ("parity", t.m.parity(a)),
    ];
    for (name, s) in s {
        t.show(name, s);
    }
    for (name, value) in [("max", a.ty().max()), ("min", a.ty().min())] {
        let lit = t.m.lit(value.clone(), a.ty());
        let sum = t.m.add(a, lit);
        t.show(&format!("plus_{name}"), sum);
        let param = format!("{}_{name}", t.prefix.to_uppercase());
        let param = t.m.param(&param, value, a.ty(), "the end of the type");
        let is = t.m.eq(a, param);
        t.show(&format!("is_{name}"), is);
    }
}

fn comparisons(t: &mut Sheet, a: Signal, b: Signal) {
    let bits = [
        ("eq", t.m.eq(a, b)),
        ("ne", t.m.ne(a, b)),
        ("lt", t.m.lt(a, b)),
        ("le", t.m.le(a, b)),
        ("gt", t.m.gt(a, b)),
        ("ge", t.m.ge(a, b)),
    ];
    for (name, bit) in bits {
        t.show(name, bit);
    }
    let bits = bits.map(|b| b.1);
    let any = t.m.any_of(&bits);
    t.show("any_of", any);
    let all = t.m.all_of(&bits[..3]);
    t.show("all_of", all);
    // What Verilog's contexts would widen: a wrapped sum and a complement.
    let sum = t.m.add(a, b);
    let wrapped = t.m.lt(sum, a);
    t.show("sum_wrapped", wrapped);
    let not = t.m.not(a);
    let complement = t.m.eq(not, b);
    t.show("is_complement", complement);
}

fn pieces(t: &mut Sheet, a: Signal, b: Signal) {
    let w = a.width();
    let low = t.m.slice(a, 0, w.div_ceil(2));
    t.show("low_half", low);
    let high = t.m.slice(a, w / 2, w - w / 2);
    t.show("high_half", high);
    let top = t.m.bit(a, w - 1);
    t.show("top", top);
    let cat = t.m.cat(&[a, top, b]);
    t.show("cat", cat);
    let copies = t.m.repeat(a, 2);
    t.show("repeat", copies);
    let mask = t.m.repeat(top, w);
    t.show("mask", mask);
    // Slices of what has no name yet.
    let sum = t.m.add(a, b);
    let sum_top = t.m.bit(sum, w - 1);
    t.show("sum_top", sum_top);
    let middle = t.m.slice(cat, w / 2, w + 1);
    t.show("cat_middle", middle);
}

fn shifts(t: &mut Sheet, a: Signal, amount: Signal) {
    let w = a.width();
    let short = t.m.truncate(amount, 32 - w.leading_zeros());
    for (name, by) in [("far", amount), ("near", short)] {
        let left = t.m.shl(a, by);
        t.show(&format!("shl_{name}"), left);
        let right = t.m.shr(a, by);
        t.show(&format!("shr_{name}"), right);
    }
    // Sums under shifts: the carry must not come back.
    let sum = t.m.add(a, a);
    let half = t.m.shr(sum, short);
    t.show("sum_shr", half);
    let by = some(w, &[1, w - 1, 0, w / 2, w, w + 1]);
    for by in by {
        let left = t.m.shl_const(a, by);
        t.show(&format!("shl_{by}"), left);
        let right = t.m.shr_const(a, by);
        t.show(&format!("shr_{by}"), right);
    }
}

fn conversions(t: &mut Sheet, a: Signal) {
    let w = a.width();
    let wider = some(w, &[w + 1, 2 * w, w, w + 31]);
    for wider in wider {
        let wide = t.m.extend(a, wider);
        t.show(&format!("extend_{wider}"), wide);
    }
    let cut = t.m.truncate(a, w.div_ceil(2));
    t.show("truncate", cut);
    let cast = if a.signed() {
        t.m.as_unsigned(a)
    } else {
        t.m.as_signed(a)
    };
    let wide = t.m.extend(cast, w + 2);
    t.show("cast", wide);
    let drops = some(w, &[1, w - 1, 0, 2, w / 2]);
    for drop in drops.into_iter().filter(|d| *d < w) {
        for rounding in ROUNDINGS {
            let rounded = t.m.round(a, drop, rounding);
            t.show(
                &format!("round_{drop}_{rounding:?}").to_lowercase(),
                rounded,
            );
        }
    }
    let to = some(w, &[w - 1, w / 2, 1, 2, w, w + 1, w + 33]);
    for width in to.into_iter().filter(|t| *t > 0) {
        for ty in [Ty::u(width), Ty::s(width)] {
            let held = t.m.saturate(a, ty);
            t.show(&format!("saturate_{ty}"), held);
            let clipped = t.m.saturated(a, ty);
            t.show(&format!("saturated_{ty}"), clipped);
        }
    }
}

fn choices(t: &mut Sheet, [a, b, c]: [Signal; 3], choose: Signal, index: Signal) {
    let mux = t.m.mux(choose, a, b);
    t.show("mux", mux);
    let three = t.m.select(index, &[a, b, c]);
    t.show("select_3", three);
    let four = t.m.select(index, &[c, b, a, b]);
    t.show("select_4", four);
    let six = t.m.select(index, &[a, b, c, b, a, c]);
    t.show("select_6", six);
    let wide = t.m.extend(index, 40);
    let far = t.m.select(wide, &[b, c]);
    t.show("select_far", far);
}

fn state(t: &mut Sheet, [a, b]: [Signal; 2], enable: Signal) {
    let p = t.prefix;
    let reset = if a.signed() {
        a.ty().min()
    } else {
        BigInt::from(1)
    };
    let always = t.m.reg(&format!("{p}_sum"), a.ty(), reset);
    let sum = t.m.add(always, a);
    t.m.set_next(always, sum);
    t.show("reg", always);
    let held = t.m.reg(&format!("{p}_held"), b.ty(), 0);
    t.m.set_next_if(held, enable, b);
    t.show("reg_enabled", held);
    let latest = t.m.data_reg(&format!("{p}_latest"), a.ty());
    t.m.set_next(latest, a);
    t.show("data_reg", latest);
    // Data is compared from the first cycle on: reset loads it.
    let awake = t.m.reg(&format!("{p}_started"), Ty::bit(), 0);
    let on = t.m.lit(1, Ty::bit());
    t.m.set_next(awake, on);
    let asleep = t.m.not(awake);
    let load = t.m.or(enable, asleep);
    let taken = t.m.data_reg(&format!("{p}_taken"), b.ty());
    t.m.set_next_if(taken, load, b);
    t.show("data_reg_enabled", taken);
    t.m.output_low_in_reset(&format!("{p}_awake"), enable, "");
}
