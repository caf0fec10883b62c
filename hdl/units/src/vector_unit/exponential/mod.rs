//! The exponential engine: one file for each form, and their common parts.
//!
//! `docs/adding/exponential.md` adds a form step by step.

pub(super) mod constants;
mod datapath;
pub(super) mod early_out;
mod engine;
mod form;
mod iterative;
mod literal;
mod logistic;
mod piecewise;
mod pipelined;
mod radix4;
mod restoring;
pub(super) mod shift_registers;

use potamoi_formats::config::{ExpConfig, ExpForm};
use potamoi_netlist::Ty;

use super::operation_kinds::OperationKinds;

pub(super) use form::{Form, Widths};

/// The form of a configuration.
pub(super) fn form(exp: &ExpConfig) -> &'static dyn Form {
    match exp.form {
        ExpForm::Restoring => &restoring::Restoring,
        ExpForm::Literal => &literal::Literal,
        ExpForm::Piecewise => &piecewise::Piecewise,
        ExpForm::Radix4 => &radix4::Radix4,
    }
}

/// The registers of a configuration's engine.
pub(super) fn widths(exp: &ExpConfig, kinds: OperationKinds) -> Widths {
    let (form, engine) = (form(exp), exp.engine());
    let [remain, accum] = form.registers(exp, &engine);
    Widths {
        form,
        exp: exp.clone(),
        engine,
        remain,
        accum,
        digits: Ty::u(form.digits_width(&engine)),
        shift: Ty::u(5),
        kinds,
    }
}
