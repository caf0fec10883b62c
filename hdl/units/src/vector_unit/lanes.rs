//! The lanes, with their common control signals.

use std::sync::Arc;

use potamoi_formats::config::Config;
use potamoi_formats::timing::{ElementStage, Pipeline};
use potamoi_netlist::{Feed, IrErrors, Module, ModuleBuilder, Signal};

use super::acceptance::{Acceptance, Inputs};
use super::exponential;
use super::exponential::constants::multiples;
use super::exponential::shift_registers::{exp_constants, sub_name};
use super::lane_control::asked_port;
use super::operation_kinds::OperationKinds;
use super::result_control::ResultControl;
use super::sequence::{Order, Sequence};
use crate::circuits::delayed;

/// Control signals of all lanes in a cycle.
pub(super) struct LaneSignals<'a> {
    pub(super) config: &'a Config,
    pub(super) kinds: OperationKinds,
    pub(super) pipelined: bool,
    /// Stages of an element-wise operation in a registered unit.
    pub(super) lag: Option<Pipeline<ElementStage>>,
    pub(super) accepted: &'a Acceptance,
    /// Orders of sigmoid and softplus.
    pub(super) logistic: [Option<Order>; 2],
    pub(super) sequence: &'a Sequence,
    pub(super) tag: &'a ResultControl,
}

impl LaneSignals<'_> {
    /// Inputs of a lane, except its operands.
    ///
    /// # Errors
    /// The checks of the constants' netlist.
    pub(super) fn inputs(&self, m: &mut ModuleBuilder) -> Result<Vec<(String, Signal)>, IrErrors> {
        let mut inputs: Vec<(String, Signal)> = vec![("accept".into(), self.accepted.accept)];
        self.element_wise(m, &mut inputs);
        if self.kinds.one_minus {
            inputs.extend([
                ("one_minus".into(), self.accepted.one_minus),
                ("result_is_one_minus".into(), self.tag.one_minus),
            ]);
        }
        self.logistic(m, &mut inputs);
        if self.kinds.exp && !self.pipelined {
            self.engine(m, &mut inputs)?;
        }
        Ok(inputs)
    }

    fn element_wise(&self, m: &mut ModuleBuilder, inputs: &mut Vec<(String, Signal)>) {
        if !self.kinds.elementwise {
            return;
        }
        let vu = &self.config.vu;
        match vu.registered {
            // Decoded once: the multiplication is all that fits the clock.
            true => {
                let asked = vu.ops.iter().zip(&self.accepted.built);
                let asked = asked.filter(|(op, _)| !op.is_exponential());
                inputs.extend(asked.map(|(op, is_it)| (asked_port(*op), *is_it)));
            }
            false => inputs.push(("code".into(), self.accepted.code)),
        }
        let (shift, rounding) = if let (true, Some(lag)) = (self.pipelined, &self.lag) {
            // Of the clock after the stages of the addends and of the exact result.
            let clocks = lag.cycles() - 1;
            let mut late = |name: &str, value: Signal| delayed(m, name, value, clocks, None).0;
            (
                late("shift_next", self.accepted.shift),
                late("rounding_next", self.accepted.rounding),
            )
        } else if let Some(before) = self.tag.before {
            before
        } else if self.pipelined {
            let early = |m: &mut ModuleBuilder, name: &str, from: Signal| {
                let reg = m.data_reg(name, from.ty());
                m.set_next(reg, from);
                reg
            };
            (
                early(m, "shift_next", self.accepted.shift),
                early(m, "rounding_next", self.accepted.rounding),
            )
        } else {
            (self.tag.shift, self.tag.rounding)
        };
        inputs.extend([("shift".into(), shift), ("rounding".into(), rounding)]);
        if self.kinds.exp {
            inputs.push(("result_is_exp".into(), self.tag.is_exp));
        }
    }

    fn logistic(&self, m: &mut ModuleBuilder, inputs: &mut Vec<(String, Signal)>) {
        let [sigmoid, softplus] = self.logistic;
        if let Some(s) = softplus {
            let (held, _) = delayed(m, "result_softplus", s.held, self.config.vu.lag(), None);
            inputs.push(("result_is_softplus".into(), held));
        }
        let Some(log) = &self.sequence.log else {
            return;
        };
        inputs.extend([
            ("logistic".into(), self.accepted.logistic),
            ("log".into(), self.late(m, "log_held", log.steps)),
        ]);
        if let (Some(s), true) = (sigmoid, self.kinds.softplus) {
            inputs.push(("sigmoid".into(), s.now));
        }
        match self.lag {
            None => {
                inputs.push(("begin_log".into(), log.begin));
                inputs.extend(log.again.map(|again| ("begin_again".into(), again)));
            }
            Some(_) => {
                for (name, signal) in [
                    ("load_log", Some(log.begin)),
                    ("load_again", log.load_again),
                    ("take_sum", log.sum),
                ] {
                    let late = signal.map(|signal| self.late(m, &format!("{name}_held"), signal));
                    inputs.extend(late.map(|late| (name.into(), late)));
                }
            }
        }
    }

    /// A signal of the engine a clock later in a registered unit: what the steps start from is
    /// registered first, as the constants are in the lanes.
    fn late(&self, m: &mut ModuleBuilder, name: &str, signal: Signal) -> Signal {
        match self.lag {
            Some(_) => delayed(m, name, signal, 1, Some(0)).0,
            None => signal,
        }
    }

    /// Steps of the iterative form, with their constants.
    fn engine(
        &self,
        m: &mut ModuleBuilder,
        inputs: &mut Vec<(String, Signal)>,
    ) -> Result<(), IrErrors> {
        let (exp, sequence) = (&self.config.vu.exp, self.sequence);
        let widths = exponential::widths(exp, self.kinds);
        let Some(own) = widths.form.recurrence() else {
            return Ok(());
        };
        m.section("Constants, shared by the lanes");
        let module = exp_constants(own, self.config, &widths)?;
        let constants = m.instance("constants", &module, &[("rotate", sequence.rotate)]);
        if let Some(ending) = sequence.ending {
            m.connect(constants, "restart", ending);
        }
        for i in 0..exp.iterations_per_clock {
            let subs = multiples(own).map(sub_name);
            let digit = (widths.engine.digits > 0).then(|| "digit".to_owned());
            for name in subs.chain(["mul".to_owned()]).chain(digit) {
                let port = format!("{name}{i}");
                let value = m.out(constants, &port);
                inputs.push((port, value));
            }
        }
        let mut begin = sequence.begin;
        if self.lag.is_some() {
            inputs.push(("load_power".into(), begin));
            // A second power has been loaded as the first was.
            if let Some(again) = sequence.log.as_ref().and_then(|log| log.again) {
                begin = m.or(begin, again);
            }
        }
        inputs.extend([
            ("step".into(), self.late(m, "step_held", sequence.step)),
            ("begin_power".into(), self.late(m, "begin_held", begin)),
        ]);
        if exp.tail {
            let tail = self.late(m, "tail_held", sequence.tail);
            inputs.push(("tail".into(), tail));
        }
        if let (Some(phase), Some(_)) = (self.accepted.phase, sequence.ending) {
            inputs.push(("phase".into(), phase));
        }
        Ok(())
    }
}

