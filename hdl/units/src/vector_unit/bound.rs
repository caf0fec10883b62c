//! The largest error of an operation that the netlist allows, over all operands at
//! once: of exponentials, and of what is made of them.
//!
//! Two things make a result differ from `2^F exp(-x)`. Bits that the datapath
//! drops: [`potamoi_netlist`]'s analysis, clock by clock, of the unit as it is printed.
//! And what the recurrence itself leaves: without dropped bits the result would be
//! `exp(-x + g)`, where g is the sum of what is known of the netlist's registers
//! and constants: the remainder at the end, the start's alignment and bias, and
//! what each constant that is subtracted is off from its logarithm.

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

/// More than the sums of `left`, of numbers below 32, are off in floating point.
const SLACK: f64 = 1e-12;

/// A guaranteed error, in units of the result's last place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bound {
    /// The most that a result is above or below the exact one, before a power of
    /// one is held below it.
    pub ulp: f64,
    /// Of it, what dropped bits are.
    pub dropped: f64,
    /// Operands among which the bound is the largest, codes.
    pub operands: [i64; 2],
}

/// What results of some operands are off, least and most.
struct Errors {
    /// By dropped bits.
    dropped: [f64; 2],
    /// By what the method leaves.
    method: [f64; 2],
}

/// How powers are found.
enum Method<'a> {
    Logistic(Passes<'a>),
    Recurrence(Recurrence<'a>),
    Pieces(Pieces<'a>),
}

/// The bound for `exp`, `one-minus-exp`, and for `sigmoid` and `softplus` of operands of
/// -16 to 16, of a vector unit; `None` where it is not built, and of what this analysis
/// does not know: the literal form and results with an exponent.
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
    // Lanes are alike.
    let mut one = config.clone();
    one.vu.lanes = 1;
    let module = vector_unit(&one)?;
    Ok(largest(&one, op, &module))
}

/// The bound of a unit of one lane.
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

/// Ranges of codes from 0 to `last` that begin here.
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
