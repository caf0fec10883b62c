//! A case of a comparison as a query of a solver, and what the solver says of it.

use std::collections::BTreeSet;

/// What has to be equal without and with the fault.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Compared {
    /// An output, or an input of a module that carries data, while the unit runs.
    Output(String),
    /// An error flag after that clock.
    Flag(String),
    /// A register after that clock.
    Register(String),
}

/// Registers that nothing reads while a register of one bit is low: they may differ then.
#[derive(Debug)]
pub(crate) struct Unread<'q> {
    pub(crate) valid: &'q str,
    pub(crate) registers: BTreeSet<String>,
}

/// A case to be decided, and what is compared in it.
pub(crate) struct Case {
    pub(crate) query: String,
    pub(crate) compared: Vec<Compared>,
}

impl Case {
    /// What differs in the state that a solver found, or nothing where it found that there is none.
    ///
    /// # Errors
    /// The solver said something else.
    pub(crate) fn differences(&self, said: &str) -> Result<Vec<&Compared>, String> {
        let (outcome, values) = said.trim().split_once('\n').unwrap_or((said.trim(), ""));
        match outcome.trim() {
            "unsat" => return Ok(vec![]),
            "sat" => {}
            _ => return Err(said.to_owned()),
        }
        let numbered = self.compared.iter().enumerate();
        let differing = numbered.filter(|(n, _)| values.contains(&format!("({} false)", same(*n))));
        let found: Vec<&Compared> = differing.map(|(_, one)| one).collect();
        match found.is_empty() {
            false => Ok(found),
            true => Err(said.to_owned()),
        }
    }
}

/// The name of an equality.
pub(crate) fn same(number: usize) -> String {
    format!("same_{number}")
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn what_differs_is_read() {
        let case = Case {
            query: String::new(),
            compared: vec![
                Compared::Output("full".to_owned()),
                Compared::Register("count".to_owned()),
            ],
        };
        let none: Vec<&Compared> = vec![];
        assert_eq!(
            case.differences("unsat\n(error \"no model\")").unwrap(),
            none
        );
        let said = "sat\n((same_0 true)\n (same_1 false))\n";
        assert_eq!(case.differences(said).unwrap(), [&case.compared[1]]);
        for said in ["sat\n((same_0 true) (same_1 true))", "unknown", ""] {
            assert!(case.differences(said).is_err(), "{said}");
        }
    }
}
