//! The literal recurrence: one iteration a clock.

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
    use super::super::clocks::clocks_of;
    use super::*;

    /// No digits.
    #[test]
    fn clocks_are_iterations() {
        let literal = "form = \"literal\"\ninput = \"S0.14\"";
        assert_eq!(clocks_of(&Literal, literal, 0), 16);
        assert_eq!(
            clocks_of(&Literal, &format!("{literal}\niterations_per_clock = 3"), 0),
            6
        );
    }
}
