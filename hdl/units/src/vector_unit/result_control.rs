//! Control data that accompanies a vector to the result stage.

use potamoi_netlist::{ModuleBuilder, Signal, Ty};

use super::sequence::Sequence;

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
        let (mut from_valid, mut from) = (accept, values);
        let mut stages = vec![];
        for stage in 1..interval {
            let reg = m.reg(&format!("valid_{stage}"), Ty::bit(), 0);
            m.set_next(reg, from_valid);
            from_valid = reg;
            stages.push(reg);
            from = std::array::from_fn(|i| {
                let reg = m.data_reg(&format!("{}_{stage}", names[i]), from[i].ty());
                m.set_next(reg, from[i]);
                reg
            });
        }
        m.set_next(valid, from_valid);
        let held = std::array::from_fn(|i| {
            let reg = m.data_reg(&format!("result_{}", names[i]), from[i].ty());
            m.set_next(reg, from[i]);
            reg
        });
        let moving = (!stages.is_empty()).then(|| {
            let moving = m.any_of(&stages);
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
