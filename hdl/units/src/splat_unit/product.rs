//! Products of two clocks: sums of a few rows each, and their sum.
//!
//! A row is a factor where a bit of the other is set, at that bit's place. One stage for a whole product
//! would set the unit's clock.

use std::sync::Arc;

use potamoi_netlist::{IrErrors, Module, ModuleBuilder, Signal, Ty};

use crate::circuits::tree_sum;

/// Rows that one stage adds at most: fewer of wide factors, whose carries take longer.
const fn most_rows(factor: u32) -> u32 {
    if factor > 24 { 6 } else { 9 }
}

/// Sum of the rows of a factor at bits `from` to `to - 1` of another; the first row has place 0. `name` is
/// that of the factor as wide as the sum.
fn sum_of_rows(
    m: &mut ModuleBuilder,
    factor: Signal,
    by: Signal,
    (from, to): (u32, u32),
    name: &str,
) -> Signal {
    let wide = m.extend(factor, factor.width() + to - from);
    let wide = m.name(wide, name);
    let none = m.lit(0, wide.ty());
    let sign = by.ty().signed.then(|| by.width() - 1);
    let mut rows = vec![];
    let mut of_sign = None;
    for place in from..to {
        let set = m.bit(by, place);
        let moved = m.shl_const(wide, place - from);
        let row = m.mux(set, moved, none);
        match sign {
            Some(sign) if sign == place => of_sign = Some(row),
            _ => rows.push(row),
        }
    }
    let sum = match rows.is_empty() {
        true => none,
        false => tree_sum(m, &rows),
    };
    match of_sign {
        Some(row) => m.sub(sum, row),
        None => sum,
    }
}

/// Product of a factor and an unsigned number of few bits. `name` is that of the factor as wide as it.
pub(super) fn times(m: &mut ModuleBuilder, factor: Signal, by: Signal, name: &str) -> Signal {
    sum_of_rows(m, factor, by, (0, by.width()), name)
}

/// The multiples 0 to 15 of a number, each in the clock after; even ones are shifted odd ones.
pub(super) fn multiples(m: &mut ModuleBuilder, of: Signal, enable: Signal) -> Vec<Signal> {
    let one = m.extend(of, of.width() + 4);
    let one = m.name(one, "once");
    let times = |m: &mut ModuleBuilder, two: u32| m.shl_const(one, two);
    let [two, four, eight, sixteen] = [1, 2, 3, 4].map(|power| times(m, power));
    let eight = m.name(eight, "eight_times");
    let three = m.add(two, one);
    let three = m.name(three, "three_times");
    let five = m.add(four, one);
    let five = m.name(five, "five_times");
    let odd = [
        one,
        three,
        five,
        m.sub(eight, one),
        m.add(eight, one),
        m.add(eight, three),
        m.add(eight, five),
        m.sub(sixteen, one),
    ];
    let held: Vec<Signal> = (1u32..)
        .step_by(2)
        .zip(odd)
        .map(|(factor, value)| {
            let register = m.data_reg(&format!("times_{factor}"), value.ty());
            m.set_next_if(register, enable, value);
            register
        })
        .collect();
    let none = m.lit(0, one.ty());
    let of_factor = |m: &mut ModuleBuilder, factor: u32| {
        let twos = factor.trailing_zeros();
        m.shl_const(held[(factor >> twos) as usize / 2], twos)
    };
    let others = (1..16).map(|factor| of_factor(m, factor));
    std::iter::once(none).chain(others).collect()
}

/// Builds `splat_product` of two types, both signed or both unsigned, as wide as both together.
///
/// # Errors
/// The netlist's own checks.
pub(super) fn product(factor: Ty, by: Ty) -> Result<Arc<Module>, IrErrors> {
    let name = format!("splat_product_{}x{}", factor.width, by.width);
    let mut builder = ModuleBuilder::new(&name);
    let m = &mut builder;
    m.doc("product of the factors of the clock before, not registered.");
    let advance = m.input("advance", Ty::bit(), "takes the factors over");
    let a = m.input("a", factor, "");
    let b = m.input("b", by, "");
    let all = Ty {
        width: factor.width + by.width,
        ..factor
    };
    let groups = by.width.div_ceil(most_rows(factor.width));
    let rows = by.width.div_ceil(groups);
    let mut parts = vec![];
    for group in 0..groups {
        let (from, to) = (group * rows, by.width.min((group + 1) * rows));
        let sum = sum_of_rows(m, a, b, (from, to), &format!("a_at_{from}"));
        let register = m.data_reg(&format!("rows_{from}_to_{}", to - 1), sum.ty());
        m.set_next_if(register, advance, sum);
        let wide = m.extend(register, all.width);
        parts.push(m.shl_const(wide, from));
    }
    let product = tree_sum(m, &parts);
    m.output("product", product, "");
    builder.finish()
}

/// Product of two signals, of the clock before: the caller registers it.
///
/// # Errors
/// The netlist's own checks.
pub(super) fn product_of(
    m: &mut ModuleBuilder,
    name: &str,
    (a, b): (Signal, Signal),
    advance: Signal,
) -> Result<Signal, IrErrors> {
    let module = product(a.ty(), b.ty())?;
    let links = [("advance", advance), ("a", a), ("b", b)];
    let instance = m.instance(name, &module, &links);
    Ok(m.out(instance, "product"))
}
