//! Error bounds of exponentials and of operations made of them, from the netlist, over all operands
//! at once.
//!
//! A result differs from `2^F exp(-x)` for two reasons. First, the datapath drops bits:
//! [`potamoi_netlist`]'s analysis bounds their effect, clock by clock, on the printed unit. Second,
//! the recurrence itself leaves an error: without dropped bits the result would be `exp(-x + g)`,
//! where g is a sum of known terms of the netlist's registers and constants: the final remainder,
//! the alignment and bias of the start, and the difference of each subtracted constant from its
//! logarithm.

mod logistic;
mod pieces;
mod recurrence;
mod unit;

use potamoi_formats::config::{Config, ExpBase, ExpForm, ExpOutput};
use potamoi_formats::units::OpCode;
use potamoi_netlist::{IrErrors, Module};

use super::top::vector_unit;
use logistic::Passes;
use pieces::Pieces;
use recurrence::Recurrence;

/// Upper bound of the floating-point error of the sums of `left`, which are below 32.
const SLACK: f64 = 1e-12;

/// A guaranteed error bound, in ulp of the result.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bound {
    /// Largest error above or below the exact result, before 1 saturates.
    pub ulp: f64,
    /// Part of it that is due to dropped bits.
    pub dropped: f64,
    /// Range of operand codes with the largest bound.
    pub operands: [i64; 2],
}

/// Smallest and largest error for some operands.
struct Errors {
    /// Due to dropped bits.
    dropped: [f64; 2],
    /// Due to the method.
    method: [f64; 2],
}

/// Method of computing powers.
enum Method<'a> {
    Logistic(Passes<'a>),
    Recurrence(Recurrence<'a>),
    Pieces(Pieces<'a>),
}

/// The bound of `exp` or `one-minus-exp`, or of `sigmoid` or `softplus` for operands from -16
/// to 16. `None` where the operation is not built, and outside this analysis: the literal form, and
/// results with an exponent.
///
/// # Errors
/// As [`vector_unit`].
pub fn error_bound(config: &Config, op: OpCode) -> Result<Option<Bound>, IrErrors> {
    let exp = &config.vu.exp;
    let forms = [ExpForm::Restoring, ExpForm::Radix4, ExpForm::Piecewise];
    let known = forms.contains(&exp.form)
        && exp.output == ExpOutput::Alpha
        && (exp.base == ExpBase::E || exp.form == ExpForm::Piecewise)
        && op.is_exponential()
        && config.vu.ops.contains(&op);
    if !known {
        return Ok(None);
    }
    // Lanes are alike, and register stages between change no bit.
    let mut one = config.clone();
    one.vu.lanes = 1;
    one.vu.registered = false;
    let module = vector_unit(&one)?;
    Ok(largest(&one, op, &module))
}

/// The bound of a unit with one lane.
fn largest(config: &Config, op: OpCode, module: &Module) -> Option<Bound> {
    let exp = &config.vu.exp;
    let (fraction, last) = match op {
        OpCode::OneMinusExp => (exp.one_minus_frac_bits, (16 << exp.one_minus_frac_bits) - 1),
        _ => (exp.input.frac_bits(), exp.input.max() as i64),
    };
    let mut method = match exp.form {
        _ if op.is_logistic() => Method::Logistic(Passes::new(config, op, module)?),
        ExpForm::Piecewise => Method::Pieces(Pieces::new(config, op, module)?),
        _ => Method::Recurrence(Recurrence::new(config, op, module)?),
    };
    let mut todo = match &method {
        Method::Logistic(passes) => passes.spans(fraction, exp.resolved_bits()),
        Method::Pieces(pieces) => pieces.spans(last, fraction),
        Method::Recurrence(_) => recurrence::spans(last, fraction, exp.resolved_bits()),
    };
    let mut worst: Option<Bound> = None;
    while let Some([low, high]) = todo.pop() {
        let errors = match &mut method {
            Method::Logistic(passes) => passes.errors(op, [low, high], fraction),
            Method::Pieces(pieces) => pieces.errors([low, high], fraction),
            Method::Recurrence(recurrence) => recurrence.errors([low, high], fraction),
        };
        let Some(Errors { dropped, method }) = errors else {
            if low == high {
                return None;
            }
            let middle = low + (high - low) / 2;
            todo.extend([[low, middle], [middle + 1, high]]);
            continue;
        };
        let found = Bound {
            ulp: (dropped[1] + method[1]).max(-dropped[0] - method[0]),
            dropped: dropped[1].max(-dropped[0]),
            operands: [low, high],
        };
        worst = worst.filter(|w| w.ulp >= found.ulp).or(Some(found));
    }
    worst
}

/// Cuts the codes from 0 to `last` into ranges that begin at `starts`.
fn cut(last: i64, starts: impl Iterator<Item = i64>) -> Vec<[i64; 2]> {
    let mut starts: Vec<i64> = starts
        .chain([0])
        .filter(|s| (0..=last).contains(s))
        .collect();
    starts.sort_unstable();
    starts.dedup();
    let ends = starts.iter().skip(1).map(|s| s - 1).chain([last]);
    starts
        .iter()
        .copied()
        .zip(ends)
        .map(|(a, b)| [a, b])
        .collect()
}

#[cfg(test)]
mod tests;
