//! Control data that accompanies a vector to the result stage.

use potamoi_netlist::{ModuleBuilder, Signal, Ty};

use super::sequence::Sequence;
use crate::circuits::delayed;

/// In the pipelined form, whether a vector is in each stage; the first is the lowest bit.
pub(super) const VALID_STAGES: &str = "valid_stages";

/// Control data of the vector in the result stage.
pub(super) struct ResultControl {
    pub(super) valid: Signal,
    /// Whether a vector moves through the stages of the pipelined form.
    pub(super) moving: Option<Signal>,
    pub(super) is_exp: Signal,
    pub(super) one_minus: Signal,
    pub(super) shift: Signal,
    pub(super) rounding: Signal,
    pub(super) keep: Signal,
    pub(super) last: Signal,
}

impl ResultControl {
    /// Registers the tag beside the vector: once in the iterative form, in every stage of the
    /// pipelined one.
    pub(super) fn follow(
        m: &mut ModuleBuilder,
        s: &Sequence,
        accept: Signal,
        interval: u32,
        pipelined: bool,
        values: [Signal; 6],
    ) -> Self {
        let names = ["is_exp", "one_minus", "shift", "rounding", "keep", "last"];
        let valid = m.reg("result_valid", Ty::bit(), 0);
        if !pipelined {
            m.set_next(valid, s.done);
            let held = std::array::from_fn(|i| {
                let reg = m.data_reg(&format!("result_{}", names[i]), values[i].ty());
                m.set_next_if(reg, accept, values[i]);
                reg
            });
            return Self::of(valid, None, held);
        }
        let stages = interval - 1;
        let (from_valid, inside) = delayed(m, VALID_STAGES, accept, stages, Some(0));
        m.set_next(valid, from_valid);
        let held = std::array::from_fn(|i| {
            let (from, _) = delayed(m, &format!("{}_stages", names[i]), values[i], stages, None);
            let reg = m.data_reg(&format!("result_{}", names[i]), from.ty());
            m.set_next(reg, from);
            reg
        });
        let moving = inside.map(|inside| {
            let moving = m.any(inside);
            m.name(moving, "moving")
        });
        Self::of(valid, moving, held)
    }

    fn of(
        valid: Signal,
        moving: Option<Signal>,
        [is_exp, one_minus, shift, rounding, keep, last]: [Signal; 6],
    ) -> Self {
        Self {
            valid,
            moving,
            is_exp,
            one_minus,
            shift,
            rounding,
            keep,
            last,
        }
    }
}