/// Outputs of all lanes.
pub(super) struct LaneResults {
    /// Results, the first lowest; 0 for lanes without operand.
    pub(super) values: Signal,
    /// Whether a lane of the offered vector is kept in part.
    pub(super) torn: Signal,
    /// With narrow operands, whether one of a kept lane is beyond its width.
    pub(super) beyond: Option<Signal>,
    /// With early termination, whether each lane has steps left.
    pub(super) more: Option<Signal>,
}

/// Adds the lanes.
pub(super) fn lanes(
    m: &mut ModuleBuilder,
    lane: &Arc<Module>,
    told: &LaneSignals<'_>,
    common: &[(String, Signal)],
    inputs: &Inputs,
) -> LaneResults {
    m.section("Lanes");
    let count = told.config.vu.lanes;
    let mut io: Vec<(&str, Feed<'_>)> = common
        .iter()
        .map(|(name, signal)| (name.as_str(), Feed::Shared(*signal)))
        .collect();
    for (name, base) in [("a", 0), ("b", 32)] {
        let operand = Feed::Strided {
            vector: inputs.data,
            stride: 64,
            base,
        };
        io.push((name, operand));
    }
    io.push(("keep", Feed::Each(inputs.bytes)));
    io.push(("result_keep", Feed::Each(told.tag.keep)));
    let all = m.array("lane", lane, &[("i", count)], &io);
    let more = told.sequence.ending.is_some().then(|| {
        let more = m.all_out(all, "more");
        m.and(more, told.tag.keep)
    });
    let torn = m.all_out(all, "torn");
    let beyond = told.config.vu.has_narrow_operands().then(|| {
        let beyond = m.all_out(all, "beyond");
        m.any(beyond)
    });
    LaneResults {
        values: m.all_out(all, "result"),
        torn: m.any(torn),
        beyond,
        more,
    }
}
