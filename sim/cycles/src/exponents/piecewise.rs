//! Straight pieces: one result a clock.

use potamoi_formats::config::ExpConfig;
use potamoi_formats::timing::PowerStage;

use super::clocks::Clocks;

pub(super) struct Piecewise;

impl Clocks for Piecewise {
    fn clocks(&self, exp: &ExpConfig, _: u32) -> u32 {
        let stages = exp.power_pipeline();
        1 + u32::from(stages.has(PowerStage::PowerOfTwo))
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
        Piecewise.clocks(&config.vu.exp, exponent)
    }

    /// Two stages, or one where nothing is multiplied by log2 e.
    #[test]
    fn clocks_are_stages() {
        let pieces = "form = \"piecewise\"\npipelined = true";
        assert_eq!(clocks(pieces, 0), 2);
        assert_eq!(clocks(&format!("{pieces}\nbase = \"two\""), 0), 1);
    }
}
