//! Whether a mutant is equivalent where it is used.
//!
//! A unit with the fault is compared with the unit without it, from all states in which its proven
//! properties hold: with equal registers and inputs, all outputs, all inputs of modules that carry data
//! and all next values of registers have to be equal. Then both run alike, as long as what is assumed of
//! the inputs holds, and once pipelines are filled with operands that entered after the start. Error
//! flags are compared without these assumptions: they are for inputs that break them. A reset is compared
//! from the same states.
//!
//! Where next registers differ, each register of one bit in their module is tried as their valid bit: they
//! may differ while it is low, before the clock and after it, and all else has to be equal.

use std::collections::BTreeSet;
use std::process::Command;
use std::time::Duration;

use potamoi_prove::Unit;
use potamoi_verilated::child;

use crate::case::{Case, Compared, Unread};
use crate::design::SELECT;
use crate::question::Question;
use crate::tools::{broken, no_result, read, text, write};
use crate::{Mutant, MutateError, Tools};

/// Time limit of one comparison.
const LIMIT: Duration = Duration::from_secs(600);
/// Most registers that may differ where nothing reads them.
const MOST_UNREAD: usize = 32;
/// Begins of the names of a pipelined exponential's registers.
const EXPONENTIAL: [&str; 4] = ["s_", "digits_stages", "rescaled_stages", "filled"];
/// The input of a lane that is high where the result is that of an exponential.
pub(crate) const CHOSEN: &str = "result_is_exp";
/// The netlist with its checks and its mutants, and the hardware alone.
const FILES: [&str; 2] = ["mutated.smt2", "hardware.smt2"];

/// A unit, or a module that is proven alone, with mutants.
pub(crate) struct UnitMiter {
    pub(crate) unit: Unit,
    modules: BTreeSet<String>,
    folder: tempfile::TempDir,
    question: Question,
    /// Of a lane, the same with any contents of a pipelined exponential, which are not compared.
    beside_exponential: Option<Question>,
    width: u32,
}

impl UnitMiter {
    /// Builds the unit with the mutants of its modules. All its properties have to be proven.
    pub(crate) fn new(
        tools: &Tools,
        unit: &Unit,
        mutants: &[&Mutant],
        width: u32,
    ) -> Result<Self, MutateError> {
        let modules = unit.modules();
        let folder = unit.files()?;
        let own = mutants.iter().filter(|m| modules.contains(&m.module));
        let mut faults = vec![format!("add -global_input {SELECT} {width}")];
        faults.extend(own.map(|m| format!("{} -ctrl {SELECT} {width} {}", m.command, m.number)));
        for (to, faults) in FILES.iter().zip([Some(faults), None]) {
            tools.yosys(folder.path(), &script(unit, faults, to), &unit.name)?;
        }
        let [mutated, hardware] = FILES.map(|name| read(&folder.path().join(name)));
        let (mutated, hardware) = (mutated?, hardware?);
        let ask = |apart: &[&str]| {
            let question = Question::new(unit.module.name(), &mutated, &hardware, apart);
            question.map_err(|wrong| no_result("yosys", &unit.name, &wrong))
        };
        let is_lane = unit.module.ports().iter().any(|port| port.name == CHOSEN);
        let beside_exponential = is_lane.then(|| ask(&EXPONENTIAL)).transpose()?;
        Ok(Self {
            question: ask(&[])?,
            beside_exponential,
            unit: unit.clone(),
            modules,
            folder,
            width,
        })
    }

    pub(crate) fn has(&self, mutant: &Mutant) -> bool {
        self.modules.contains(&mutant.module)
    }

