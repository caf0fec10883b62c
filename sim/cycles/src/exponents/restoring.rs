//! Restoring: digits and iterations, the tail, or as many as an early out leaves.

use potamoi_formats::config::ExpConfig;

use super::clocks::Clocks;

pub(super) struct Restoring;

impl Clocks for Restoring {
    fn clocks(&self, exp: &ExpConfig, exponent: u32) -> u32 {
        exp.clocks_of(exponent)
    }

    fn looks_at_exponents(&self, exp: &ExpConfig) -> bool {
        exp.early_out
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use potamoi_formats::config::Config;

    use super::*;

    fn clocks(text: &str, exponent: u32) -> u32 {
        let text = format!("[vu]\nops = [\"exp\"]\n[vu.exp]\n{text}");
        let config = Config::from_toml(&text, "test").unwrap();
        Restoring.clocks(&config.vu.exp, exponent)
    }

    /// Four digits and 16 iterations; n(k) of them with an early out, at least 6 clocks.
    #[test]
    fn clocks_are_steps_and_tail() {
        assert_eq!(clocks("", 0), 20);
        assert_eq!(clocks("iterations_per_clock = 6\ntail = true", 0), 5);
        let early = [0, 2, 3, 12, 16, 24].map(|k| clocks("early_out = true", k));
        assert_eq!(early, [20, 20, 19, 10, 6, 6]);
    }
}
