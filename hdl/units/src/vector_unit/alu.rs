//! The element-wise operations: an exact result, requantised.

use potamoi_formats::units::OpCode;
use potamoi_netlist::{ModuleBuilder, Signal, Ty};

use crate::circuits::is;

/// Type of exact results: `a^2 + b^2` reaches `2^63`.
pub(super) const EXACT: Ty = Ty::s(65);

/// Whether `code` is that of `op`; the signal is named after it.
pub(super) fn is_op(m: &mut ModuleBuilder, code: Signal, op: OpCode) -> Signal {
    let name = match op {
        OpCode::Pass => "OP_PASS",
        OpCode::Relu => "OP_RELU",
        OpCode::Add => "OP_ADD",
        OpCode::Multiply => "OP_MULTIPLY",
        OpCode::SquareSum => "OP_SQUARE_SUM",
        OpCode::Exp => "OP_EXP",
        OpCode::OneMinusExp => "OP_ONE_MINUS_EXP",
        OpCode::Sigmoid => "OP_SIGMOID",
        OpCode::Softplus => "OP_SOFTPLUS",
    };
    let own = m.param(name, u32::from(op.code()), code.ty(), "");
    m.eq(code, own)
}

/// Exact result of an element-wise operation; 0 for any other.
pub(super) fn exact(
    m: &mut ModuleBuilder,
    ops: &[OpCode],
    code: Signal,
    a: Signal,
    b: Signal,
) -> Signal {
    let zero = m.lit(0, EXACT);
    let mut value = zero;
    for op in ops.iter().copied().filter(|op| !op.is_exponential()) {
        let result = match op {
            OpCode::Pass => m.extend(a, 65),
            OpCode::Relu => {
                let sign = m.bit(a, 31);
                let none = m.lit(0, a.ty());
                let held = m.mux(sign, none, a);
                let held = m.name(held, "relu");
                m.extend(held, 65)
            }
            OpCode::Add => {
                let (x, y) = (m.extend(a, 33), m.extend(b, 33));
                let sum = m.add(x, y);
                let sum = m.name(sum, "sum");
                m.extend(sum, 65)
            }
            OpCode::Multiply => {
                let product = m.mul(a, b);
                let product = m.name(product, "product");
                m.extend(product, 65)
            }
            OpCode::SquareSum => {
                let (x, y) = (m.mul(a, a), m.mul(b, b));
                let (x, y) = (m.name(x, "a_square"), m.name(y, "b_square"));
                let (x, y) = (m.extend(x, 65), m.extend(y, 65));
                m.add(x, y)
            }
            // The engine's.
            OpCode::Exp | OpCode::OneMinusExp | OpCode::Sigmoid | OpCode::Softplus => continue,
        };
        let here = is_op(m, code, op);
        value = m.mux(here, result, value);
    }
    m.name(value, "exact_next")
}

/// `exact / 2^shift`, rounded (0 floor, 1 half-up, 2 half-even) and saturated
/// to signed 32 bits.
pub(super) fn requantise(
    m: &mut ModuleBuilder,
    exact: Signal,
    shift: Signal,
    rounding: Signal,
) -> Signal {
    let none = m.lit(0, Ty::bit());
    let doubled = m.cat(&[exact, none]);
    let doubled = m.as_signed(doubled);
    let doubled = m.name(doubled, "exact_doubled");
    let shifted = m.shr(doubled, shift);
    let shifted = m.name(shifted, "shifted");
    let floor = m.slice(shifted, 1, 65);
    let floor = m.name(floor, "floor");
    let floor = m.as_signed(floor);
    let guard = m.bit(shifted, 0);
    // Bits below the guard: shift - 1 of them.
    let ones = m.lit((1u128 << 64) - 1, Ty::u(64));
    let above = m.shl(ones, shift);
    let below = m.not(above);
    let below = m.name(below, "dropped_bits");
    let below = m.slice(below, 1, 63);
    let low = m.slice(exact, 0, 63);
    let rest = m.and(low, below);
    let sticky = m.any(rest);
    let odd = m.bit(shifted, 1);
    let tie_up = m.or(sticky, odd);
    let even = m.and(guard, tie_up);
    let is_up = is(m, rounding, 1);
    let is_even = is(m, rounding, 2);
    let up = m.and(is_up, guard);
    let even = m.and(is_even, even);
    let up = m.or(up, even);
    let up = m.name(up, "round_up");
    let wide = m.extend(floor, 66);
    let up = m.extend(up, 66);
    let up = m.as_signed(up);
    let rounded = m.add(wide, up);
    let rounded = m.name(rounded, "rounded_value");
    let held = m.saturate(rounded, Ty::s(32));
    m.as_unsigned(held)
}
