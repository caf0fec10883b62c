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

/// Of a configuration whose engine has these knobs.
#[cfg(test)]
#[allow(clippy::unwrap_used)]
pub(super) fn clocks_of(form: &dyn Clocks, knobs: &str, exponent: u32) -> u32 {
    let text = format!("[vu]\nops = [\"exp\"]\n[vu.exp]\n{knobs}");
    let config = potamoi_formats::config::Config::from_toml(&text, "test").unwrap();
    form.clocks(&config.vu.exp, exponent)
}
