//! Acceptance of vectors.

use potamoi_formats::config::Config;
use potamoi_formats::units::OpCode;
use potamoi_netlist::{ModuleBuilder, Signal, Ty};

use super::alu::is_op;
use super::operation_kinds::OperationKinds;
use super::sequence::{Offer, Order};
use super::timing::Timing;
use crate::circuits::{bits_for, is};

/// Inputs of the unit.
pub(super) struct Inputs {
    pub(super) clear: Signal,
    pub(super) valid: Signal,
    pub(super) data: Signal,
    /// Lanes whose lowest byte is kept.
    pub(super) keep: Signal,
    /// All bytes that are kept.
    pub(super) bytes: Signal,
    pub(super) last: Signal,
    /// Operation (4 bits), shift (6) and rounding (2).
    user: Signal,
    pub(super) sink: Signal,
}

impl Inputs {
    pub(super) fn declare(m: &mut ModuleBuilder, lanes: u32) -> Self {
        let bit = Ty::bit();
        let clear = m.input("cfg_clear", bit, "clears counters and flags");
        let valid = m.input("s_axis_vec_tvalid", bit, "operands");
        let data = m.input(
            "s_axis_vec_tdata",
            Ty::u(64 * lanes),
            "lane i: a in bits 64 i + 31 .. 64 i, b above",
        );
        let bytes = m.input(
            "s_axis_vec_tkeep",
            Ty::u(8 * lanes),
            "of lanes that hold elements, all eight bytes or none",
        );
        let kept = m.every("kept_lanes", bytes, 8, ("each", lanes));
        Self {
            clear,
            valid,
            data,
            keep: kept,
            bytes,
            last: m.input("s_axis_vec_tlast", bit, "passed on"),
            user: m.input(
                "s_axis_vec_tuser",
                Ty::u(12),
                "operation 4, shift 6, rounding 2 bits",
            ),
            sink: m.input("m_axis_vec_tready", bit, ""),
        }
    }
}

/// Control of the offered vector.
pub(super) struct Acceptance {
    pub(super) code: Signal,
    pub(super) shift: Signal,
    pub(super) rounding: Signal,
    /// Vectors in flight, accepted and not yet taken by the sink, and whether one more may be
    /// accepted.
    pub(super) inside: Signal,
    pub(super) room: Signal,
    /// Clock counter of operations of more than one clock.
    pub(super) phase: Option<Signal>,
    /// The engine is free to begin an operation.
    pub(super) free: Signal,
    pub(super) ready: Signal,
    pub(super) accept: Signal,
    /// For each built operation, whether it is the offered one.
    pub(super) built: Vec<Signal>,
    pub(super) is_exp: Signal,
    pub(super) one_minus: Signal,
    pub(super) logistic: Signal,
    sigmoid: Signal,
    softplus: Signal,
}

impl Acceptance {
    pub(super) fn build(
        m: &mut ModuleBuilder,
        config: &Config,
        kinds: OperationKinds,
        timing: &Timing,
        inputs: &Inputs,
    ) -> Self {
        m.section("Acceptance");
        let (vu, bit) = (&config.vu, Ty::bit());
        let code = m.slice(inputs.user, 0, 4);
        let code = m.name(code, "code");
        let shift = m.slice(inputs.user, 4, 6);
        let rounding = m.slice(inputs.user, 10, 2);
        let inside_ty = Ty::u(bits_for(timing.depth));
        let inside = m.reg("in_flight", inside_ty, 0);
        m.note(inside, "vectors accepted and not yet taken by the sink");
        let limit = m.lit(timing.depth, inside_ty);
        let room = m.lt(inside, limit);
        let room = m.name(room, "room");
        let phase = (kinds.exp && !timing.pipelined && timing.longest > 1)
            .then(|| m.reg("phase", Ty::u(bits_for(timing.longest - 1)), 0));
        let free = match phase {
            Some(p) => is(m, p, 0),
            None => m.lit(1, bit),
        };
        let free = if phase.is_some() {
            m.name(free, "engine_free")
        } else {
            free
        };
        let ready = m.and(room, free);
        let ready = m.name(ready, "may_accept");
        let accept = m.and(inputs.valid, ready);
        let accept = m.name(accept, "accept");
        let built: Vec<_> = vu.ops.iter().map(|op| is_op(m, code, *op)).collect();
        let mut named = |wanted: OpCode, name: &str| {
            let place = vu.ops.iter().position(|op| *op == wanted);
            match place {
                Some(i) => m.name(built[i], name),
                None => m.lit(0, bit),
            }
        };
        let power = named(OpCode::Exp, "is_power");
        let one_minus = named(OpCode::OneMinusExp, "is_one_minus");
        let sigmoid = named(OpCode::Sigmoid, "is_sigmoid");
        let softplus = named(OpCode::Softplus, "is_softplus");
        let is_exp = m.or(power, one_minus);
        let logistic = m.or(sigmoid, softplus);
        let logistic = if kinds.logistic() {
            m.name(logistic, "is_logistic")
        } else {
            logistic
        };
        let is_exp = m.or(is_exp, logistic);
        let is_exp = m.name(is_exp, "is_exp");
        Self {
            code,
            shift,
            rounding,
            inside,
            room,
            phase,
            free,
            ready,
            accept,
            built,
            is_exp,
            one_minus,
            logistic,
            sigmoid,
            softplus,
        }
    }

    pub(super) fn offer(&self) -> Offer {
        Offer {
            accept: self.accept,
            is_exp: self.is_exp,
        }
    }

    /// Sigmoid and softplus, where built: whether they are offered, and whether they were accepted.
    pub(super) fn orders(
        &self,
        m: &mut ModuleBuilder,
        kinds: OperationKinds,
        lag: u32,
    ) -> [Option<Order>; 2] {
        let stage = match lag {
            0 => "result",
            _ => "taken",
        };
        [
            (kinds.sigmoid, "sigmoid", self.sigmoid),
            (kinds.softplus, "softplus", self.softplus),
        ]
        .map(|(built, name, value)| {
            built.then(|| {
                let reg = m.reg(&format!("{stage}_{name}"), Ty::bit(), 0);
                m.set_next_if(reg, self.accept, value);
                Order {
                    now: value,
                    held: reg,
                }
            })
        })
    }
}
