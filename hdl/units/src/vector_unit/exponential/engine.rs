//! Engine of the forms that compare, subtract, shift and add.

use potamoi_formats::config::{Config, Engine, ExpConfig};
use potamoi_netlist::{ModuleBuilder, Signal, Ty};

use super::form::{Form, Powers, Recurrence, State, Widths};
use super::iterative::iterative;
use super::pipelined::pipelined;
use crate::vector_unit::lane_control::LaneControl;

/// Builds an iterative engine of registers, or a pipeline.
fn engine(
    own: &dyn Recurrence,
    m: &mut ModuleBuilder,
    config: &Config,
    widths: &Widths,
    control: &LaneControl,
    a: Signal,
) -> Powers {
    if config.vu.exp.pipelined {
        pipelined(own, m, config, widths, control, a)
    } else {
        iterative(own, m, config, widths, control, a)
    }
}

/// All recurrences share one engine, and count the exponent by digits.
impl<R: Recurrence> Form for R {
    fn registers(&self, exp: &ExpConfig, engine: &Engine) -> [Ty; 2] {
        Recurrence::registers(self, exp, engine)
    }

    fn digits_width(&self, engine: &Engine) -> u32 {
        Recurrence::digits_width(self, engine)
    }

    fn powers(
        &self,
        m: &mut ModuleBuilder,
        config: &Config,
        widths: &Widths,
        control: &LaneControl,
        a: Signal,
    ) -> Powers {
        engine(self, m, config, widths, control, a)
    }

    fn exponent(&self, m: &mut ModuleBuilder, widths: &Widths, s: State, large: Signal) -> Signal {
        widths.exponent_of_digits(m, s, large)
    }

    fn recurrence(&self) -> Option<&dyn Recurrence> {
        Some(self)
    }

    fn is_bare(&self) -> bool {
        self.is_literal()
    }
}
