//! Whether a mutant is equivalent to its module.
//!
//! A miter compares the module with and without the fault, with the modules below it cut: what they
//! are given is an output of the miter, what they give is a free input. One miter takes the registers of
//! both as equal and free, so that equality of every next state and output holds in all runs. In the
//! other, which takes minutes, both begin with all registers at 0. Registers that correspond and then signals
//! that correspond are found by induction and merged; nothing of the miter is left where the outputs
//! are among them.

use std::collections::BTreeMap;
use std::process::Command;
use std::time::Duration;

use potamoi_verilated::child::{self, Fault};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::design::SELECT;
use crate::tools::{broken, no_result, text};
use crate::{Design, Mutant, MutateError, Tools};

/// Time limit of a miter.
const LIMIT: Duration = Duration::from_secs(120);

/// How a mutant is shown to be equivalent.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Miter {
    /// From any state.
    AnyState,
    /// From the state with all registers at 0.
    FromZero,
    /// In the unit, from all states in which its proven properties hold.
    InUnit,
    /// By all operands of the exponential, which alone it reaches.
    AllOperands,
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

    /// Whether the mutant is shown to be equivalent by this miter of its module.
    pub(crate) fn equivalent(&self, mutant: &Mutant, by: Miter) -> Result<bool, MutateError> {
        let Some(netlist) = self.netlists.get(&mutant.module) else {
            return Ok(false);
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
        let found = match by {
            Miter::FromZero => self.same_from_zero(&names, mutant)?,
            _ => self.same_from_any_state(&names, mutant)?,
        };
        for name in names {
            self.remove(&name)?;
        }
        Ok(found)
    }

    fn remove(&self, name: &str) -> Result<(), MutateError> {
        let path = self.design.folder().join(name);
        std::fs::remove_file(&path).map_err(|error| MutateError::File { path, error })
    }

    fn same_from_any_state(
        &self,
        [gold, fault]: &[String; 2],
        mutant: &Mutant,
    ) -> Result<bool, MutateError> {
        let Some(said) = self.abc(&format!("cec {gold} {fault}"), mutant)? else {
            return Ok(false);
        };
        outcome(&said).ok_or_else(|| no_result("yosys-abc", &mutant.what(), &said))
    }

    fn same_from_zero(
        &self,
        [gold, fault]: &[String; 2],
        mutant: &Mutant,
    ) -> Result<bool, MutateError> {
        let number = mutant.number;
        let [first, second, left] = ["gold", "fault", "left"].map(|n| format!("{number}-{n}.aig"));
        // The conflicts of a comparison are few: most candidates within multipliers are none.
        let commands = format!(
            "read_blif {gold}; strash; zero; write_aiger {first}; \
             read_blif {fault}; strash; zero; write_aiger {second}; \
             miter {first} {second}; strash; lcorr; scorr -C 100; strash; write_aiger {left}"
        );
        let Some(said) = self.abc(&commands, mutant)? else {
            return Ok(false);
        };
        let path = self.design.folder().join(&left);
        let file = std::fs::read(&path).unwrap_or_default();
        let is_nothing =
            nothing_left(&file).ok_or_else(|| no_result("yosys-abc", &mutant.what(), &said))?;
        for name in [first, second, left] {
            self.remove(&name)?;
        }
        Ok(is_nothing)
    }

    /// What ABC says; nothing if it takes too long.
    fn abc(&self, commands: &str, mutant: &Mutant) -> Result<Option<String>, MutateError> {
        let mut abc = Command::new("yosys-abc");
        abc.current_dir(self.design.folder());
        abc.arg("-c").arg(commands);
        match child::run(&abc, LIMIT) {
            Ok(done) => Ok(Some(text(&done))),
            Err(Fault::Late { .. }) => Ok(None),
            Err(fault) => Err(broken("yosys-abc", &mutant.what(), fault)),
        }
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

/// Whether a miter in AIGER is the constant 0: it has no register and no gate, and its output is the
/// literal 0.
fn nothing_left(aiger: &[u8]) -> Option<bool> {
    let mut lines = aiger.split(|byte| *byte == b'\n');
    let head = std::str::from_utf8(lines.next()?).ok()?;
    let fields: Vec<&str> = head.split(' ').collect();
    let ["aig", _, _, registers, "1", gates] = fields[..] else {
        return None;
    };
    let output = (registers == "0").then(|| lines.next()).flatten();
    Some(registers == "0" && gates == "0" && output == Some(b"0"))
}

/// A netlist in which mutant `number` is active: the inputs that select are constants.
fn fixed(netlist: &str, width: u32, number: usize) -> String {
    let mut text = String::with_capacity(netlist.len() + 64 * width as usize);
    let select = format!("{SELECT}[");
    // The modules below have such an input, too.
    let below = format!(".{select}");
    let is_other = |name: &&str| !name.starts_with(&select) && !name.contains(&below);
    for line in netlist.lines() {
        if let [kind @ (".inputs" | ".outputs"), names @ ..] =
            &line.split_whitespace().collect::<Vec<_>>()[..]
        {
            let others: Vec<&str> = names.iter().copied().filter(is_other).collect();
            text += &format!("{kind} {}", others.join(" "));
        } else {
            text += line;
        }
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
        let netlist = ".model m\n.inputs a potamoi_mutant[0] potamoi_mutant[1] b\n\
                       .outputs q part.potamoi_mutant[0]\n\
                       .names a b q\n11 1\n.end\n";
        let expected = ".model m\n.inputs a b\n.outputs q\n.names potamoi_mutant[0]\n\
                        .names potamoi_mutant[1]\n1\n.names a b q\n11 1\n.end\n";
        assert_eq!(fixed(netlist, 2, 2), expected);
    }

    #[test]
    fn a_constant_miter_is_told_from_others() {
        assert_eq!(nothing_left(b"aig 90 90 0 1 0\n0\nc\n"), Some(true));
        assert_eq!(nothing_left(b"aig 90 90 0 1 0\n1\nc\n"), Some(false));
        assert_eq!(nothing_left(b"aig 95 90 2 1 3\n0\n0\n8\n"), Some(false));
        assert_eq!(nothing_left(b""), None);
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