    /// Whether the unit with the mutant cannot be told from the one without.
    pub(crate) fn equivalent(&self, mutant: &Mutant) -> Result<bool, MutateError> {
        let found = self.differences(mutant, None)?;
        let registers: Vec<&String> = found.iter().filter_map(register).collect();
        // From equal registers an output differs.
        let Some(first) = registers.first().filter(|_| registers.len() == found.len()) else {
            return Ok(found.is_empty());
        };
        for valid in self.question.bits_beside(first) {
            if self.is_unread_while_low(valid, mutant)? {
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// Whether nothing but registers differs, and those only while the register `valid` is low.
    fn is_unread_while_low(&self, valid: &str, mutant: &Mutant) -> Result<bool, MutateError> {
        let mut unread = Unread {
            valid,
            registers: BTreeSet::new(),
        };
        while unread.registers.len() < MOST_UNREAD {
            let found = self.differences(mutant, Some(&unread))?;
            if found.is_empty() {
                return Ok(true);
            }
            for one in &found {
                let new = register(one).filter(|name| *name != valid);
                if !new.is_some_and(|name| unread.registers.insert(name.clone())) {
                    return Ok(false);
                }
            }
        }
        Ok(false)
    }

    /// What can be told apart in the first case in which there is something.
    fn differences(
        &self,
        mutant: &Mutant,
        unread: Option<&Unread<'_>>,
    ) -> Result<Vec<Compared>, MutateError> {
        for case in self.question.cases(mutant.number, self.width, unread) {
            let found = self.asked(mutant, &case)?;
            if !found.is_empty() {
                return Ok(found);
            }
        }
        Ok(vec![])
    }

    /// Whether a mutant of a lane changes nothing but results of the exponential.
    pub(crate) fn reaches_the_exponential_alone(
        &self,
        mutant: &Mutant,
    ) -> Result<bool, MutateError> {
        let Some(question) = &self.beside_exponential else {
            return Ok(false);
        };
        let case = question.while_low(CHOSEN, mutant.number, self.width);
        Ok(self.asked(mutant, &case)?.is_empty())
    }

    /// What differs in a state in which the mutant can be told from none; nothing if there is no such
    /// state.
    fn asked(&self, mutant: &Mutant, case: &Case) -> Result<Vec<Compared>, MutateError> {
        let file = format!("{}.smt2", mutant.number);
        let path = self.folder.path().join(&file);
        write(&path, &case.query)?;
        let mut yices = Command::new("yices-smt2");
        yices.arg(&file).current_dir(self.folder.path());
        let what = mutant.what();
        let done = child::run(&yices, LIMIT).map_err(|e| broken("yices-smt2", &what, e))?;
        std::fs::remove_file(&path).map_err(|error| MutateError::File { path, error })?;
        let said = text(&done);
        let found = case
            .differences(&said)
            .map_err(|said| no_result("yices-smt2", &self.unit.name, &said))?;
        Ok(found.into_iter().cloned().collect())
    }
}

/// The register of a comparison of one.
const fn register(compared: &Compared) -> Option<&String> {
    match compared {
        Compared::Register(name) => Some(name),
        Compared::Output(_) | Compared::Flag(_) => None,
    }
}

/// Commands that write the unit as functions of its state: with its checks and faults, or its
/// hardware alone.
fn script(unit: &Unit, faults: Option<Vec<String>>, to: &str) -> Vec<String> {
    let top = unit.module.name();
    let mut lines = unit.load().to_vec();
    if faults.is_none() {
        lines.push("delete */t:potamoi_* */t:$paramod*potamoi_*".to_owned());
    }
    lines.push(format!("hierarchy -top {top}"));
    match faults {
        Some(faults) => lines.extend(faults),
        None => lines.push("opt_clean -purge".to_owned()),
    }
    let data = unit.module.data_modules_beside(&unit.apart);
    let data: Vec<String> = data.into_iter().collect();
    if !data.is_empty() {
        lines.push(format!("blackbox {}", data.join(" ")));
    }
    let passes = [
        "flatten",
        "delete t:$cover",
        "memory_map",
        "async2sync",
        "dffunmap",
    ];
    lines.extend(passes.map(str::to_owned));
    // What is undefined is the same in all mutants.
    lines.push("setundef -zero".to_owned());
    // What nothing drives, such as a view into a module that carries data, is anything.
    lines.push("setundef -undriven -anyseq".to_owned());
    if !data.is_empty() {
        let data: Vec<String> = data.iter().map(|d| format!("{top}/t:{d}")).collect();
        lines.push(format!("expose -evert -sep : {}", data.join(" ")));
    }
    lines.push("opt_clean".to_owned());
    lines.push(format!("write_smt2 -wires {to}"));
    lines
}
