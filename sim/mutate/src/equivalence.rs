//! Whether a mutant is equivalent to its module.
//!
//! A miter compares the module with and without the fault, with the modules below it cut: what they
//! are given is an output of the miter, what they give is a free input. First the registers of both
//! are taken as equal and free, so that equality of every next state and output holds in all runs.
//! Where that fails, both begin with all registers at 0, and equality is proven by induction over
//! signals that correspond.

use std::collections::BTreeMap;
use std::process::Command;
use std::time::Duration;

use potamoi_verilated::child::{self, Fault};
use serde::Serialize;

use crate::design::SELECT;
use crate::tools::{broken, no_result, text};
use crate::{Design, Mutant, MutateError, Tools};

/// Time limit of a miter.
const LIMIT: Duration = Duration::from_secs(120);

/// How a mutant is shown to be equivalent.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Miter {
    /// From any state.
    AnyState,
    /// From the state with all registers at 0.
    FromZero,
}

/// The miters of a design.
pub(crate) struct Miters<'a> {
    design: &'a Design,
    netlists: BTreeMap<String, String>,
}

impl<'a> Miters<'a> {
    /// Writes the netlists of these modules.
    pub(crate) fn new(
        tools: &Tools,
        design: &'a Design,
        modules: impl Iterator<Item = &'a str>,
    ) -> Result<Self, MutateError> {
        let mut netlists = BTreeMap::new();
        for module in modules {
            if !netlists.contains_key(module) {
                netlists.insert(module.to_owned(), design.blif(tools, module)?);
            }
        }
        Ok(Self { design, netlists })
    }

    /// How the mutant is shown to be equivalent, if it is.
    pub(crate) fn equivalent(&self, mutant: &Mutant) -> Result<Option<Miter>, MutateError> {
        let Some(netlist) = self.netlists.get(&mutant.module) else {
            return Ok(None);
        };
        let width = self.design.width();
        let number = mutant.number;
        let names = [
            format!("{number}-gold.blif"),
            format!("{number}-fault.blif"),
        ];
        for (name, active) in names.iter().zip([0, number]) {
            self.design.write(name, &fixed(netlist, width, active))?;
        }
        let mut found = None;
        for (command, miter) in [("cec", Miter::AnyState), ("dsec", Miter::FromZero)] {
            if self.same(command, &names, mutant)? {
                found = Some(miter);
                break;
            }
        }
        for name in names {
            let path = self.design.folder().join(name);
            std::fs::remove_file(&path).map_err(|error| MutateError::File { path, error })?;
        }
        Ok(found)
    }

    fn same(&self, how: &str, names: &[String; 2], mutant: &Mutant) -> Result<bool, MutateError> {
        let mut abc = Command::new("yosys-abc");
        abc.current_dir(self.design.folder());
        abc.arg("-c")
            .arg(format!("{how} {} {}", names[0], names[1]));
        let what = mutant.what();
        let said = match child::run(&abc, LIMIT) {
            Ok(done) => text(&done),
            Err(Fault::Late { .. }) => return Ok(false),
            Err(fault) => return Err(broken("yosys-abc", &what, fault)),
        };
        outcome(&said).ok_or_else(|| no_result("yosys-abc", &what, &said))
    }
}

/// Whether ABC has shown that networks are the same.
fn outcome(said: &str) -> Option<bool> {
    let open = ["NOT EQUIVALENT", "UNDECIDED", "undecided"];
    if open.iter().any(|word| said.contains(word)) {
        return Some(false);
    }
    said.contains("Networks are equivalent").then_some(true)
}

/// A netlist in which mutant `number` is active: the inputs that select are constants.
fn fixed(netlist: &str, width: u32, number: usize) -> String {
    let mut text = String::with_capacity(netlist.len() + 64 * width as usize);
    for line in netlist.lines() {
        if let Some(names) = line.strip_prefix(".inputs ") {
            let select = format!("{SELECT}[");
            let others = names
                .split_whitespace()
                .filter(|name| !name.starts_with(&select));
            text += &format!(".inputs {}\n", others.collect::<Vec<_>>().join(" "));
            continue;
        }
        text += line;
        text += "\n";
        if line.starts_with(".outputs") {
            for bit in 0..width {
                let one = if number >> bit & 1 == 1 { "1\n" } else { "" };
                text += &format!(".names {SELECT}[{bit}]\n{one}");
            }
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mutant_is_a_constant() {
        let netlist = ".model m\n.inputs a potamoi_mutant[0] potamoi_mutant[1] b\n.outputs q\n\
                       .names a b q\n11 1\n.end\n";
        let expected = ".model m\n.inputs a b\n.outputs q\n.names potamoi_mutant[0]\n\
                        .names potamoi_mutant[1]\n1\n.names a b q\n11 1\n.end\n";
        assert_eq!(fixed(netlist, 2, 2), expected);
    }

    #[test]
    fn outcomes_are_read() {
        assert_eq!(
            outcome("Networks are equivalent after structural hashing."),
            Some(true)
        );
        assert_eq!(
            outcome("Networks are NOT EQUIVALENT.  Time = 0.01 sec"),
            Some(false)
        );
        assert_eq!(outcome("Networks are UNDECIDED."), Some(false));
        assert_eq!(outcome("Error: no such file"), None);
    }
}
