//! Control data that accompanies a vector to the result stage.

use potamoi_netlist::{ModuleBuilder, Signal, Ty};

use super::sequence::Sequence;
use super::timing::Timing;
use crate::circuits::delayed;

/// In the pipelined form, whether a vector is in each stage; the first is the lowest bit.
pub(super) const VALID_STAGES: &str = "valid_stages";

/// In a registered unit, whether a vector is in each stage between the operation's last clock and the
/// result stage; the first is the lowest bit.
pub(super) const LAG_STAGES: &str = "lag_stages";

/// Control data of the vector in the result stage.
pub(super) struct ResultControl {
    pub(super) valid: Signal,
    /// Whether a vector moves through the stages of the pipelined form.
    pub(super) moving: Option<Signal>,
    pub(super) is_exp: Signal,
    pub(super) one_minus: Signal,
    pub(super) shift: Signal,
    pub(super) rounding: Signal,
    /// Shift and rounding in the clock before the result stage, of an iterative unit that is
    /// registered.
    pub(super) before: Option<(Signal, Signal)>,
    pub(super) keep: Signal,
    pub(super) last: Signal,
}

impl ResultControl {
    /// Registers the tag beside the vector: once in the iterative form, in every stage of the
    /// pipelined one, and in the stages by which a registered unit lags.
    pub(super) fn follow(
        m: &mut ModuleBuilder,
        s: &Sequence,
        accept: Signal,
        timing: &Timing,
        values: [Signal; 6],
    ) -> Self {
        let names = ["is_exp", "one_minus", "shift", "rounding", "keep", "last"];
        let valid = m.reg("result_valid", Ty::bit(), 0);
        if !timing.pipelined {
            let (done, _) = delayed(m, LAG_STAGES, s.done, timing.lag, Some(0));
            m.set_next(valid, done);
            let mut held = values;
            let mut before = vec![];
            for (value, name) in held.iter_mut().zip(names) {
                let reg = match timing.lag {
                    0 => m.data_reg(&format!("result_{name}"), value.ty()),
                    _ => m.data_reg(&format!("taken_{name}"), value.ty()),
                };
                m.set_next_if(reg, accept, *value);
                let width = reg.width();
                let (last, all) = delayed(m, &format!("result_{name}"), reg, timing.lag, None);
                if let (Some(all), "shift" | "rounding") = (all, name) {
                    before.push(m.slice(all, (timing.lag - 2) * width, width));
                }
                *value = last;
            }
            let own = Self::of(valid, None, held);
            let before = match before[..] {
                [shift, rounding] => Some((shift, rounding)),
                _ => None,
            };
            return Self { before, ..own };
        }
        let stages = timing.interval - 1;
        let (from_valid, inside) = delayed(m, VALID_STAGES, accept, stages, Some(0));
        let (from_valid, _) = delayed(m, LAG_STAGES, from_valid, timing.lag, Some(0));
        m.set_next(valid, from_valid);
        let held = std::array::from_fn(|i| {
            let stages = stages + timing.lag;
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
            before: None,
            keep,
            last,
        }
    }
}
