//! Clocks of an exponential by form.

use potamoi_formats::config::ExpConfig;

/// Clocks of a form in the iterative engine; its stages in the pipelined one.
pub(super) trait Clocks: Sync {
    /// Clocks of a vector whose smallest exponent is `exponent`.
    fn clocks(&self, exp: &ExpConfig, exponent: u32) -> u32;

    /// Whether clocks depend on the exponent.
    fn looks_at_exponents(&self, exp: &ExpConfig) -> bool {
        let _ = exp;
        false
    }
}

/// Clocks for a configuration whose engine has these knobs.
#[cfg(test)]
#[allow(clippy::unwrap_used)]
pub(super) fn clocks_of(form: &dyn Clocks, knobs: &str, exponent: u32) -> u32 {
    let text = format!("[vu]\nops = [\"exp\"]\n[vu.exp]\n{knobs}");
    let config = potamoi_formats::config::Config::from_toml(&text, "test").unwrap();
    form.clocks(&config.vu.exp, exponent)
}
