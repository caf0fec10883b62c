//! Small circuits used by both units.

use num_bigint::BigInt;
use potamoi_netlist::{ModuleBuilder, Signal, Ty};

/// Width in bits of a number from 0 to n.
#[must_use]
pub(crate) fn bits_for(n: u32) -> u32 {
    n.max(1).ilog2() + 1
}

/// Number of set bits.
pub(crate) fn popcount(m: &mut ModuleBuilder, bits: &[Signal]) -> Signal {
    let ty = Ty::u(bits_for(bits.len() as u32));
    let wide: Vec<_> = bits.iter().map(|bit| m.extend(*bit, ty.width)).collect();
    tree_sum(m, &wide)
}

/// Sum of one or more terms as a balanced tree; their type must hold it.
pub(crate) fn tree_sum(m: &mut ModuleBuilder, terms: &[Signal]) -> Signal {
    let mut terms = terms.to_vec();
    while terms.len() > 1 {
        let pairs = terms.chunks(2);
        terms = pairs
            .map(|pair| match pair {
                [a, b] => m.add(*a, *b),
                _ => pair[0],
            })
            .collect();
    }
    terms[0]
}

/// `a + 1`.
pub(crate) fn plus_one(m: &mut ModuleBuilder, a: Signal) -> Signal {
    let one = m.lit(1, a.ty());
    m.add(a, one)
}

/// `a == value`.
pub(crate) fn is(m: &mut ModuleBuilder, a: Signal, value: u32) -> Signal {
    let v = m.lit(value, a.ty());
    m.eq(a, v)
}

/// Register of a counter port: it counts by `step`, or by 1, when `en`, is cleared by `clear`, and
/// saturates.
pub(crate) fn counter(
    m: &mut ModuleBuilder,
    name: &str,
    bits: u32,
    clear: Signal,
    en: Signal,
    step: Option<Signal>,
) -> Signal {
    let reg = m.reg(name, Ty::u(bits), 0);
    let zero = m.lit(0, Ty::u(bits));
    let more = match step {
        None => {
            let full = m.all(reg);
            let more = plus_one(m, reg);
            m.mux(full, reg, more)
        }
        Some(step) => {
            let (x, y) = (m.extend(reg, bits + 1), m.extend(step, bits + 1));
            let sum = m.add(x, y);
            let sum = m.name(sum, &format!("{name}_sum"));
            m.saturate(sum, reg.ty())
        }
    };
    let next = m.mux(clear, zero, more);
    let changes = m.or(clear, en);
    m.set_next_if(reg, changes, next);
    reg
}

/// A sticky flag: set by `set`, cleared by `clear`.
pub(crate) fn sticky(m: &mut ModuleBuilder, name: &str, clear: Signal, set: Signal) -> Signal {
    let reg = m.reg(name, Ty::bit(), 0);
    let held = m.or(reg, set);
    let no_clear = m.not(clear);
    let next = m.and(held, no_clear);
    m.set_next(reg, next);
    reg
}

/// Next value of an index that runs from 0 to `end` and wraps.
pub(crate) fn wrapping(m: &mut ModuleBuilder, index: Signal, end: Signal) -> Signal {
    let last = m.eq(index, end);
    let next = plus_one(m, index);
    let zero = m.lit(0, index.ty());
    m.mux(last, zero, next)
}

/// A mask of `width` ones.
#[must_use]
pub(crate) fn ones(width: u32) -> BigInt {
    (BigInt::from(1) << width) - 1
}

/// A value a clock later; a constant stays one.
pub(crate) fn held(m: &mut ModuleBuilder, name: &str, value: Signal) -> Signal {
    if m.is_fixed(value) {
        return value;
    }
    let reg = m.data_reg(name, value.ty());
    m.set_next(reg, value);
    reg
}

/// A value after so many stages, and the shift register that delays it, whose first stage is lowest.
pub(crate) fn delayed(
    m: &mut ModuleBuilder,
    name: &str,
    value: Signal,
    stages: u32,
    reset: Option<u8>,
) -> (Signal, Option<Signal>) {
    if stages == 0 {
        return (value, None);
    }
    let width = value.width();
    let ty = Ty::u(stages * width);
    let all = match reset {
        Some(reset) => m.reg(name, ty, reset),
        None => m.data_reg(name, ty),
    };
    let earlier = stages - 1;
    let next = match earlier {
        0 => value,
        _ => {
            let held = m.slice(all, 0, earlier * width);
            m.cat(&[held, value])
        }
    };
    m.set_next(all, next);
    (m.slice(all, earlier * width, width), Some(all))
}
