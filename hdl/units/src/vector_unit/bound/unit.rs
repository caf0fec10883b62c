//! The vector unit with one lane, run on a whole range of operands at once.

use num_bigint::BigInt;
use num_traits::Zero;
use potamoi_formats::config::Config;
use potamoi_formats::units::OpCode;
use potamoi_netlist::{Interval, IntervalInterpreter, Module};

/// The running unit, and the signals common to all forms.
pub(super) struct Unit<'a> {
    pub(super) config: &'a Config,
    op: OpCode,
    pub(super) machine: IntervalInterpreter<'a>,
    valid: usize,
    data: usize,
    pub(super) done: usize,
    result: usize,
}

impl<'a> Unit<'a> {
    /// `signals` are analysed beside the result; `parts` are read in parts.
    pub(super) fn new(
        config: &'a Config,
        op: OpCode,
        module: &'a Module,
        signals: &[&str],
        parts: &[&str],
    ) -> Option<Self> {
        let result = match op {
            OpCode::Softplus => "lane_0.softplus_rounded",
            _ => "lane_0.rounded",
        };
        let all = [signals, &["result_valid", result]].concat();
        let machine = IntervalInterpreter::new(module, &all, parts)?;
        Some(Self {
            config,
            op,
            valid: machine.find("s_axis_vec_tvalid")?,
            data: machine.find("s_axis_vec_tdata")?,
            done: machine.find("result_valid")?,
            result: machine.find(result)?,
            machine,
        })
    }

    /// The value of a signal, if it is unique.
    pub(super) fn point(&self, id: usize) -> Option<BigInt> {
        let value = self.machine.value(id);
        value.is_point().then(|| value.low.clone())
    }

    /// The value of a bit, if it is unique.
    pub(super) fn yes(&self, id: usize) -> Option<bool> {
        Some(!self.point(id)?.is_zero())
    }

    /// Sets the inputs that stay constant during an operation on these operands.
    pub(super) fn prepare(&mut self, [low, high]: [i64; 2]) {
        self.machine.reset();
        self.machine.set(self.data, Interval::new(low, high));
        for (name, value) in [
            ("cfg_clear", 0),
            ("s_axis_vec_tkeep", 0xff),
            ("s_axis_vec_tlast", 0),
            ("s_axis_vec_tuser", self.op.code()),
            ("m_axis_vec_tready", 1),
        ] {
            if let Some(port) = self.machine.find(name) {
                self.machine.set(port, Interval::new(value, value));
            }
        }
    }

    /// Offers the operands in this cycle, or no vector.
    pub(super) fn offer(&mut self, valid: bool) {
        let valid = u8::from(valid);
        self.machine.set(self.valid, Interval::new(valid, valid));
        self.machine.settle();
    }

    /// Errors of the result by dropped bits, before 1 saturates.
    pub(super) fn dropped(&self) -> Option<[f64; 2]> {
        self.machine.off(self.result)
    }
}
