//! Cells of a library as gates of the simulator.

use std::collections::BTreeMap;

use potamoi_gates::{Flop, Gate, Truth};

use super::liberty::Group;

/// Largest number of input pins and of output pins of a cell.
const MAX_PINS: [usize; 2] = [10, 4];

/// Reads a cell.
///
/// # Errors
/// Why it cannot be simulated: it is neither combinational nor a flip-flop with one rising clock
/// edge, or a function is wrong.
fn read(cell: &Group) -> Result<Gate, String> {
    let pins = |direction: &'static str| {
        let is_so = move |p: &&Group| p.value("direction") == Some(direction);
        cell.groups("pin").filter(is_so)
    };
    if let Some(other) = cell
        .groups
        .iter()
        .find(|g| ["latch", "statetable", "ff_bank", "bus", "bundle"].contains(&&*g.kind))
    {
        return Err(format!("it has a group `{}`", other.kind));
    }
    let mut inputs: Vec<String> = pins("input").map(|p| p.name().to_owned()).collect();
    let mut ffs = cell.groups("ff");
    let (ff, None) = (ffs.next(), ffs.next()) else {
        return Err("it holds more than one bit".to_owned());
    };
    let clock = ff.map(|ff| clock_of(ff, &inputs)).transpose()?;
    inputs.retain(|name| Some(name) != clock.as_ref());
    let held = ff.map(|ff| {
        let name = |i: usize| ff.arguments.get(i).cloned().unwrap_or_default();
        [name(0), name(1)]
    });
    let functions = |text: &str| {
        let mut names: Vec<&str> = inputs.iter().map(String::as_str).collect();
        let Some(held) = &held else {
            return Truth::parse(text, &names);
        };
        names.extend(held.iter().map(String::as_str));
        let truth = Truth::parse(text, &names)?;
        Ok(truth.with_last_as_complement(inputs.len(), names.len()))
    };
    let mut outputs = vec![];
    let mut found = vec![];
    for pin in pins("output") {
        if pin.value("three_state").is_some() {
            return Err(format!("its output {} can float", pin.name()));
        }
        let text = pin.value("function");
        let text = text.ok_or_else(|| format!("its output {} has no function", pin.name()))?;
        outputs.push(pin.name().to_owned());
        found.push(functions(text)?);
    }
    for (count, most, what) in [
        (inputs.len(), MAX_PINS[0], "input"),
        (outputs.len(), MAX_PINS[1], "output"),
    ] {
        if count > most {
            return Err(format!("it has {count} {what} pins, more than {most}"));
        }
    }
    let flop = match (ff, clock, held.clone()) {
        (Some(ff), Some(clock), Some(held)) => Some(Flop {
            clock,
            held,
            next: functions(ff.value("next_state").unwrap_or_default())?,
        }),
        _ => None,
    };
    Ok(Gate {
        name: cell.name().to_owned(),
        inputs,
        outputs,
        functions: found,
        flop,
    })
}

/// Clock pin of a rising-edge flip-flop.
fn clock_of(ff: &Group, inputs: &[String]) -> Result<String, String> {
    for other in ["clear", "preset", "clocked_on_also", "power_down"] {
        if ff.value(other).is_some() {
            return Err(format!("its flip-flop has `{other}`"));
        }
    }
    let clock = ff.value("clocked_on").unwrap_or_default();
    let clock = clock.trim().trim_start_matches('(').trim_end_matches(')');
    if inputs.iter().any(|name| name == clock) {
        Ok(clock.to_owned())
    } else {
        Err(format!(
            "it is clocked on `{clock}`: expected an input pin, for its rising edge"
        ))
    }
}

/// The cells of a library, or why each cannot be simulated.
pub(super) fn gates(library: &Group) -> BTreeMap<String, Result<Gate, String>> {
    let cells = library.groups("cell");
    cells
        .map(|cell| (cell.name().to_owned(), read(cell)))
        .collect()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::liberty::parse;

    const CELLS: &str = "library (l) {\n\
        cell (NAND) { pin (A) { direction : input; } pin (B) { direction : input; } \
        pin (Y) { direction : output; function : \"!(A B)\"; } }\n\
        cell (FLOP) { ff (IQ, IQN) { next_state : \"!D\"; clocked_on : \"(CK)\"; } \
        pin (CK) { direction : input; } pin (D) { direction : input; } \
        pin (QN) { direction : output; function : \"IQN\"; } }\n\
        cell (CLEARED) { ff (IQ, IQN) { next_state : \"D\"; clocked_on : \"CK\"; clear : \"R\"; } \
        pin (CK) { direction : input; } pin (D) { direction : input; } \
        pin (R) { direction : input; } }\n\
        cell (FALLS) { ff (IQ, IQN) { next_state : \"D\"; clocked_on : \"!CK\"; } \
        pin (CK) { direction : input; } pin (D) { direction : input; } }\n\
        cell (LATCH) { latch (IQ, IQN) { enable : \"G\"; } }\n\
        cell (FLOATS) { pin (Y) { direction : output; function : \"A\"; three_state : \"!E\"; } }\n\
        cell (NOTHING) { pin (Y) { direction : output; } }\n\
        cell (WRONG) { pin (A) { direction : input; } pin (Y) { direction : output; function : \"A &\"; } }\n}\n";

    #[test]
    fn logic_and_flip_flops_are_read_and_the_rest_is_refused() {
        let gates = gates(&parse(CELLS, "t.lib").unwrap());
        let nand = gates["NAND"].as_ref().unwrap();
        assert_eq!((nand.variables(), nand.bits()), (2, 3));
        assert_eq!([0, 1, 2, 3].map(|i| nand.outputs_of(i)), [4, 4, 4, 0]);
        let flop = gates["FLOP"].as_ref().unwrap();
        assert_eq!(flop.inputs, ["D"]);
        // D lowest, then what is held.
        assert_eq!([0, 1, 2, 3].map(|i| flop.outputs_of(i)), [4, 4, 0, 0]);
        let next = &flop.flop.as_ref().unwrap().next;
        assert_eq!([0, 1, 2, 3].map(|i| next.at(i)), [true, false, true, false]);
        for (cell, why) in [
            ("CLEARED", "`clear`"),
            ("FALLS", "rising edge"),
            ("LATCH", "`latch`"),
            ("FLOATS", "can float"),
            ("NOTHING", "no function"),
            ("WRONG", "a pin"),
        ] {
            let found = gates[cell].as_ref().unwrap_err();
            assert!(found.contains(why), "{cell}: {found}");
        }
    }
}
