//! Whether a mutant is equivalent where it is used.
//!
//! A unit with the fault is compared with the unit without it, from all states in which its proven
//! properties hold: with equal registers and inputs, all outputs, all inputs of modules that carry data
//! and all next values of registers have to be equal. Then both run alike for ever, as long as what is
//! assumed of the inputs holds, once pipelines are filled with what entered after the start. Error flags are compared without these assumptions: they are for inputs
//! that break them.

use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::process::Command;
use std::time::Duration;

use potamoi_prove::Unit;
use potamoi_verilated::child;

use crate::design::SELECT;
use crate::tools::{broken, no_result, read, text, write};
use crate::{Mutant, MutateError, Tools};

/// Time limit of one comparison.
const LIMIT: Duration = Duration::from_secs(600);
/// Begins of the names of a pipelined exponential's registers.
const REGISTERS: [&str; 4] = ["s_", "digits_stages", "rescaled_stages", "filled"];
/// The input of a lane that is high where the result is that of an exponential.
pub(crate) const CHOSEN: &str = "result_is_exp";
/// The output that tells of inputs that break their promises.
const FLAGS: &str = "stat_errors";
/// States without and with the fault, and those after them, as two bits.
const GOLD: &str = "#b00";
const FAULT: &str = "#b01";
const GOLD_NEXT: &str = "#b10";
const FAULT_NEXT: &str = "#b11";
/// Number of the active mutant.
const ACTIVE: &str = "active";
/// The netlist with its checks and its mutants, and the hardware alone.
const FILES: [&str; 2] = ["mutated.smt2", "hardware.smt2"];

/// A unit, or a module that is proven alone, with mutants.
pub(crate) struct UnitMiter {
    pub(crate) unit: Unit,
    modules: BTreeSet<String>,
    folder: tempfile::TempDir,
    /// The two steps with and without a fault, and what has to be equal in them.
    question: Question,
    /// The same, with any contents of a pipelined exponential, which are not compared.
    beside_exponential: Question,
    width: u32,
}

