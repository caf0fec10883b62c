//! Clocks of an exponential, one file for each form.
//!
//! `docs/adding/exponential.md` adds a form step by step.

mod clocks;
mod literal;
mod piecewise;
mod radix4;
mod restoring;

use potamoi_formats::config::{Config, ExpConfig, ExpForm};
use potamoi_formats::units::OpCode;
use potamoi_reference::exponential::ReferenceExponential;

use clocks::Clocks;

/// The form of a configuration.
fn form(exp: &ExpConfig) -> &'static dyn Clocks {
    match exp.form {
        ExpForm::Restoring => &restoring::Restoring,
        ExpForm::Literal => &literal::Literal,
        ExpForm::Piecewise => &piecewise::Piecewise,
        ExpForm::Radix4 => &radix4::Radix4,
    }
}

/// The largest exponent: one-minus-exp starts from 24 ln 2.
pub(super) const MOST_EXPONENT: u32 = 24;

/// Clocks of an exponential for any operands: the maximum.
pub(super) fn clocks(exp: &ExpConfig) -> u64 {
    form(exp).clocks(exp, 0).into()
}

/// Clocks of an exponential by the smallest exponent of its lanes; the last entry holds for all
/// larger ones. `None` where they do not depend on it.
pub(super) fn clocks_by_exponent(exp: &ExpConfig) -> Option<Vec<u64>> {
    let form = form(exp);
    let by_exponent = || {
        (0..=MOST_EXPONENT)
            .map(|k| form.clocks(exp, k).into())
            .collect()
    };
    form.looks_at_exponents(exp).then(by_exponent)
}

/// Smallest exponents of vectors, on which their length depends with early termination.
#[derive(Debug, Clone)]
pub struct Exponents {
    twin: Option<ReferenceExponential>,
}

impl Exponents {
    /// For a configuration that has passed its rules.
    #[must_use]
    pub fn of(config: &Config) -> Self {
        let exp = &config.vu.exp;
        Self {
            twin: form(exp)
                .looks_at_exponents(exp)
                .then(|| ReferenceExponential::new(exp)),
        }
    }

    /// Smallest exponent k of a vector's powers `R_accum 2^-k`, where `a` are the first operands of
    /// the kept lanes. 0 where no length depends on it, the maximum where no lane is kept.
    #[must_use]
    pub fn least(&self, op: OpCode, a: &[i32]) -> u32 {
        let Some(twin) = &self.twin else { return 0 };
        let exponents = a.iter().map(|a| twin.exponent(op, *a));
        exponents.min().unwrap_or(u32::MAX)
    }
}
