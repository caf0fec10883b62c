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
    let r = exp.iterations_per_clock;
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
    for (name, doc, ty, values) in columns {
        let width = ty.width * values.len() as u32;
        let start = flat(&values, ty.width);
        let register = m.reg(&format!("sr_{name}"), Ty::u(width), start.clone());
        m.as_values(register, ty.width);
        m.note(register, "the first lowest");
        // All steps in one clock end at the start.
        let mut next = register;
        if r * ty.width < width {
            let first = m.slice(register, 0, r * ty.width);
            let others = m.slice(register, r * ty.width, width - r * ty.width);
            next = m.cat(&[first, others]);
        }
        if let Some(restart) = restart {
            let start = m.lit(start, Ty::u(width));
            let start = m.as_values(start, ty.width);
            next = m.mux(restart, start, next);
        }
        m.set_next_if(register, rotate, next);
        for i in 0..r {
            let mut value = m.slice(register, i * ty.width, ty.width);
            if ty.signed {
                value = m.as_signed(value);
            }
            m.output(&format!("{name}{i}"), value, doc);
        }
    }
    builder.finish()
}

/// Values of `width` bits side by side, the first lowest.
fn flat(values: &[BigInt], width: u32) -> BigInt {
    let mask = (BigInt::from(1) << width) - 1;
    let all = values.iter().rev();
    all.fold(BigInt::ZERO, |above, value| {
        (above << width) + (value & &mask)
    })
}

/// Name of the constants of digit d; the names of its ports end in the step's number.
pub(in crate::vector_unit) fn sub_name(d: u32) -> String {
    match d {
        1 => "sub".to_owned(),
        2 => "sub_two".to_owned(),
        _ => "sub_three".to_owned(),
    }
}
