//! What the length of an exponential follows from.

use potamoi_formats::config::ExpConfig;

/// The clocks of a form, in the iterative engine; its stages in the pipelined one.
pub(super) trait Clocks: Sync {
    /// Of a vector whose smallest exponent is `exponent`.
    fn clocks(&self, exp: &ExpConfig, exponent: u32) -> u32;

    /// Whether they depend on the exponent.
    fn looks_at_exponents(&self, exp: &ExpConfig) -> bool {
        let _ = exp;
        false
    }
}
