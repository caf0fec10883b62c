//! SR_sub and SR_mul: constants and shift amounts, shared by all lanes.

use std::sync::Arc;

use num_bigint::BigInt;
use potamoi_formats::config::Config;
use potamoi_netlist::{IrErrors, Module, ModuleBuilder, Ty};

use super::constants::{multiples, steps};
use super::form::{Recurrence, Widths};

/// Builds `exp_constants`: two shift registers that rotate r positions with every clock of steps,
/// so that they return to the start after the last. With early termination they are reset to the
/// start instead.
///
/// # Errors
/// The netlist's own checks.
pub(in crate::vector_unit) fn exp_constants(
    own: &dyn Recurrence,
    config: &Config,
    widths: &Widths,
) -> Result<Arc<Module>, IrErrors> {
    let exp = &config.vu.exp;
    let r = exp.iterations_per_clock as usize;
    let all = steps(own, exp, widths.remain.width);
    let mut builder = ModuleBuilder::new("exp_constants");
    let m = &mut builder;
    m.doc(&format!(
        "rotating shift registers of the exponential engine. sr_sub holds 2^j ln 2 and ln(1 + 2^-i) with {} \
         fraction bits, sr_mul the shift amounts.",
        widths.engine.constant_bits
    ));
    let rotate = m.input("rotate", Ty::bit(), &format!("moves on by {r}"));
    let restart = exp
        .early_out
        .then(|| m.input("restart", Ty::bit(), "moves to the start instead"));
    let subs: Vec<String> = multiples(own).map(sub_name).collect();
    let mut columns: Vec<(&str, &str, Ty, Vec<BigInt>)> = vec![];
    for (d, name) in subs.iter().enumerate() {
        let values = all.iter().map(|s| s.constants[d].clone());
        columns.push((name, "constant", widths.remain, values.collect()));
    }
    let shifts = all.iter().map(|s| s.shift.into());
    columns.push(("mul", "shift amount", widths.shift, shifts.collect()));
    if widths.engine.digits > 0 {
        let digits = all.iter().map(|s| u8::from(s.digit).into());
        columns.push(("digit", "an exponent digit", Ty::bit(), digits.collect()));
    }
    let mut registers = vec![vec![]; columns.len()];
    for i in 0..all.len() {
        for ((name, _, ty, values), column) in columns.iter().zip(&mut registers) {
            column.push(m.reg(&format!("sr_{name}_{i}"), *ty, values[i].clone()));
        }
    }
    for ((name, doc, ty, values), column) in columns.iter().zip(&registers) {
        for (i, reg) in column.iter().enumerate() {
            let mut next = column[(i + r) % column.len()];
            if let Some(restart) = restart {
                let first = m.lit(values[i].clone(), *ty);
                next = m.mux(restart, first, next);
            }
            m.set_next_if(*reg, rotate, next);
        }
        for (i, reg) in column.iter().take(r).enumerate() {
            m.output(&format!("{name}{i}"), *reg, doc);
        }
    }
    builder.finish()
}

/// Name of the constants of digit d; the names of its ports end in the step's number.
pub(in crate::vector_unit) fn sub_name(d: u32) -> String {
    match d {
        1 => "sub".to_owned(),
        2 => "sub_two".to_owned(),
        _ => "sub_three".to_owned(),
    }
}
