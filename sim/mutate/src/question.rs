//! What is asked of a unit with and without a fault, as text of SMT-LIB.
//!
//! Yosys writes a unit as functions of its state. Here they get five states: without and with the
//! fault, the ones after these, and one with the same registers and other inputs. The registers and
//! inputs of the first two are the same constants, so that what the fault does not reach is the same term.

use std::collections::BTreeSet;
use std::fmt::Write as _;

use crate::design::SELECT;

/// The output that tells of inputs that break their promises.
const FLAGS: &str = "stat_errors";
/// Number of the active mutant.
const ACTIVE: &str = "active";
/// The states; the last bit is the fault.
const GOLD: &str = "#b000";
const FAULT: &str = "#b001";
const GOLD_NEXT: &str = "#b010";
const FAULT_NEXT: &str = "#b011";
/// Registers of the first two, and other inputs.
const RUNNING: &str = "#b100";
const STATES: [&str; 5] = [GOLD, FAULT, GOLD_NEXT, FAULT_NEXT, RUNNING];

/// A unit in its states, and what has to be equal in them.
pub(crate) struct Question {
    top: String,
    steps: String,
    /// Wires that tell that checks count and pipelines are filled.
    counting: Vec<String>,
    /// Whether the unit has a reset.
    has_reset: bool,
    /// Equalities of outputs, of next registers, and of the flags that follow.
    outputs: Vec<String>,
    registers: Vec<String>,
    flags: Vec<String>,
}

impl Question {
    /// Reads what Yosys writes of a unit with its checks and mutants, and of its hardware alone.
    /// Registers whose names begin as `apart` may differ without and with the fault.
    ///
    /// # Errors
    /// What is not as Yosys writes it.
    pub(crate) fn new(
        top: &str,
        mutated: &str,
        hardware: &str,
        apart: &[&str],
    ) -> Result<Self, String> {
        let is_apart = |name: &str| apart.iter().any(|start| name.starts_with(start));
        if !free(mutated).any(|(_, name)| is_select(name)) {
            return Err("no input tells which mutant is active".to_owned());
        }
        let undriven =
            |function: &str| hardware.contains(&format!("; yosys-smt2-anyseq {function} "));
        let unnamed =
            |(function, name): &(&str, &str)| name.starts_with('$') && !undriven(function);
        if let Some((_, name)) = free(hardware).find(unnamed) {
            return Err(format!("register {name} has no name"));
        }
        let defined: BTreeSet<&str> = defined(mutated).collect();
        let equal = |name: &str, [gold, fault]: [&str; 2]| {
            let function = format!("{top}_n {name}");
            match defined.contains(function.as_str()) {
                true => Ok(format!("(= (|{function}| {gold}) (|{function}| {fault}))")),
                false => Err(format!("`{name}` is not there with the checks")),
            }
        };
        let next = [GOLD_NEXT, FAULT_NEXT];
        let registers = listed(hardware, "register").filter(|name| !is_apart(name));
        let outputs = listed(hardware, "output").filter(|name| !name.ends_with(SELECT));
        let flags = outputs.clone().filter(|name| *name == FLAGS);
        let wires = defined.iter();
        let wires = wires.filter_map(|function| function.strip_prefix(&format!("{top}_n ")));
        let counting = wires.filter(|name| {
            let last = name.rsplit('.').next().unwrap_or(name);
            ["checking", "is_filled"].contains(&last)
        });
        Ok(Self {
            top: top.to_owned(),
            steps: in_states(top, mutated, is_apart),
            counting: counting.map(str::to_owned).collect(),
            has_reset: listed(hardware, "input").any(|name| name == "rst_n"),
            registers: registers
                .map(|name| equal(name, next))
                .collect::<Result<_, _>>()?,
            flags: flags
                .map(|name| equal(name, next))
                .collect::<Result<_, _>>()?,
            outputs: outputs
                .map(|name| equal(name, [GOLD, FAULT]))
                .collect::<Result<_, _>>()?,
        })
    }

    /// Whether a mutant can be told from none in these cases: while the unit runs, by its outputs and
    /// next registers; by its flags, whatever the inputs; and in a clock of a reset, by its next registers.
    pub(crate) fn cases(&self, mutant: usize, width: u32) -> Vec<String> {
        let both = [&self.outputs[..], &self.registers].concat();
        let promises = format!("(assert (|{}_u| {GOLD}))\n", self.top);
        let mut all = vec![self.differs(mutant, width, &(self.reached(GOLD) + &promises), &both)];
        if !self.flags.is_empty() {
            all.push(self.differs(mutant, width, &self.reached(GOLD), &self.flags));
        }
        if self.has_reset {
            let reset = format!("(assert (not (|{}_n rst_n| {GOLD})))\n", self.top);
            let given = self.reached(RUNNING) + &reset;
            all.push(self.differs(mutant, width, &given, &self.registers));
        }
        all
    }

    /// Whether a mutant can be told from none while the wire `chosen` is low.
    pub(crate) fn while_low(&self, chosen: &str, mutant: usize, width: u32) -> String {
        let both = [&self.outputs[..], &self.registers].concat();
        let low = format!("(assert (not (|{}_n {chosen}| {GOLD})))\n", self.top);
        self.differs(mutant, width, &(self.reached(GOLD) + &low), &both)
    }

    /// The properties hold in a state, in which they count.
    fn reached(&self, state: &str) -> String {
        let top = &self.top;
        let mut text = format!("(assert (|{top}_a| {state}))\n");
        for name in &self.counting {
            // Writing to a string does not fail.
            let _ = writeln!(text, "(assert (|{top}_n {name}| {state}))");
        }
        text
    }

