//! Radix 4: digits and iterations of two bits each, and the tail.

use potamoi_formats::config::ExpConfig;
use potamoi_formats::timing::PowerStage;

use super::clocks::Clocks;

pub(super) struct Radix4;

impl Clocks for Radix4 {
    fn clocks(&self, exp: &ExpConfig, _: u32) -> u32 {
        let stages = exp.power_pipeline();
        stages.turn() + u32::from(stages.has(PowerStage::Tail))
    }
}

#[cfg(test)]
mod tests {
    use super::super::clocks::clocks_of;
    use super::*;

    /// Two digits of the exponent, J iterations.
    #[test]
    fn clocks_are_steps_and_tail() {
        let radix4 = "form = \"radix-4\"\niterations = 4";
        assert_eq!(clocks_of(&Radix4, radix4, 0), 6);
        assert_eq!(clocks_of(&Radix4, &format!("{radix4}\ntail = true"), 0), 7);
    }
}
