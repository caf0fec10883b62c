//! The element-wise operations: an exact result, requantised.

use std::collections::BTreeMap;

use num_bigint::BigInt;
use potamoi_formats::config::VuConfig;
use potamoi_formats::units::OpCode;
use potamoi_netlist::{ModuleBuilder, Signal, Ty};

use super::addends::Rows;
use super::lane_control::LaneControl;
use crate::circuits::{held, is};

/// Type of exact results of operands of 32 bits: `a^2 + b^2` reaches `2^63`.
const EXACT: Ty = Ty::s(65);

/// Type of exact results of a configuration.
pub(super) fn exact_type(vu: &VuConfig) -> Ty {
    if vu.operands.is_none() && !vu.registered {
        return EXACT;
    }
    let bits = vu.ops.iter().map(|op| {
        let [a, b] = vu.operand_widths(*op);
        match op {
            OpCode::Add => a.max(b) + 1,
            OpCode::Multiply => a + b,
            OpCode::SquareSum => 2 * a + 1,
            _ => a,
        }
    });
    Ty::s(bits.max().unwrap_or(EXACT.width))
}

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
    vu: &VuConfig,
    code: Signal,
    a: Signal,
    b: Signal,
) -> Signal {
    let ty = exact_type(vu);
    let zero = m.lit(0, ty);
    let mut value = zero;
    for op in vu.ops.iter().copied().filter(|op| !op.is_exponential()) {
        let [a, b] = held_operands(m, vu, op, a, b);
        let result = match op {
            OpCode::Pass => m.extend(a, ty.width),
            OpCode::Relu => {
                let held = relu(m, a);
                m.extend(held, ty.width)
            }
            OpCode::Add => {
                let (x, y) = (m.extend(a, 33), m.extend(b, 33));
                let sum = m.add(x, y);
                let sum = m.name(sum, "sum");
                m.extend(sum, ty.width)
            }
            OpCode::Multiply => {
                let product = m.mul(a, b);
                let product = m.name(product, "product");
                m.extend(product, ty.width)
            }
            OpCode::SquareSum => {
                let (x, y) = (m.mul(a, a), m.mul(b, b));
                let (x, y) = (m.name(x, "a_square"), m.name(y, "b_square"));
                let (x, y) = (m.extend(x, ty.width), m.extend(y, ty.width));
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

/// The operands of an operation within their widths: their low bits.
fn held_operands(
    m: &mut ModuleBuilder,
    vu: &VuConfig,
    op: OpCode,
    a: Signal,
    b: Signal,
) -> [Signal; 2] {
    let [of_a, of_b] = vu.operand_widths(op);
    [m.truncate(a, of_a), m.truncate(b, of_b)]
}

fn relu(m: &mut ModuleBuilder, a: Signal) -> Signal {
    let sign = m.bit(a, 31);
    let none = m.lit(0, a.ty());
    let held = m.mux(sign, none, a);
    m.name(held, "relu")
}

/// Two addends whose sum is the exact result, as [`exact`] has it.
///
/// Operations never meet, so that they share the rows of the sum and all that adds them up.
pub(super) fn addends(
    m: &mut ModuleBuilder,
    vu: &VuConfig,
    asked: &BTreeMap<OpCode, Signal>,
    a: Signal,
    b: Signal,
) -> [Signal; 2] {
    let asks = |op: OpCode| asked.get(&op).copied();
    let mut rows = Rows::new("addend", exact_type(vu).width);
    if let Some(on) = asks(OpCode::Multiply) {
        let [x, y] = held_operands(m, vu, OpCode::Multiply, a, b);
        rows.or_if(on);
        rows.signed_product(m, x, y);
    }
    if let Some(on) = asks(OpCode::SquareSum) {
        let roots = held_operands(m, vu, OpCode::SquareSum, a, b);
        rows.or_if(on);
        for root in roots {
            rows.square(m, root);
        }
    }
    plain_rows(m, &mut rows, asked, a, b);
    rows.two(m)
}

/// The addends of pass, relu and add.
fn plain_rows(
    m: &mut ModuleBuilder,
    rows: &mut Rows<'_>,
    asked: &BTreeMap<OpCode, Signal>,
    a: Signal,
    b: Signal,
) {
    let plain = [OpCode::Pass, OpCode::Relu, OpCode::Add].into_iter();
    let plain = plain.filter_map(|op| Some((op, *asked.get(&op)?)));
    let plain: Vec<_> = plain.collect();
    if plain.is_empty() {
        return;
    }
    let any: Vec<_> = plain.iter().map(|(_, asked)| *asked).collect();
    rows.or_if(m.any_of(&any));
    let takes = plain.iter().map(|(op, asked)| match op {
        OpCode::Relu => {
            let negative = m.bit(a, 31);
            let positive = m.not(negative);
            m.and(*asked, positive)
        }
        _ => *asked,
    });
    let takes: Vec<_> = takes.collect();
    let takes = m.any_of(&takes);
    let first = only(m, takes, a);
    let first = m.name(first, "first");
    rows.value(m, first);
    if let Some(add) = asked.get(&OpCode::Add) {
        let second = only(m, *add, b);
        let second = m.name(second, "second");
        rows.value(m, second);
    }
}

/// The value where `take`, otherwise 0; its type stays.
fn only(m: &mut ModuleBuilder, take: Signal, value: Signal) -> Signal {
    let mask = m.repeat(take, value.width());
    let bits = m.as_unsigned(value);
    let bits = m.and(bits, mask);
    match value.ty().signed {
        true => m.as_signed(bits),
        false => bits,
    }
}

/// Whether an operand of the operation is beyond its width.
pub(super) fn beyond(
    m: &mut ModuleBuilder,
    vu: &VuConfig,
    control: &LaneControl,
    a: Signal,
    b: Signal,
) -> Signal {
    let mut found = vec![];
    for op in &vu.ops {
        let widths = vu.operand_widths(*op);
        let mut wrong = vec![];
        for (value, width) in [a, b].into_iter().zip(widths) {
            if width < value.width() {
                // Bits from the narrow sign on differ.
                let signs = m.slice(value, width - 1, value.width() - width + 1);
                let (some, all) = (m.any(signs), m.all(signs));
                wrong.push(m.xor(some, all));
            }
        }
        if !wrong.is_empty() {
            let here = match control.asked.get(op) {
                Some(asked) => *asked,
                None => is(m, control.code, op.code().into()),
            };
            let wrong = m.any_of(&wrong);
            found.push(m.and(here, wrong));
        }
    }
    m.any_of(&found)
}

/// Bits of a registered result before its rounding, and of its lower half.
const FLOOR: u32 = 33;
const HALF: u32 = 16;

/// An exact result without the bits that its shift drops.
pub(super) struct Shifted {
    floor: Signal,
    /// The highest dropped bit, and whether a bit below it is set.
    guard: Signal,
    sticky: Signal,
    odd: Signal,
}

/// Shifts an exact result.
pub(super) fn shifted(m: &mut ModuleBuilder, exact: Signal, shift: Signal) -> Shifted {
    let width = exact.width();
    let none = m.lit(0, Ty::bit());
    let doubled = m.cat(&[exact, none]);
    let doubled = m.as_signed(doubled);
    let doubled = m.name(doubled, "exact_doubled");
    let shifted = m.shr(doubled, shift);
    let shifted = m.name(shifted, "shifted");
    let floor = m.slice(shifted, 1, width);
    let floor = m.name(floor, "floor");
    let floor = m.as_signed(floor);
    let guard = m.bit(shifted, 0);
    // Bits below the guard: shift - 1 of them, 62 at most. Those above the result are as its sign.
    let most = width.min(63);
    let ones = m.lit((BigInt::from(1) << (most + 1)) - 1, Ty::u(most + 1));
    let above = m.shl(ones, shift);
    let below = m.not(above);
    let below = m.name(below, "dropped_bits");
    let below = m.slice(below, 1, most);
    let low = m.slice(exact, 0, most);
    let rest = m.and(low, below);
    let sticky = m.any(rest);
    Shifted {
        floor,
        guard,
        sticky,
        odd: m.bit(shifted, 1),
    }
}

impl Shifted {
    /// Whether the result is rounded up (0 floor, 1 half-up, 2 half-even).
    fn up(&self, m: &mut ModuleBuilder, rounding: Signal) -> Signal {
        let tie_up = m.or(self.sticky, self.odd);
        let even = m.and(self.guard, tie_up);
        let is_up = is(m, rounding, 1);
        let is_even = is(m, rounding, 2);
        let up = m.and(is_up, self.guard);
        let even = m.and(is_even, even);
        let up = m.or(up, even);
        m.name(up, "round_up")
    }

    /// Rounded and saturated to signed 32 bits.
    pub(super) fn rounded(&self, m: &mut ModuleBuilder, rounding: Signal) -> Signal {
        let up = self.up(m, rounding);
        let wide = self.floor.width() + 1;
        let floor = m.extend(self.floor, wide);
        let up = m.extend(up, wide);
        let up = m.as_signed(up);
        let rounded = m.add(floor, up);
        let rounded = m.name(rounded, "rounded_value");
        let held = m.saturate(rounded, Ty::s(32));
        m.as_unsigned(held)
    }

    /// As [`Shifted::rounded`], with a register stage before the rounding.
    pub(super) fn rounded_a_clock_later(&self, m: &mut ModuleBuilder, rounding: Signal) -> Signal {
        // What does not fit into 33 bits saturates however it is rounded.
        let floor = m.saturate(self.floor, Ty::s(FLOOR));
        let up = self.up(m, rounding);
        let (floor, up) = (held(m, "floor_held", floor), held(m, "up_held", up));
        // A carry runs through either half alone.
        let low = m.slice(floor, 0, HALF);
        let high = m.slice(floor, HALF, FLOOR - HALF);
        let high = m.as_signed(high);
        let full = m.all(low);
        let carries = m.and(full, up);
        let carries = m.name(carries, "half_carries");
        let up = m.extend(up, HALF);
        let low = m.add(low, up);
        let high = m.extend(high, FLOOR - HALF + 1);
        let one = m.lit(1, high.ty());
        let next = m.add(high, one);
        let next = m.name(next, "high_next");
        let high = m.mux(carries, next, high);
        let rounded = m.cat(&[high, low]);
        let rounded = m.as_signed(rounded);
        let rounded = m.name(rounded, "rounded_value");
        let held = m.saturate(rounded, Ty::s(32));
        m.as_unsigned(held)
    }
}
