//! Energy and timing of a cell, from the library.

use potamoi_gates::{Gate, Truth};

use super::table::{Table, Tables};
use super::unavailable::Unavailable;
use crate::liberty::Group;

/// Internal energy of a cell for a transition of a pin, in the library's unit: of its capacitance
/// times the square of its voltage. A library may state it for each rail. Charge from the supply
/// leaves through ground, so that these are two measurements of the same energy, and their mean is
/// taken.
#[derive(Debug, Clone)]
pub(super) struct Energy {
    /// Condition on inputs, outputs and the clock, in this order.
    when: Option<Truth>,
    falls: Vec<Table>,
    rises: Vec<Table>,
}

impl Energy {
    pub(super) fn of(&self, rises: bool, transition: f64, load: f64) -> f64 {
        let tables = if rises { &self.rises } else { &self.falls };
        let sum: f64 = tables.iter().map(|t| t.at(transition, load, false)).sum();
        sum / tables.len().max(1) as f64
    }
}

/// Timing arc from an input to an output.
#[derive(Debug, Clone)]
pub(super) struct Timing {
    /// Delays of a falling and of a rising output.
    delays: [Table; 2],
    transitions: [Table; 2],
}

impl Timing {
    pub(super) fn delay(&self, rises: bool, transition: f64, load: f64) -> f64 {
        self.delays[usize::from(rises)].at(transition, load, true)
    }

    /// Transition of the output, as mean of rising and falling.
    pub(super) fn transition(&self, transition: f64, load: f64) -> f64 {
        let of = |t: &Table| t.at(transition, load, true);
        (of(&self.transitions[0]) + of(&self.transitions[1])) / 2.0
    }

    pub(super) fn first_transition(&self) -> f64 {
        self.transitions[0].first_transition()
    }
}

/// Energy and timing of a cell; pins as in its [`Gate`].
#[derive(Debug, Clone)]
pub(super) struct CellPower {
    pub(super) energies: Vec<Energy>,
    /// Energies of each output by related input; of a flip-flop by its clock alone.
    outputs: Vec<Vec<Vec<usize>>>,
    /// Energies of inputs that change alone, then of the clock.
    inputs: Vec<Vec<usize>>,
    /// Timing of each output by related input.
    pub(super) timings: Vec<Vec<Vec<Timing>>>,
    /// Input capacitances in the library's unit.
    pub(super) loads: Vec<f64>,
    pub(super) clock_load: f64,
    /// Leakage in the library's unit.
    pub(super) leakage: f64,
    inputs_count: usize,
    outputs_count: usize,
    is_flop: bool,
}

/// Energies to average, with the clock low and high, and whether the pin rises.
pub(super) type Class = ([Vec<usize>; 2], bool);

impl CellPower {
    pub(super) fn read(
        tables: &Tables<'_>,
        cell: &Group,
        gate: &Gate,
    ) -> Result<Self, Unavailable> {
        let clock = gate.flop.as_ref().map(|f| f.clock.as_str());
        let pin = |name: &str| cell.groups("pin").find(|p| p.name() == name);
        let load = |name: &str| -> Result<f64, Unavailable> {
            let pin = pin(name).ok_or_else(|| Unavailable::of(gate, "no pin"))?;
            let text = pin.value("capacitance");
            let number = text
                .and_then(|t| t.parse().ok())
                .filter(|v: &f64| *v >= 0.0);
            number
                .ok_or_else(|| Unavailable::of(gate, &format!("no capacitance of its pin {name}")))
        };
        let mut found = Self {
            energies: vec![],
            outputs: vec![],
            inputs: vec![],
            timings: vec![],
            loads: gate
                .inputs
                .iter()
                .map(|n| load(n))
                .collect::<Result<_, _>>()?,
            clock_load: clock.map_or(Ok(0.0), load)?,
            leakage: leakage(tables, cell, gate)?,
            inputs_count: gate.inputs.len(),
            outputs_count: gate.outputs.len(),
            is_flop: gate.flop.is_some(),
        };
        let causes: Vec<&str> = match clock {
            Some(clock) => vec![clock],
            None => gate.inputs.iter().map(String::as_str).collect(),
        };
        let names: Vec<&str> = gate
            .inputs
            .iter()
            .chain(&gate.outputs)
            .map(String::as_str)
            .chain(clock)
            .collect();
        for name in gate.inputs.iter().map(String::as_str).chain(clock) {
            let own = pin(name).map(|p| found.energies(tables, p, None, &names));
            found.inputs.push(own.transpose()?.unwrap_or_default());
        }
        for name in &gate.outputs {
            let own = pin(name).ok_or_else(|| Unavailable::of(gate, "no pin"))?;
            let (mut energies, mut timings) = (vec![], vec![]);
            for cause in &causes {
                energies.push(found.energies(tables, own, Some(cause), &names)?);
                timings.push(timing(tables, own, cause)?);
            }
            // Cells without inputs tie nets to 0 or 1.
            if !causes.is_empty() && energies.iter().all(Vec::is_empty) {
                let what = format!("no internal_power of its output {name}");
                return Err(Unavailable::of(gate, &what));
            }
            if let Some(i) = timings.iter().position(Vec::is_empty) {
                let what = format!("no delay from {} to {name}", causes[i]);
                return Err(Unavailable::of(gate, &what));
            }
            found.outputs.push(energies);
            found.timings.push(timings);
        }
        found.check(gate)?;
        Ok(found)
    }