    fn differs(&self, mutant: usize, width: u32, given: &str, equalities: &[String]) -> String {
        let width = width as usize;
        format!(
            "(set-logic QF_BV)\n(define-fun {ACTIVE} () (_ BitVec {width}) #b{mutant:0width$b})\n\
             {}{given}(assert (not (and true {})))\n(check-sat)\n",
            self.steps,
            equalities.join(" ")
        )
    }
}

/// The functions of a unit in all states, and the steps between them.
fn in_states(top: &str, smt2: &str, is_apart: impl Fn(&str) -> bool) -> String {
    let sort = format!("(declare-sort |{top}_s| 0)");
    let state = format!(" (|{top}_s|) ");
    let registers: BTreeSet<&str> = listed(smt2, "register").collect();
    let inputs: BTreeSet<&str> = listed(smt2, "input").collect();
    let mut text = String::with_capacity(2 * smt2.len());
    for line in smt2.lines() {
        let declared = line.strip_prefix("(declare-fun |").and_then(|rest| {
            let (function, rest) = rest.split_once('|')?;
            let (of, name) = rest.split_once(" ; ").unwrap_or((rest, ""));
            let name = name.trim_start_matches('\\');
            Some((function, of.strip_prefix(&state)?.strip_suffix(')')?, name))
        });
        // Writing to a string does not fail.
        let _ = match declared {
            _ if line == sort => writeln!(text, "(define-sort |{top}_s| () (_ BitVec 3))"),
            None => writeln!(text, "{line}"),
            Some((function, of, name)) if is_select(name) => writeln!(
                text,
                "(define-fun |{function}| ((state |{top}_s|)) {of} \
                 (ite (= ((_ extract 0 0) state) #b0) (bvxor {ACTIVE} {ACTIVE}) {ACTIVE}))"
            ),
            Some((function, of, name)) => {
                let differs = registers.contains(name) && is_apart(name);
                let others = [
                    (GOLD_NEXT, "next", true),
                    (FAULT_NEXT, "faulty next", true),
                    (FAULT, "faulty", differs),
                    (RUNNING, "running", inputs.contains(name)),
                ];
                let _ = writeln!(text, "(declare-fun |gold {function}| () {of})");
                let mut value = format!("|gold {function}|");
                for (state, own, _) in others.into_iter().filter(|(.., has_own)| *has_own) {
                    let _ = writeln!(text, "(declare-fun |{own} {function}| () {of})");
                    value = format!("(ite (= state {state}) |{own} {function}| {value})");
                }
                writeln!(
                    text,
                    "(define-fun |{function}| ((state |{top}_s|)) {of} {value})"
                )
            }
        };
    }
    for state in STATES {
        let _ = writeln!(text, "(assert (|{top}_h| {state}))");
    }
    for (from, to) in [(GOLD, GOLD_NEXT), (FAULT, FAULT_NEXT)] {
        let _ = writeln!(text, "(assert (|{top}_t| {from} {to}))");
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
    #![allow(clippy::unwrap_used, clippy::panic)]
    use super::*;

    const HARDWARE: &str = "\
        ; yosys-smt2-input rst_n 1\n\
        (declare-fun |m#2| (|m_s|) Bool) ; \\rst_n\n\
        (declare-fun |m#1| (|m_s|) (_ BitVec 2)) ; \\count\n\
        ; yosys-smt2-register count 2\n\
        (define-fun |m_n count| ((state |m_s|)) (_ BitVec 2) (|m#1| state))\n\
        ; yosys-smt2-output full 1\n\
        (define-fun |m_n full| ((state |m_s|)) Bool true)\n\
        (define-fun |m_n fifo.checking| ((state |m_s|)) Bool true)\n";

    #[test]
    fn registers_and_outputs_are_compared() {
        let select = format!("(declare-fun |m#0| (|m_s|) (_ BitVec 1)) ; \\{SELECT}\n");
        let mutated = format!("{select}{HARDWARE}");
        let question = Question::new("m", &mutated, HARDWARE, &[]).unwrap();
        let count = "(= (|m_n count| #b010) (|m_n count| #b011))";
        assert_eq!(question.registers, [count]);
        assert_eq!(
            question.outputs,
            ["(= (|m_n full| #b000) (|m_n full| #b001))"]
        );
        assert!(question.flags.is_empty());
        assert_eq!(question.counting, ["fifo.checking"]);
        // The register is the same constant without and with the fault, an input may be another one in
        // the state that shows that the unit runs, and the mutant is none.
        for (constant, is_there) in [
            ("|gold m#1|", true),
            ("|faulty m#1|", false),
            ("|running m#1|", false),
            ("|running m#2|", true),
            ("|gold m#0|", false),
        ] {
            assert_eq!(question.steps.contains(constant), is_there, "{constant}");
        }
        let [running, reset] = &question.cases(1, 1)[..] else {
            panic!("{:?}", question.cases(1, 1));
        };
        assert!(
            running.contains("(assert (|m_n fifo.checking| #b000))"),
            "{running}"
        );
        assert!(
            reset.contains("(assert (not (|m_n rst_n| #b000)))"),
            "{reset}"
        );
        assert!(
            reset.contains("(assert (|m_n fifo.checking| #b100))"),
            "{reset}"
        );
        let apart = Question::new("m", &mutated, HARDWARE, &["cou"]).unwrap();
        assert!(apart.registers.is_empty());
        assert!(apart.steps.contains("|faulty m#1|"), "{}", apart.steps);
        // A register that is not found would not be compared.
        let without = mutated.replace("m_n count", "m_n other");
        assert!(Question::new("m", &without, HARDWARE, &[]).is_err());
        let unnamed = HARDWARE.replace("; \\count", "; $auto$7");
        assert!(Question::new("m", &mutated, &unnamed, &[]).is_err());
    }
}
