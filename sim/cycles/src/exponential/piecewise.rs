//! Piecewise linear: one result a clock.

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
    use super::super::clocks::clocks_of;
    use super::*;

    /// Two stages, or one where nothing is multiplied by log2 e.
    #[test]
    fn clocks_are_stages() {
        let pieces = "form = \"piecewise\"\npipelined = true";
        assert_eq!(clocks_of(&Piecewise, pieces, 0), 2);
        assert_eq!(
            clocks_of(&Piecewise, &format!("{pieces}\nbase = \"two\""), 0),
            1
        );
    }
}
