//! What yosys-smtbmc says.

use crate::script::path_of;

/// Checks whose assertion fails, by path, as listed for the last step.
pub(crate) fn failed(said: &str) -> Vec<String> {
    let lines = said.lines().filter_map(|line| {
        let (_, rest) = line.split_once("Assert failed in ")?;
        let (_, cell) = rest.split_once(": ")?;
        cell.split_whitespace().next().map(path_of)
    });
    lines.collect()
}

/// The step of the counterexample.
pub(crate) fn failed_step(said: &str) -> Option<u32> {
    let lines: Vec<&str> = said.lines().collect();
    let steps = lines.iter().rev().filter_map(|line| {
        let (_, rest) = line.split_once("Checking assertions in step ")?;
        rest.trim_end_matches('.').trim().parse().ok()
    });
    steps.into_iter().next()
}

/// Cover points that are reached, and the step of each.
pub(crate) fn reached(said: &str) -> Vec<(String, u32)> {
    let lines = said.lines().filter_map(|line| {
        let (_, rest) = line.split_once("Reached cover statement at ")?;
        let (cell, step) = rest.split_once(" in step ")?;
        let step = step.trim_end_matches('.').trim().parse().ok()?;
        Some((path_of(cell), step))
    });
    lines.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn outcomes_are_read() {
        let said = "##   0:00:00  Checking assumptions in step 7..\n\
                    ##   0:00:00  Checking assertions in step 7..\n\
                    ##   0:00:00  BMC failed!\n\
                    ##   0:00:00  Assert failed in top: rit.check_regular.holds\n\
                    ##   0:00:00  Assert failed in top: check_balance.holds\n\
                    ##   0:00:00  Status: FAILED\n";
        assert_eq!(failed(said), ["rit.regular", "balance"]);
        assert_eq!(failed_step(said), Some(7));
        let said = "##   0:00:03  Reached cover statement at fifo.check_passes.seen in step 16.\n\
                    ##   0:00:07  Unreached cover statement at fifo.check_fills.seen.\n";
        assert_eq!(reached(said), [("fifo.passes".to_owned(), 16)]);
    }
}
