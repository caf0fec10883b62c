//! `2^-v` from a piecewise linear table: one result a clock.
//!
//! `v = u log2 e = k + f`. The power is `2^-(k+1) y` with `y = 2^(1-f)` in (1, 2]. On each piece, y
//! is a start value minus a slope times the offset of f within the piece.

use num_bigint::BigInt;
use potamoi_formats::config::{Config, Engine, ExpConfig};
use potamoi_formats::fixed::Rounding;
use potamoi_formats::timing::{Pipeline, PowerRegister};
use potamoi_netlist::{ModuleBuilder, Signal, Ty};

use super::constants;
use super::form::{Form, Powers, State, Widths};
use crate::circuits::held;
use crate::vector_unit::addends::Rows;
use crate::vector_unit::lane_control::LaneControl;

/// Integer bits of v: 16 log2 e is 23.1.
const INTEGER: u32 = 5;

pub(super) struct Piecewise;

impl Form for Piecewise {
    fn describe(&self) -> &'static str {
        "exponentials in straight pieces"
    }

    fn registers(&self, _: &ExpConfig, engine: &Engine) -> [Ty; 2] {
        let remain = Ty::u(engine.constant_bits + 4);
        [remain, Ty::u(engine.accumulator_bits + 2)]
    }

    fn digits_width(&self, _: &Engine) -> u32 {
        INTEGER
    }

    fn powers(
        &self,
        m: &mut ModuleBuilder,
        config: &Config,
        widths: &Widths,
        control: &LaneControl,
        a: Signal,
    ) -> Powers {
        let stages = config.vu.power_registers();
        pieces(m, widths, control, a, &stages)
    }

    fn exponent(&self, _: &mut ModuleBuilder, _: &Widths, s: State, _: Signal) -> Signal {
        s.digits
    }
}

/// Pipeline stages: exponent of two, and piece; with those between of a registered unit.
fn pieces(
    m: &mut ModuleBuilder,
    widths: &Widths,
    control: &LaneControl,
    a: Signal,
    stages: &Pipeline<PowerRegister>,
) -> Powers {
    m.section("Exponential: power of two");
    let bits = widths.engine.constant_bits;
    let (mut operand, frac) = operand(m, widths, control, a);
    if stages.has(PowerRegister::Start) {
        operand = held(m, "operand_held", operand);
    }
    let power = match widths.exp.piece_widths().scale_bits {
        Some(scale) => {
            let power = match stages.has(PowerRegister::PowerAddends) {
                true => scaled_in_two_clocks(m, operand, scale, (scale + frac, bits)),
                false => scaled(m, operand, scale, (scale + frac, bits)),
            };
            let power = m.name(power, "power_rounded");
            let power = fit(m, power, INTEGER + bits);
            // Sums of rows are beyond the range analysis.
            let power = match stages.has(PowerRegister::PowerAddends) {
                true => power,
                false => m.exact(power),
            };
            held(m, "s_power", power)
        }
        None => {
            let wide = fit(m, operand, INTEGER + frac);
            let wide = m.extend(wide, INTEGER + bits);
            m.shl_const(wide, bits - frac)
        }
    };
    let power = m.name(power, "power_of_two");
    m.note(power, &format!("the result is 2^-power, U{INTEGER}.{bits}"));
    m.section("Exponential: pieces");
    let in_two_clocks = stages.has(PowerRegister::MantissaAddends);
    let accum = mantissa(m, widths, power, in_two_clocks);
    let whole = m.slice(power, bits, INTEGER);
    let one = m.lit(1, whole.ty());
    let mut exponent = m.add(whole, one);
    if in_two_clocks {
        exponent = held(m, "exponent_next", exponent);
    }
    let (accum, digits) = (held(m, "s_accum", accum), held(m, "s_exponent", exponent));
    Powers {
        state: State {
            remain: m.lit(0, widths.remain),
            accum,
            digits,
        },
        large: m.lit(0, Ty::bit()),
        logistic: None,
        exponent: None,
        more: None,
        remainders: vec![],
    }
}

/// The operand times `log2 e`, rounded from `from` fraction bits to `to`; with `scale` fraction bits of
/// the factor.
fn scaled(m: &mut ModuleBuilder, operand: Signal, scale: u32, (from, to): (u32, u32)) -> Signal {
    let ty = Ty::u(scale + 1);
    let factor = m.param("LOG2_E", constants::log2_e(scale), ty, "log2 e");
    let product = m.mul(operand, factor);
    let product = m.name(product, "power_product");
    // An operand of fewer fraction bits: fewer are dropped.
    match from.checked_sub(to) {
        Some(drop) => m.round(product, drop, Rounding::HalfUp),
        None => {
            let wide = m.extend(product, product.width() + to - from);
            m.shl_const(wide, to - from)
        }
    }
}

