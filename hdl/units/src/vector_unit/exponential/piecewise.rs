//! `2^-v` from a piecewise linear table: one result a clock.
//!
//! `v = u log2 e = k + f`. The power is `2^-(k+1) y` with `y = 2^(1-f)` in (1, 2]. On each piece, y
//! is a start value minus a slope times the offset of f within the piece.

use potamoi_formats::config::{Config, Engine, ExpConfig};
use potamoi_formats::fixed::Rounding;
use potamoi_netlist::{ModuleBuilder, Signal, Ty};

use super::constants;
use super::form::{Form, Powers, State, Widths};
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
        _: &Config,
        widths: &Widths,
        control: &LaneControl,
        a: Signal,
    ) -> Powers {
        pieces(m, widths, control, a)
    }

    fn exponent(&self, _: &mut ModuleBuilder, _: &Widths, s: State, _: Signal) -> Signal {
        s.digits
    }
}

/// Pipeline stages: exponent of two, and piece.
fn pieces(m: &mut ModuleBuilder, widths: &Widths, control: &LaneControl, a: Signal) -> Powers {
    m.section("Exponential: power of two");
    let bits = widths.engine.constant_bits;
    let (operand, frac) = operand(m, widths, control, a);
    let power = match widths.exp.piece_widths().scale_bits {
        Some(scale) => {
            let ty = Ty::u(scale + 1);
            let factor = m.param("LOG2_E", constants::log2_e(scale), ty, "log2 e");
            let product = m.mul(operand, factor);
            let product = m.name(product, "power_product");
            // An operand of fewer fraction bits: fewer are dropped.
            let power = match (scale + frac).checked_sub(bits) {
                Some(drop) => m.round(product, drop, Rounding::HalfUp),
                None => {
                    let width = product.width() + bits - scale - frac;
                    let wide = m.extend(product, width);
                    m.shl_const(wide, bits - scale - frac)
                }
            };
            let power = m.name(power, "power_rounded");
            let power = fit(m, power, INTEGER + bits);
            let power = m.exact(power);
            let held = m.data_reg("s_power", power.ty());
            m.set_next(held, power);
            held
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
    let accum = mantissa(m, widths, power);
    let whole = m.slice(power, bits, INTEGER);
    let one = m.lit(1, whole.ty());
    let exponent = m.add(whole, one);
    let mut hold = |name: &str, value: Signal| {
        let reg = m.data_reg(name, value.ty());
        m.set_next(reg, value);
        reg
    };
    let (accum, digits) = (hold("s_accum", accum), hold("s_exponent", exponent));
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

/// `y`: the piece's start minus slope times offset.
fn mantissa(m: &mut ModuleBuilder, widths: &Widths, power: Signal) -> Signal {
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
    let product = m.mul(slope, rest);
    let product = m.name(product, "piece_product");
    let drop = table.slope_bits + engine.constant_bits - engine.accumulator_bits;
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
