//! What is asked of a unit with and without a fault, as text of SMT-LIB.
//!
//! Yosys writes a unit as functions of its state. Here they get five states: without and with the
//! fault, the ones after these, and one with the same registers and other inputs. The registers and
//! inputs of the first two are the same constants, so that what the fault does not reach is the same term.

use std::collections::BTreeSet;
use std::fmt::Write as _;

use crate::case::{Case, Compared, Unread, same};
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
    /// The unit as Yosys writes it, and the registers that may always differ.
    netlist: String,
    apart: Vec<String>,
    steps: String,
    /// Wires that tell that checks count and pipelines are filled.
    counting: Vec<String>,
    /// Whether the unit has a reset.
    has_reset: bool,
    outputs: Vec<Compared>,
    registers: Vec<Compared>,
    flags: Vec<Compared>,
    /// Registers of one bit.
    bits: Vec<String>,
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
        let is_apart = |name: &str| begins_as(name, apart);
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
        let there = |name: &str| match defined.contains(format!("{top}_n {name}").as_str()) {
            true => Ok(name.to_owned()),
            false => Err(format!("`{name}` is not there with the checks")),
        };
        let registers = listed(hardware, "register").filter(|(name, _)| !is_apart(name));
        let bits = registers.clone().filter(|(_, width)| *width == "1");
        let outputs = listed(hardware, "output").map(|(name, _)| name);
        let outputs = outputs.filter(|name| !name.ends_with(SELECT));
        let flags = outputs.clone().filter(|name| *name == FLAGS);
        let wires = defined.iter();
        let wires = wires.filter_map(|function| function.strip_prefix(&format!("{top}_n ")));
        let counting = wires.filter(|name| {
            let last = name.rsplit('.').next().unwrap_or(name);
            ["checking", "is_filled"].contains(&last)
        });
        Ok(Self {
            top: top.to_owned(),
            netlist: mutated.to_owned(),
            apart: apart.iter().map(|&start| start.to_owned()).collect(),
            steps: in_states(top, mutated, is_apart),
            counting: counting.map(str::to_owned).collect(),
            has_reset: listed(hardware, "input").any(|(name, _)| name == "rst_n"),
            bits: bits.map(|(name, _)| name.to_owned()).collect(),
            registers: registers
                .map(|(name, _)| there(name).map(Compared::Register))
                .collect::<Result<_, _>>()?,
            flags: flags
                .map(|name| there(name).map(Compared::Flag))
                .collect::<Result<_, _>>()?,
            outputs: outputs
                .map(|name| there(name).map(Compared::Output))
                .collect::<Result<_, _>>()?,
        })
    }

    /// Registers of one bit in the scope of a register, beside it.
    pub(crate) fn bits_beside(&self, register: &str) -> impl Iterator<Item = &str> {
        let scope = |name: &str| name.rsplit_once('.').map(|(scope, _)| scope.to_owned());
        let own = scope(register);
        let bits = self.bits.iter().map(String::as_str);
        bits.filter(move |bit| *bit != register && scope(bit) == own)
    }

    /// Whether a mutant can be told from none in these cases: while the unit runs, by its outputs and
    /// next registers; by its flags, whatever the inputs; and in a clock of a reset, by its next registers.
    /// Registers may differ where they are `unread`, before and after.
    pub(crate) fn cases(
        &self,
        mutant: usize,
        width: u32,
        unread: Option<&Unread<'_>>,
    ) -> Vec<Case> {
        let own = unread.map(|unread| {
            let is_apart = |name: &str| {
                let starts: Vec<&str> = self.apart.iter().map(String::as_str).collect();
                begins_as(name, &starts) || unread.registers.contains(name)
            };
            in_states(&self.top, &self.netlist, is_apart)
        });
        let steps = own.as_deref().unwrap_or(&self.steps);
        let related = unread.map_or(String::new(), |unread| self.related(unread));
        let case = |given: &str, compared: &[Compared]| {
            let given = format!("{related}{given}");
            self.differs((steps, unread), (mutant, width), &given, compared)
        };
        let both = [&self.outputs[..], &self.registers].concat();
        let promises = format!("(assert (|{}_u| {GOLD}))\n", self.top);
        let mut all = vec![case(&(self.reached(GOLD) + &promises), &both)];
        if !self.flags.is_empty() {
            all.push(case(&self.reached(GOLD), &self.flags));
        }
        if self.has_reset {
            let reset = format!("(assert (not (|{}_n rst_n| {GOLD})))\n", self.top);
            all.push(case(&(self.reached(RUNNING) + &reset), &self.registers));
        }
        all
    }

    /// Whether a mutant can be told from none while the wire `chosen` is low.
    pub(crate) fn while_low(&self, chosen: &str, mutant: usize, width: u32) -> Case {
        let both = [&self.outputs[..], &self.registers].concat();
        let low = format!("(assert (not (|{}_n {chosen}| {GOLD})))\n", self.top);
        let given = self.reached(GOLD) + &low;
        self.differs((&self.steps, None), (mutant, width), &given, &both)
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

    /// Unread registers are equal before, unless nothing reads them.
    fn related(&self, unread: &Unread<'_>) -> String {
        let registers = unread.registers.iter();
        let equal = registers.map(|name| self.equal(name, [GOLD, FAULT], Some(unread)));
        equal.map(|equal| format!("(assert {equal})\n")).collect()
    }

    /// Whether a wire is equal in two states; that of an unread register unless nothing reads it.
    fn equal(&self, name: &str, [gold, fault]: [&str; 2], unread: Option<&Unread<'_>>) -> String {
        let top = &self.top;
        let equal = format!("(= (|{top}_n {name}| {gold}) (|{top}_n {name}| {fault}))");
        match unread.filter(|unread| unread.registers.contains(name)) {
            Some(Unread { valid, .. }) => format!("(or (not (|{top}_n {valid}| {gold})) {equal})"),
            None => equal,
        }
    }

    fn differs(
        &self,
        (steps, unread): (&str, Option<&Unread<'_>>),
        (mutant, width): (usize, u32),
        given: &str,
        compared: &[Compared],
    ) -> Case {
        let width = width as usize;
        let mut query = format!(
            "(set-option :produce-models true)\n(set-logic QF_BV)\n\
             (define-fun {ACTIVE} () (_ BitVec {width}) #b{mutant:0width$b})\n{steps}{given}"
        );
        for (number, one) in compared.iter().enumerate() {
            let equal = match one {
                Compared::Output(name) => self.equal(name, [GOLD, FAULT], None),
                Compared::Flag(name) => self.equal(name, [GOLD_NEXT, FAULT_NEXT], None),
                Compared::Register(name) => self.equal(name, [GOLD_NEXT, FAULT_NEXT], unread),
            };
            // Writing to a string does not fail.
            let _ = writeln!(query, "(define-fun {} () Bool {equal})", same(number));
        }
        let all: Vec<String> = (0..compared.len()).map(same).collect();
        let all = all.join(" ");
        let _ = writeln!(
            query,
            "(assert (not (and true {all})))\n(check-sat)\n(get-value ({all}))"
        );
        Case {
            query,
            compared: compared.to_vec(),
        }
    }
}

fn begins_as(name: &str, starts: &[&str]) -> bool {
    starts.iter().any(|start| name.starts_with(start))
}

/// The functions of a unit in all states, and the steps between them.
fn in_states(top: &str, smt2: &str, is_apart: impl Fn(&str) -> bool) -> String {
    let sort = format!("(declare-sort |{top}_s| 0)");
    let state = format!(" (|{top}_s|) ");
    let names = |kind| listed(smt2, kind).map(|(name, _)| name);
    let registers: BTreeSet<&str> = names("register").collect();
    let inputs: BTreeSet<&str> = names("input").collect();
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

/// Names and widths that Yosys lists of a kind.
fn listed<'a>(smt2: &'a str, kind: &str) -> impl Iterator<Item = (&'a str, &'a str)> + Clone {
    let start = format!("; yosys-smt2-{kind} ");
    smt2.lines()
        .filter_map(move |line| line.strip_prefix(&start)?.rsplit_once(' '))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
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
        let [count, full] = ["count", "full"].map(str::to_owned);
        assert_eq!(question.registers, [Compared::Register(count.clone())]);
        assert_eq!(question.outputs, [Compared::Output(full)]);
        let query = &question.cases(1, 1, None)[0].query;
        for equal in [
            "(= (|m_n full| #b000) (|m_n full| #b001))",
            "(= (|m_n count| #b010) (|m_n count| #b011))",
        ] {
            assert!(query.contains(&format!("Bool {equal})")), "{query}");
        }
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
        let cases = question.cases(1, 1, None);
        let [running, reset] = [0, 1].map(|n| &cases[n].query);
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
        // Where nothing reads it, the register may differ before and after.
        let unread = Unread {
            valid: "valid",
            registers: BTreeSet::from([count]),
        };
        let cases = question.cases(1, 1, Some(&unread));
        let query = &cases[0].query;
        assert!(query.contains("|faulty m#1|"), "{query}");
        for [gold, fault] in [["#b000", "#b001"], ["#b010", "#b011"]] {
            let equal = format!(
                "(or (not (|m_n valid| {gold})) (= (|m_n count| {gold}) (|m_n count| {fault})))"
            );
            assert!(query.contains(&equal), "{query}");
        }
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