/// As [`scaled`], with a register of the product's addends.
fn scaled_in_two_clocks(
    m: &mut ModuleBuilder,
    operand: Signal,
    scale: u32,
    (from, to): (u32, u32),
) -> Signal {
    // The rounding may carry.
    let mut rows = Rows::always("power_addend", operand.width() + scale + 2, m);
    rows.multiple(m, operand, &constants::log2_e(scale));
    if from > to {
        rows.constant(&(BigInt::from(1) << (from - to - 1)));
    }
    let sum = held_sum(m, rows, "s_power_addend");
    match from.checked_sub(to) {
        Some(drop) => m.slice(sum, drop, sum.width() - drop),
        None => {
            let wide = m.extend(sum, sum.width() + to - from);
            m.shl_const(wide, to - from)
        }
    }
}

/// The sum of rows, whose two addends are registered.
fn held_sum(m: &mut ModuleBuilder, rows: Rows<'_>, name: &str) -> Signal {
    let [one, other] = rows.two(m);
    let one = held(m, &format!("{name}0"), one);
    let other = held(m, &format!("{name}1"), other);
    m.add(one, other)
}

/// The operand, unsigned, with its fraction bits.
fn operand(
    m: &mut ModuleBuilder,
    widths: &Widths,
    control: &LaneControl,
    a: Signal,
) -> (Signal, u32) {
    let power = widths.operand(m, a);
    let frac = widths.exp.input.frac_bits();
    if !widths.kinds.one_minus {
        return (power, frac);
    }
    let bits = widths.engine.constant_bits;
    let (depth, _) = widths.depth(m, a);
    let depth = m.name(depth, "depth_aligned");
    let wide = m.extend(power, depth.width());
    let aligned = m.shl_const(wide, bits - frac);
    let operand = m.mux(control.one_minus, depth, aligned);
    (m.name(operand, "operand"), bits)
}

/// `y`: the piece's start minus slope times offset, in one clock or two.
fn mantissa(m: &mut ModuleBuilder, widths: &Widths, power: Signal, in_two_clocks: bool) -> Signal {
    let (engine, table) = (&widths.engine, widths.exp.piece_widths());
    let within = engine.constant_bits - table.index_bits;
    let index = m.slice(power, within, table.index_bits);
    let index = m.name(index, "piece");
    let rest = m.slice(power, 0, within);
    let rest = m.name(rest, "within_piece");
    let entries = constants::pieces(table.index_bits, engine.accumulator_bits, table.slope_bits);
    let mut column = |at: usize, name: &str, ty: Ty| {
        let values: Vec<_> = entries
            .iter()
            .map(|entry| m.lit(entry[at].clone(), ty))
            .collect();
        let value = m.select(index, &values);
        m.name(value, name)
    };
    let most = entries.iter().map(|entry| &entry[0]).max();
    let start_bits = most.map_or(1, |most| most.bits() as u32);
    let start = column(0, "piece_start", Ty::u(start_bits));
    let slope = column(1, "piece_slope", Ty::u(table.slope_bits + 1));
    let drop = table.slope_bits + engine.constant_bits - engine.accumulator_bits;
    if in_two_clocks {
        // start - floor((x + h) / 2^d) with h = 2^(d - 1) is floor((start 2^d - x + h - 1) / 2^d).
        let mut rows = Rows::always("piece_addend", widths.accum.width + drop, m);
        rows.minus_product(m, slope, rest);
        rows.shifted(m, start, drop);
        let one = BigInt::from(1) << drop;
        rows.constant(&(&one - 1 - (&one >> 1u32)));
        let sum = held_sum(m, rows, "s_piece_addend");
        let accum = m.slice(sum, drop, widths.accum.width);
        return m.name(accum, "accum");
    }
    let product = m.mul(slope, rest);
    let product = m.name(product, "piece_product");
    let fall = m.round(product, drop, Rounding::HalfUp);
    let fall = m.name(fall, "piece_fall");
    let start = m.extend(start, widths.accum.width);
    let fall = fit(m, fall, widths.accum.width);
    let accum = m.sub(start, fall);
    let accum = m.exact(accum);
    m.name(accum, "accum")
}

/// The same value in another width that can hold it.
fn fit(m: &mut ModuleBuilder, value: Signal, width: u32) -> Signal {
    if value.width() > width {
        m.truncate(value, width)
    } else {
        m.extend(value, width)
    }
}
