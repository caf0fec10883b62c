//! Restoring: digits and iterations, with a tail or early termination.

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
    use super::super::clocks::clocks_of;
    use super::*;

    /// Four digits and 16 iterations; with early termination n(k) of them, at least 6 clocks.
    #[test]
    fn clocks_are_steps_and_tail() {
        assert_eq!(clocks_of(&Restoring, "", 0), 20);
        assert_eq!(
            clocks_of(&Restoring, "iterations_per_clock = 6\ntail = true", 0),
            5
        );
        let early = [0, 2, 3, 12, 16, 24].map(|k| clocks_of(&Restoring, "early_out = true", k));
        assert_eq!(early, [20, 20, 19, 10, 6, 6]);
    }
}