    /// Energies of a pin for a related pin or none, all rails together.
    fn energies(
        &mut self,
        tables: &Tables<'_>,
        pin: &Group,
        related: Option<&str>,
        names: &[&str],
    ) -> Result<Vec<usize>, Unavailable> {
        let mut found: Vec<(Option<&str>, usize)> = vec![];
        for group in pin.groups("internal_power") {
            let is_related = match (group.value("related_pin"), related) {
                (Some(pins), Some(related)) => pins.split_whitespace().any(|p| p == related),
                (None, None) => true,
                _ => false,
            };
            if !is_related {
                continue;
            }
            let when = group.value("when");
            let at = match found.iter().find(|(w, _)| *w == when) {
                Some((_, at)) => *at,
                None => {
                    let truth = when.map(|text| Truth::parse(text, names)).transpose();
                    let truth = truth.map_err(|why| tables.wrong(group, "a condition", &why))?;
                    self.energies.push(Energy {
                        when: truth,
                        falls: vec![],
                        rises: vec![],
                    });
                    found.push((when, self.energies.len() - 1));
                    self.energies.len() - 1
                }
            };
            let energy = &mut self.energies[at];
            for table in &group.groups {
                let read = || tables.read(table, "power_lut_template");
                match table.kind.as_str() {
                    "fall_power" => energy.falls.push(read()?),
                    "rise_power" => energy.rises.push(read()?),
                    "power" => {
                        energy.falls.push(read()?);
                        energy.rises.push(read()?);
                    }
                    _ => {}
                }
            }
        }
        Ok(found.into_iter().map(|(_, at)| at).collect())
    }

    /// Refuses a cell that yields energy over a full cycle of transitions: its measurement is
    /// wrong.
    fn check(&self, gate: &Gate) -> Result<(), Unavailable> {
        for (output, name) in self.outputs.iter().zip(&gate.outputs) {
            let all: Vec<usize> = output.iter().flatten().copied().collect();
            let both = |e: &usize| {
                let of = |rises| self.energies[*e].of(rises, 0.0, 0.0);
                of(true) + of(false)
            };
            let sum: f64 = all.iter().map(both).sum();
            if sum < 0.0 {
                let what = format!("negative internal_power of its output {name}, up and down");
                return Err(Unavailable::of(gate, &what));
            }
        }
        Ok(())
    }

    /// Energies that apply in a state; `is_high` is the clock.
    fn pick(&self, all: &[usize], state: usize, is_high: bool) -> Vec<usize> {
        let inputs = state & ((1 << self.inputs_count) - 1);
        let outputs = state >> (self.inputs_count + usize::from(self.is_flop));
        let pins = self.inputs_count + self.outputs_count;
        let bits = inputs | outputs << self.inputs_count | usize::from(is_high) << pins;
        let holds = |e: &&usize| match &self.energies[**e].when {
            Some(when) => when.at(bits & ((1 << (pins + usize::from(self.is_flop))) - 1)),
            None => false,
        };
        let found: Vec<usize> = all.iter().filter(holds).copied().collect();
        if !found.is_empty() {
            return found;
        }
        let always = |e: &&usize| self.energies[**e].when.is_none();
        all.iter().filter(always).copied().collect()
    }

