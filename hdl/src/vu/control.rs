//! SR_sub and SR_mul: the constants and shift amounts, shared by all lanes.

use std::sync::Arc;

use potamoi_formats::config::Config;

use super::constants::steps;
use super::engine::Widths;
use crate::ir::{IrErrors, Module, ModuleBuilder, Signal, Ty};

/// Builds `exp_constants`: two shift registers that rotate r places with every
/// clock of steps, so that they stand at the start again after the last.
///
/// # Errors
/// The netlist's own checks.
pub(super) fn exp_constants(config: &Config, widths: &Widths) -> Result<Arc<Module>, IrErrors> {
    let exp = &config.vu.exp;
    let r = exp.iterations_per_clock as usize;
    let all = steps(exp, widths.remain.width);
    let mut builder = ModuleBuilder::new("exp_constants");
    let m = &mut builder;
    m.doc(&format!(
        "rotating shift registers of the exponential engine. sr_sub holds 2^j ln 2 and ln(1 + 2^-i) with {} \
         fraction bits, sr_mul the shift amounts.",
        widths.engine.constant_bits
    ));
    let rotate = m.input("rotate", Ty::bit(), &format!("moves on by {r}"));
    let mut columns: [Vec<Signal>; 3] = Default::default();
    for (i, step) in all.iter().enumerate() {
        columns[0].push(m.reg(&format!("sr_sub_{i}"), widths.remain, step.constant.clone()));
        columns[1].push(m.reg(&format!("sr_mul_{i}"), widths.shift, step.shift));
        if widths.engine.digits > 0 {
            columns[2].push(m.reg(&format!("sr_digit_{i}"), Ty::bit(), u8::from(step.digit)));
        }
    }
    for (column, (name, doc)) in columns.iter().zip([
        ("sub", "constant"),
        ("mul", "shift amount"),
        ("digit", "an exponent digit"),
    ]) {
        for (i, reg) in column.iter().enumerate() {
            m.set_next_if(*reg, rotate, column[(i + r) % column.len()]);
        }
        for (i, reg) in column.iter().take(r).enumerate() {
            m.output(&format!("{name}{i}"), *reg, doc);
        }
    }
    builder.finish()
}