struct Question {
    steps: String,
    /// Equalities of all outputs and next states, and those of the flags.
    all: Vec<String>,
    flags: Vec<String>,
    assumed: String,
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
        let top = unit.module.name();
        let (mutated, hardware) = (mutated?, hardware?);
        let ask = |apart: &[&str]| {
            let question = Question::new(top, &mutated, &hardware, apart);
            question.map_err(|wrong| no_result("yosys", &unit.name, &wrong))
        };
        let question = ask(&[])?;
        let mut beside_exponential = ask(&REGISTERS)?;
        beside_exponential.assumed = format!("(assert (not (|{top}_n {CHOSEN}| {GOLD})))");
        Ok(Self {
            unit: unit.clone(),
            modules,
            folder,
            question,
            beside_exponential,
            width,
        })
    }

    pub(crate) fn has(&self, mutant: &Mutant) -> bool {
        self.modules.contains(&mutant.module)
    }

    /// Whether the unit with the mutant cannot be told from the one without.
    pub(crate) fn equivalent(&self, mutant: &Mutant) -> Result<bool, MutateError> {
        let of = &self.question;
        let none = (of.flags.is_empty()).then_some(Ok(true));
        let flags = |this: &Self| this.holds(of, mutant, "", &of.flags);
        Ok(self.holds(of, mutant, &of.assumed, &of.all)? && none.unwrap_or_else(|| flags(self))?)
    }

    /// Whether a mutant of a lane changes nothing but results of the exponential.
    pub(crate) fn reaches_the_exponential_alone(
        &self,
        mutant: &Mutant,
    ) -> Result<bool, MutateError> {
        let of = &self.beside_exponential;
        self.holds(of, mutant, &of.assumed, &of.all)
    }

    /// Whether these equalities hold in both steps with the mutant and without.
    fn holds(
        &self,
        question: &Question,
        mutant: &Mutant,
        assumed: &str,
        equalities: &[String],
    ) -> Result<bool, MutateError> {
        let number = mutant.number;
        let width = self.width as usize;
        let steps = &question.steps;
        let mut query = format!(
            "(set-logic QF_BV)\n(define-fun {ACTIVE} () (_ BitVec {width}) #b{number:0width$b})\n\
             {steps}{assumed}\n"
        );
        // Writing to a string does not fail.
        let _ = writeln!(query, "(assert (not (and true {})))", equalities.join(" "));
        query += "(check-sat)\n";
        let flags = if assumed.is_empty() { "-flags" } else { "" };
        let file = format!("{number}{flags}.smt2");
        let path = self.folder.path().join(&file);
        write(&path, &query)?;
        let mut yices = Command::new("yices-smt2");
        yices.arg(&file).current_dir(self.folder.path());
        let what = mutant.what();
        let done = child::run(&yices, LIMIT).map_err(|e| broken("yices-smt2", &what, e))?;
        std::fs::remove_file(&path).map_err(|error| MutateError::File { path, error })?;
        match text(&done).trim() {
            "unsat" => Ok(true),
            "sat" => Ok(false),
            said => Err(no_result("yices-smt2", &self.unit.name, said)),
        }
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

impl Question {
    /// # Errors
    /// What is not as Yosys writes it.
    /// Registers whose names begin as `apart` need not be equal.
    fn new(top: &str, mutated: &str, hardware: &str, apart: &[&str]) -> Result<Self, String> {
        let is_apart = |name: &str| apart.iter().any(|start| name.starts_with(start));
        if !free(mutated).any(|(_, name)| is_select(name)) {
            return Err("no input tells which mutant is active".to_owned());
        }
        let registers: BTreeSet<&str> = listed(mutated, "register").collect();
        let mut steps = with_steps(top, mutated, |name| {
            registers.contains(name) && is_apart(name)
        });
        for step in [GOLD, FAULT, GOLD_NEXT, FAULT_NEXT] {
            let _ = writeln!(steps, "(assert (|{top}_h| {step}))");
        }
        let _ = writeln!(
            steps,
            "(assert (|{top}_t| {GOLD} {GOLD_NEXT}))\n(assert (|{top}_t| {FAULT} {FAULT_NEXT}))\n\
             (assert (|{top}_a| {GOLD}))"
        );
        // The checks count, and pipelines are filled.
        let checking = format!("{top}_n ");
        for name in defined(mutated).filter_map(|f| f.strip_prefix(&checking)) {
            let last = name.rsplit('.').next();
            if last.is_some_and(|last| ["checking", "is_filled"].contains(&last)) {
                let _ = writeln!(steps, "(assert (|{top}_n {name}| {GOLD}))");
            }
        }
        let all_named: BTreeSet<&str> = defined(mutated).collect();
        let equal = |name: &str, [gold, fault]: [&str; 2]| {
            let function = format!("{top}_n {name}");
            match all_named.contains(function.as_str()) {
                true => Ok(format!("(= (|{function}| {gold}) (|{function}| {fault}))")),
                false => Err(format!("`{name}` is not there with the checks")),
            }
        };
        let undriven =
            |function: &str| hardware.contains(&format!("; yosys-smt2-anyseq {function} "));
        let unnamed =
            |(function, name): &(&str, &str)| name.starts_with('$') && !undriven(function);
        if let Some((_, name)) = free(hardware).find(unnamed) {
            return Err(format!("register {name} has no name"));
        }
        let next = [GOLD_NEXT, FAULT_NEXT];
        let registers = listed(hardware, "register").filter(|name| !is_apart(name));
        let registers = registers.map(|name| equal(name, next));
        let outputs = listed(hardware, "output").filter(|name| !name.ends_with(SELECT));
        let flags = outputs.clone().filter(|name| *name == FLAGS);
        let flags = flags.map(|name| equal(name, next));
        Ok(Self {
            all: registers
                .chain(outputs.map(|name| equal(name, [GOLD, FAULT])))
                .collect::<Result<_, _>>()?,
            flags: flags.collect::<Result<_, _>>()?,
            assumed: format!("(assert (|{top}_u| {GOLD}))"),
            steps,
        })
    }
}

/// The functions of a unit with its four states. Registers and inputs without and with the fault are
/// the same constants, so that what the fault does not reach is the same term.
fn with_steps(top: &str, smt2: &str, is_apart: impl Fn(&str) -> bool) -> String {
    let sort = format!("(declare-sort |{top}_s| 0)");
    let state = format!(" (|{top}_s|) ");
    let mut text = String::with_capacity(2 * smt2.len());
    for line in smt2.lines() {
        let declared = line.strip_prefix("(declare-fun |").and_then(|rest| {
            let (function, rest) = rest.split_once('|')?;
            let (of, name) = rest.split_once(" ; ").unwrap_or((rest, ""));
            Some((function, of.strip_prefix(&state)?.strip_suffix(')')?, name))
        });
        let _ = match declared {
            _ if line == sort => writeln!(text, "(define-sort |{top}_s| () (_ BitVec 2))"),
            None => writeln!(text, "{line}"),
            Some((function, of, name)) if is_select(name) => writeln!(
                text,
                "(define-fun |{function}| ((state |{top}_s|)) {of} \
                 (ite (= ((_ extract 0 0) state) #b0) (bvxor {ACTIVE} {ACTIVE}) {ACTIVE}))"
            ),
            Some((function, of, name)) => {
                let mut value = String::new();
                for (step, state) in [
                    ("gold", GOLD),
                    ("next", GOLD_NEXT),
                    ("faulty next", FAULT_NEXT),
                ] {
                    let _ = writeln!(text, "(declare-fun |{step} {function}| () {of})");
                    let _ = write!(value, "(ite (= state {state}) |{step} {function}| ");
                }
                let fault = match is_apart(name.trim_start_matches('\\')) {
                    true => {
                        let _ = writeln!(text, "(declare-fun |faulty {function}| () {of})");
                        "faulty"
                    }
                    false => "gold",
                };
                writeln!(
                    text,
                    "(define-fun |{function}| ((state |{top}_s|)) {of} {value}|{fault} {function}|))))"
                )
            }
        };
    }
    text
}

fn is_select(name: &str) -> bool {
    name.trim_start_matches('\\') == SELECT
}

/// Functions of a state that are free, with what they are: registers and inputs.
fn free(smt2: &str) -> impl Iterator<Item = (&str, &str)> {
    smt2.lines().filter_map(|line| {
        let (function, rest) = line.strip_prefix("(declare-fun |")?.split_once("| (|")?;
        let (_, name) = rest.split_once("; ")?;
        Some((function, name))
    })
}

/// Names of the functions that are defined.
fn defined(smt2: &str) -> impl Iterator<Item = &str> {
    smt2.lines().filter_map(|line| {
        let (function, _) = line.strip_prefix("(define-fun |")?.split_once('|')?;
        Some(function)
    })
}

/// Names that Yosys lists of a kind.
fn listed<'a>(smt2: &'a str, kind: &str) -> impl Iterator<Item = &'a str> + Clone {
    let start = format!("; yosys-smt2-{kind} ");
    smt2.lines().filter_map(move |line| {
        let (name, _) = line.strip_prefix(&start)?.rsplit_once(' ')?;
        Some(name)
    })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    const HARDWARE: &str = "\
        (declare-fun |m#1| (|m_s|) (_ BitVec 2)) ; \\count\n\
        ; yosys-smt2-register count 2\n\
        (define-fun |m_n count| ((state |m_s|)) (_ BitVec 2) (|m#1| state))\n\
        ; yosys-smt2-output full 1\n\
        (define-fun |m_n full| ((state |m_s|)) Bool true)\n";

    #[test]
    fn registers_and_outputs_are_compared() {
        let select = format!("(declare-fun |m#0| (|m_s|) (_ BitVec 1)) ; \\{SELECT}\n");
        let question = Question::new("m", &format!("{select}{HARDWARE}"), HARDWARE, &[]).unwrap();
        let [count, full] = [
            "(= (|m_n count| #b10) (|m_n count| #b11))",
            "(= (|m_n full| #b00) (|m_n full| #b01))",
        ];
        assert_eq!(question.all, [count, full]);
        assert!(question.flags.is_empty());
        // The register is the same constant without and with the fault, and the mutant is none.
        assert!(question.steps.contains("|gold m#1|"), "{}", question.steps);
        assert!(
            !question.steps.contains("|faulty m#1|"),
            "{}",
            question.steps
        );
        assert!(!question.steps.contains("|gold m#0|"), "{}", question.steps);
        let apart = Question::new("m", &format!("{select}{HARDWARE}"), HARDWARE, &["cou"]).unwrap();
        assert_eq!(apart.all, [full]);
        assert!(apart.steps.contains("|faulty m#1|"), "{}", apart.steps);
        // A register that is not found would not be compared.
        let without = HARDWARE.replace("m_n count", "m_n other");
        assert!(Question::new("m", &format!("{select}{without}"), HARDWARE, &[]).is_err());
        let unnamed = HARDWARE.replace("; \\count", "; $auto$7");
        assert!(Question::new("m", &format!("{select}{HARDWARE}"), &unnamed, &[]).is_err());
    }
}
