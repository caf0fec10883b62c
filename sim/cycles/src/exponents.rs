//! The exponents that the length of a vector follows from.

use potamoi_formats::config::Config;
use potamoi_formats::units::OpCode;
use potamoi_reference::exp::ExpTwin;

/// The smallest exponents of vectors, where an early out makes their length
/// depend on them.
#[derive(Debug, Clone)]
pub struct Exponents {
    twin: Option<ExpTwin>,
}

impl Exponents {
    /// Of a configuration that has passed its rules.
    #[must_use]
    pub fn of(config: &Config) -> Self {
        let exp = &config.vu.exp;
        Self {
            twin: exp.early_out.then(|| ExpTwin::new(exp)),
        }
    }

    /// The smallest exponent k of a vector's powers `R_accum 2^-k`, whose kept
    /// lanes have the first operands `a`; 0 where no length depends on it, and the
    /// largest number where no lane is kept.
    #[must_use]
    pub fn least(&self, op: OpCode, a: &[i32]) -> u32 {
        let Some(twin) = &self.twin else { return 0 };
        let exponents = a.iter().map(|a| twin.exponent(op, *a));
        exponents.min().unwrap_or(u32::MAX)
    }
}
