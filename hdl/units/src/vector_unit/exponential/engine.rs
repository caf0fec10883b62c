//! The engine of the forms that compare, subtract, shift and add.

use potamoi_formats::config::Config;
use potamoi_netlist::{ModuleBuilder, Signal};

use super::form::{Powers, Recurrence, Widths};
use super::iterative::iterative;
use super::pipelined::pipelined;
use crate::vector_unit::orders::Orders;

/// Registers that are passed turn after turn, or a pipeline.
pub(super) fn engine(
    own: &dyn Recurrence,
    m: &mut ModuleBuilder,
    config: &Config,
    widths: &Widths,
    orders: &Orders,
    a: Signal,
) -> Powers {
    if config.vu.exp.pipelined {
        pipelined(own, m, config, widths, orders, a)
    } else {
        iterative(own, m, config, widths, orders, a)
    }
}
