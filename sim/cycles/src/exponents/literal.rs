//! The literal recurrence: one iteration after the other.

use potamoi_formats::config::ExpConfig;

use super::clocks::Clocks;

pub(super) struct Literal;

impl Clocks for Literal {
    fn clocks(&self, exp: &ExpConfig, _: u32) -> u32 {
        exp.power_pipeline().turn()
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
        Literal.clocks(&config.vu.exp, exponent)
    }

    /// No digits.
    #[test]
    fn clocks_are_iterations() {
        let literal = "form = \"literal\"\ninput = \"S0.14\"";
        assert_eq!(clocks(literal, 0), 16);
        assert_eq!(
            clocks(&format!("{literal}\niterations_per_clock = 3"), 0),
            6
        );
    }
}
