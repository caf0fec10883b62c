//! Start values of a record's forms: products of its factors and the offset of the tile's first pixel,
//! one half of an offset a clock.
//!
//! | clock | computes |
//! |---|---|
//! | 0 | the half of an offset, and its factor |
//! | 1 | rows of their product |
//! | 2 | the product |
//! | 3 | the sum, with the product at its half's place |

use potamoi_formats::record::MEAN;
use potamoi_netlist::{IrErrors, ModuleBuilder, Signal, Ty};

use super::formats::{START, STEP};
use super::product::product_of;
use crate::circuits::is;

/// Products of an entry: `q` of two halves first, since its rows are searched meanwhile; then `p` of four.
pub(super) const PHASES: u32 = 6;
/// The first of `p`.
const FIRST_OF_P: u32 = 2;
/// Clocks from a phase to its sum.
pub(super) const SUMMED: u32 = 4;
/// Bits of an offset from the mean.
const OFFSET: u32 = 33;
/// Bits of the lower half of an offset.
const HALF: u32 = 16;
/// Bits of a sum of products.
const SUM: u32 = STEP + OFFSET + 1;

/// An entry whose start values are computed.
pub(super) struct Multiplied {
    pub(super) tile: [Signal; 2],
    pub(super) centred: Signal,
    pub(super) mean: [Signal; 2],
    /// `L11`, `L21`, `L22`.
    pub(super) factor: [Signal; 3],
    pub(super) phase: Signal,
    /// The next clock begins a phase.
    pub(super) begins_phase: Signal,
}

/// A start value in its format, and whether it exceeds it.
pub(super) struct Start {
    pub(super) value: Signal,
    pub(super) is_far: Signal,
}

/// Start values of `p` and `q`.
///
/// # Errors
/// The netlist's own checks.
pub(super) fn start_values(
    m: &mut ModuleBuilder,
    entry: &Multiplied,
) -> Result<[Start; 2], IrErrors> {
    let half = half(m, entry);
    let [l11, l21, l22] = entry.factor;
    let factor = m.select(entry.phase, &[l22, l22, l11, l11, l21, l21]);
    let factor = m.name(factor, "next_factor");
    let mut register = |name: &str, value: Signal| {
        let register = m.data_reg(name, value.ty());
        m.set_next(register, value);
        register
    };
    let half = register("half", half);
    let factor = register("factor", factor);
    let fresh = m.reg("fresh_0", Ty::bit(), 0);
    m.set_next(fresh, entry.begins_phase);
    let mut step = (fresh, entry.phase);
    let mut after = |m: &mut ModuleBuilder, clock: u32| {
        let fresh = m.reg(&format!("fresh_{clock}"), Ty::bit(), 0);
        m.set_next(fresh, step.0);
        let phase = m.data_reg(&format!("phase_{clock}"), step.1.ty());
        m.set_next(phase, step.1);
        step = (fresh, phase);
        step
    };
    after(m, 1);
    after(m, 2);
    let summed = after(m, 3);
    let always = m.lit(1, Ty::bit());
    let product = product_of(m, "products", (factor, half), always)?;
    let term = m.data_reg("term", product.ty());
    m.set_next(term, product);
    let low = m.extend(term, SUM);
    let low = m.name(low, "term_wide");
    let high = m.shl_const(low, HALF);
    let is_high = m.bit(summed.1, 0);
    let term = m.mux(is_high, high, low);
    let term = m.name(term, "term_at_place");
    let p = accumulated(m, "p_sum", term, summed, (FIRST_OF_P, PHASES - 1));
    let q = accumulated(m, "q_sum", term, summed, (0, FIRST_OF_P - 1));
    Ok([in_format(m, p, START, "p"), in_format(m, q, START - 1, "q")])
}

/// The half of an offset that a phase multiplies. The first one comes before its offset is held.
fn half(m: &mut ModuleBuilder, entry: &Multiplied) -> Signal {
    let mut halves = vec![];
    let [dx, dy] = [0, 1].map(|i| {
        let offset = offset(m, entry.tile[i], entry.centred, entry.mean[i]);
        m.name(offset, ["dx", "dy"][i])
    });
    let [held_x, held_y] = [("dx_held", dx), ("dy_held", dy)].map(|(name, offset)| {
        let register = m.data_reg(name, offset.ty());
        m.set_next(register, offset);
        register
    });
    for (low, high) in [(dy, held_y), (held_x, held_x), (held_y, held_y)] {
        let low = m.slice(low, 0, HALF);
        let low = m.extend(low, HALF + 1);
        halves.push(m.as_signed(low));
        let high = m.slice(high, HALF, OFFSET - HALF);
        halves.push(m.as_signed(high));
    }
    let half = m.select(entry.phase, &halves);
    m.name(half, "next_half")
}

/// Offset of the first pixel's centre from the mean.
fn offset(m: &mut ModuleBuilder, tile: Signal, centred: Signal, mean: Signal) -> Signal {
    let fraction = MEAN.frac_bits() - 1;
    let (low, edge) = (m.lit(0, Ty::u(fraction)), m.lit(0, Ty::u(4)));
    let sign = m.lit(0, Ty::u(OFFSET - 16 - MEAN.frac_bits()));
    let corner = m.cat(&[sign, tile, edge, centred, low]);
    let corner = m.as_signed(corner);
    let mean = m.extend(mean, OFFSET);
    m.sub(corner, mean)
}

/// Sum of the terms of some phases; the first of them begins it.
fn accumulated(
    m: &mut ModuleBuilder,
    name: &str,
    term: Signal,
    (fresh, phase): (Signal, Signal),
    (first, last): (u32, u32),
) -> Signal {
    let register = m.data_reg(name, term.ty());
    let begins = is(m, phase, first);
    let more = m.add(register, term);
    let next = m.mux(begins, term, more);
    let (from, to) = (m.lit(first, phase.ty()), m.lit(last, phase.ty()));
    let within = match first {
        0 => m.le(phase, to),
        _ => m.ge(phase, from),
    };
    let here = m.and(within, fresh);
    m.set_next_if(register, here, next);
    register
}

/// A sum in the format of start values; within `bits` it is not far.
fn in_format(m: &mut ModuleBuilder, sum: Signal, bits: u32, name: &str) -> Start {
    let top = m.slice(sum, bits - 1, sum.width() + 1 - bits);
    let (any, all) = (m.any(top), m.all(top));
    let is_far = m.xor(any, all);
    let value = m.slice(sum, 0, START);
    let value = m.name(value, &format!("{name}_in_format"));
    Start {
        value: m.as_signed(value),
        is_far: m.name(is_far, &format!("{name}_far")),
    }
}