    /// Class of a transition of an input, from a state.
    pub(super) fn input_class(&self, pin: usize, state: usize) -> Class {
        let all = &self.inputs[pin];
        let rises = state >> pin & 1 == 0;
        ([false, true].map(|high| self.pick(all, state, high)), rises)
    }

    /// Class of a transition of the clock.
    pub(super) fn clock_class(&self, state: usize, rises: bool) -> Class {
        let all = self.inputs.last().map_or(&[][..], |own| own);
        // In conditions the other pins are meant.
        ([false, true].map(|high| self.pick(all, state, high)), rises)
    }

    /// Class of a transition of an output caused by an input.
    pub(super) fn output_class(&self, output: usize, pin: usize, state: usize) -> Class {
        let own = &self.outputs[output];
        let first = self.inputs_count + usize::from(self.is_flop);
        let rises = state >> (first + output) & 1 == 0;
        let everything: Vec<usize> = own.iter().flatten().copied().collect();
        let all = own.get(pin).filter(|all| !all.is_empty());
        let all = all.unwrap_or(&everything);
        let mut picked = self.pick(all, state, true);
        if picked.is_empty() {
            picked.clone_from(all);
        }
        ([picked.clone(), picked], rises)
    }

    /// Energy of a class, in the library's unit.
    pub(super) fn energy(&self, class: &Class, transition: f64, load: f64) -> f64 {
        let (halves, rises) = class;
        let mean = |half: &Vec<usize>| {
            let of = |e: &usize| self.energies[*e].of(*rises, transition, load);
            half.iter().map(of).sum::<f64>() / half.len().max(1) as f64
        };
        (mean(&halves[0]) + mean(&halves[1])) / 2.0
    }
}

fn timing(tables: &Tables<'_>, pin: &Group, cause: &str) -> Result<Vec<Timing>, Unavailable> {
    let mut found = vec![];
    for group in pin.groups("timing") {
        let related = group.value("related_pin").unwrap_or_default();
        if !related.split_whitespace().any(|p| p == cause) {
            continue;
        }
        let read = |kind: &'static str| -> Result<Option<Table>, Unavailable> {
            let table = group.groups(kind).next();
            let table = table.map(|t| tables.read(t, "lu_table_template"));
            Ok(table.transpose()?)
        };
        let pair = |fall, rise| -> Result<Option<[Table; 2]>, Unavailable> {
            Ok(match (read(fall)?, read(rise)?) {
                (Some(fall), Some(rise)) => Some([fall, rise]),
                _ => None,
            })
        };
        let delays = pair("cell_fall", "cell_rise")?;
        let transitions = pair("fall_transition", "rise_transition")?;
        if let (Some(delays), Some(transitions)) = (delays, transitions) {
            found.push(Timing {
                delays,
                transitions,
            });
        }
    }
    Ok(found)
}

/// Leakage in no particular state, in the library's unit; a mean over states where only those are
/// given.
fn leakage(tables: &Tables<'_>, cell: &Group, gate: &Gate) -> Result<f64, Unavailable> {
    let number = |group: &Group, name: &str| -> Result<Option<f64>, Unavailable> {
        let Some(text) = group.value(name) else {
            return Ok(None);
        };
        let number = text.parse().ok().filter(|v: &f64| v.is_finite());
        let wrong = || tables.wrong(group, &format!("{name}, a number"), text);
        Ok(Some(number.ok_or_else(wrong)?))
    };
    let (mut always, mut some) = (vec![], vec![]);
    let mut rails = std::collections::BTreeSet::new();
    for group in cell.groups("leakage_power") {
        rails.insert(group.value("related_pg_pin").unwrap_or_default());
        let value = number(group, "value")?;
        let to = match group.value("when") {
            None => &mut always,
            Some(_) => &mut some,
        };
        to.extend(value);
    }
    let own = number(cell, "cell_leakage_power")?;
    // What is given for each rail adds up; what is given for states has a mean.
    let sum = |all: &[f64], of: usize| all.iter().sum::<f64>() / of.max(1) as f64;
    let states = some.len() / rails.len().max(1);
    let found = match (always.is_empty(), own, some.is_empty()) {
        (false, ..) => Some(sum(&always, 1)),
        (true, Some(own), _) => Some(own),
        (true, None, false) => Some(sum(&some, states)),
        (true, None, true) => None,
    };
    found
        .filter(|v| *v >= 0.0)
        .ok_or_else(|| Unavailable::of(gate, "no leakage of 0 or more"))
}
