//! Checks attributes of cells: functions and conditions are readable and name pins of their cell,
//! as related pins do, and numbers are numbers. A later program might silently skip a cell that
//! fails here.

use potamoi_base::file_keys::{told, told_within};
use potamoi_gates::Truth;

use super::SynthError;
use super::liberty::{Attribute, Group};
use super::physical_units::Units;

/// Groups whose names functions may use beside pins: stored bits of a cell.
const HOLDS: [&str; 4] = ["ff", "latch", "ff_bank", "latch_bank"];
const PINS: [&str; 4] = ["pin", "bus", "bundle", "pg_pin"];

/// Checks the cells of a library; `path` names the file in errors.
pub(super) fn check(library: &Group, units: &Units, path: &str) -> Result<(), SynthError> {
    let mut cells = library.groups("cell");
    cells.try_for_each(|cell| {
        let mut names = Names::default();
        names.add(cell);
        let checker = Checker { units, path };
        checker.group(&[cell], &names)
    })
}

/// Names that functions of a cell may use.
#[derive(Debug, Clone, Default)]
struct Names {
    pins: Vec<String>,
    /// Stored bits of the cell, and nodes of its state table.
    held: Vec<String>,
    /// Whether names may have an index or a range.
    are_indexed: bool,
}

impl Names {
    fn add(&mut self, group: &Group) {
        for inner in &group.groups {
            let words = |at: usize| inner.arguments.get(at).into_iter();
            match &*inner.kind {
                "statetable" => {
                    let nodes = words(1).flat_map(|text| text.split_whitespace());
                    self.held.extend(nodes.map(str::to_owned));
                }
                kind if HOLDS.contains(&kind) => {
                    self.held.extend(words(0).chain(words(1)).cloned());
                }
                kind if PINS.contains(&kind) => {
                    self.are_indexed |= ["bus", "bundle"].contains(&kind);
                    self.pins.extend(inner.arguments.iter().cloned());
                    let members = inner.values.iter().filter(|own| own.name == "members");
                    self.pins.extend(members.flat_map(|own| own.values.clone()));
                    self.add(inner);
                }
                _ => {}
            }
        }
    }

    /// Text without indices and ranges.
    fn plain(&self, text: &str) -> String {
        if !self.are_indexed {
            return text.to_owned();
        }
        let mut depth = 0u32;
        let is_outside = |c: &char| {
            match c {
                '[' | '<' => depth += 1,
                ']' | '>' => {
                    depth = depth.saturating_sub(1);
                    return false;
                }
                _ => {}
            }
            depth == 0
        };
        text.chars().filter(is_outside).collect()
    }

    fn has_pin(&self, name: &str) -> bool {
        self.pins.iter().any(|pin| self.plain(pin) == name)
    }

    /// The reason why a text is no function of these names.
    fn wrong(&self, text: &str) -> Option<String> {
        let all: Vec<String> = self
            .pins
            .iter()
            .chain(&self.held)
            .map(|name| self.plain(name))
            .collect();
        let all: Vec<&str> = all.iter().map(String::as_str).collect();
        Truth::check(&self.plain(text), &all).err()
    }
}

struct Checker<'a> {
    units: &'a Units,
    path: &'a str,
}

impl Checker<'_> {
    /// Checks the innermost of the nested groups, and all in it.
    fn group(&self, groups: &[&Group], names: &Names) -> Result<(), SynthError> {
        let Some(own) = groups.last() else {
            return Ok(());
        };
        for attribute in &own.values {
            self.attribute(groups, attribute, names)?;
        }
        for needed in needed(&own.kind) {
            if own.value(needed).is_none() {
                let expected = format!("{needed}, a function of the cell's pins");
                return Err(self.wrong(groups, own.line, &expected, "none"));
            }
        }
        for inner in &own.groups {
            let mut inside = groups.to_vec();
            inside.push(inner);
            if inner.kind == "test_cell" {
                let mut names = names.clone();
                names.add(inner);
                self.group(&inside, &names)?;
            } else {
                self.group(&inside, names)?;
            }
        }
        Ok(())
    }

    fn attribute(
        &self,
        groups: &[&Group],
        attribute: &Attribute,
        names: &Names,
    ) -> Result<(), SynthError> {
        let kind = groups.last().map_or("", |group| &*group.kind);
        let Attribute { name, values, line } = attribute;
        let text = values.first().map_or("", String::as_str);
        let wrong = |expected: &str, found: &str| {
            let expected = format!("{name}, {expected}");
            Err(self.wrong(groups, *line, &expected, found))
        };
        if is_function(kind, name) {
            return match names.wrong(text) {
                None => Ok(()),
                Some(why) => {
                    let why = format!("a function of the cell's pins ({})", told_within(&why, 300));
                    wrong(&why, text)
                }
            };
        }
        if name == "related_pin" {
            let plain = names.plain(text);
            let mut pins = plain
                .split([' ', '\t', '\n', ','])
                .filter(|p| !p.is_empty());
            return match pins.find(|pin| !names.has_pin(pin)) {
                None => Ok(()),
                Some(_) => wrong("pins of the cell", text),
            };
        }
        // Of other groups `value` is something else.
        let is_number = name != "value" || kind == "leakage_power";
        if let Some(bounds) = self.units.bounds(name, None).filter(|_| is_number) {
            let number = text.trim().parse().ok().filter(|v: &f64| v.is_finite());
            if !number.is_some_and(|v| bounds.has(v)) {
                return wrong(&format!("a number {}", bounds.words), text);
            }
        }
        Ok(())
    }

    fn wrong(&self, groups: &[&Group], line: usize, expected: &str, found: &str) -> SynthError {
        let place = groups.iter().rev().map(|group| match group.name() {
            "" => told(&group.kind),
            name => format!("{} `{}`", told(&group.kind), told(name)),
        });
        let place = place.collect::<Vec<_>>().join(" of the ");
        SynthError::Liberty {
            path: self.path.to_owned(),
            line,
            expected: format!("{expected} in the {place}"),
            found: format!("`{}`", told(found)),
        }
    }
}

/// Required attributes of a kind of group.
fn needed(kind: &str) -> &'static [&'static str] {
    match kind {
        "ff" | "ff_bank" => &["next_state", "clocked_on"],
        _ => &[],
    }
}

/// Whether an attribute of a group is a function of the cell's pins.
fn is_function(kind: &str, name: &str) -> bool {
    match kind {
        "pin" | "bus" | "bundle" => {
            ["function", "three_state", "x_function", "state_function"].contains(&name)
        }
        "ff" | "ff_bank" | "latch" | "latch_bank" => [
            "next_state",
            "clocked_on",
            "clocked_on_also",
            "enable",
            "enable_also",
            "data_in",
            "clear",
            "preset",
        ]
        .contains(&name),
        _ => name == "when",
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::liberty::parse;

    /// One of each kind of group and attribute.
    const CELLS: &str = "library (l) { time_unit : \"1ps\"; capacitive_load_unit (1, ff);\n\
        leakage_power_unit : \"1nW\";\n\
        cell (NOR) { area : 1; cell_leakage_power : 0.5;\n\
        leakage_power () { value : 12.5; when : \"A !B\"; }\n\
        pg_pin (VDD) { }\n\
        pin (A) { direction : input; capacitance : 1.5; }\n\
        pin (B) { direction : input; rise_capacitance : 1; internal_power () { when : \"!A\"; } }\n\
        pin (Y) { direction : output; max_capacitance : 1e30; three_state : \"!B\";\n\
        function : \"!(A + B)\";\n\
        timing () { related_pin : \"A, B\"; when : \"A & !B\"; } } }\n\
        cell (FLOP) { area : 1; pin (D, CK) { direction : input; }\n\
        ff (\"IQ\", \"IQN\") {\n\
        next_state : \"D\";\n\
        clocked_on : \"!CK\"; clear : \"!D IQ\"; }\n\
        pin (Q) { direction : output; function : \"IQ\"; }\n\
        test_cell () { pin (D) { direction : input; } ff (TQ, TQN) { next_state : \"D\";\n\
        clocked_on : \"CK\"; }\n\
        pin (Q) { function : \"TQ\"; } } }\n\
        cell (GATE) { latch (IQ, IQN) { enable : \"G\"; data_in : \"D\"; }\n\
        pin (G) { } pin (D) { } pin (Q) { function : \"IQ\"; } }\n\
        cell (CLOCKED) { statetable (\"G E\", \"M N\") { } pin (G) { } pin (E) { }\n\
        pin (M) { direction : internal; } pin (Y) { state_function : \"G M N\"; } }\n\
        cell (WIDE) { bus (A) { pin (A[1:0]) { } } bus (Y) { function : \"!A[1:0]\";\n\
        timing () { related_pin : \"A[1] A<0>\"; } } bundle (P) { members (P0, P1); }\n\
        pin (Z) { function : \"A[0] P0\"; } }\n}\n";

    fn checked(text: &str) -> Result<(), SynthError> {
        let library = parse(text, "t.lib").unwrap();
        check(&library, &Units::read(&library, "t.lib")?, "t.lib")
    }

    #[test]
    fn all_that_a_cell_can_say_is_read() {
        checked(CELLS).unwrap();
    }

    /// Errors name file, line, group and cell, attribute, expected and found values.
    #[test]
    fn what_is_wrong_is_named_with_its_place() {
        for (from, to, line, expected) in [
            (
                "\"!(A + B)\"",
                "\"(A ! & )\"",
                9,
                "function, a function of the cell's pins (expected a pin in a function, found `&`) \
                 in the pin `Y` of the cell `NOR`, found `(A ! & )`",
            ),
            (
                "\"!(A + B)\"",
                "\"ZZZ\"",
                9,
                "(expected one of VDD, A, B, Y, 0, 1, found `ZZZ`) in the pin `Y` of the cell `NOR`",
            ),
            ("\"!(A + B)\"", "\"IQ\"", 9, "found `IQ`"),
            (
                "\"A, B\"",
                "\"A QQ\"",
                10,
                "related_pin, pins of the cell in the timing of the pin `Y` of the cell `NOR`, found `A QQ`",
            ),
            ("\"A & !B\"", "\"A &\"", 10, "when, a function"),
            (
                "\"A !B\"",
                "\"A !C\"",
                4,
                "in the leakage_power of the cell `NOR`",
            ),
            ("\"!A\"", "\"\"", 7, "in the internal_power of the pin `B`"),
            (
                "three_state : \"!B\"",
                "three_state : \"!\"",
                8,
                "three_state, ",
            ),
            (
                "\"!CK\"",
                "\"ZZ\"",
                14,
                "clocked_on, a function of the cell's pins (expected one of D, CK, Q, IQ, IQN, 0, 1, \
                 found `ZZ`) in the ff `IQ` of the cell `FLOP`, found `ZZ`",
            ),
            (
                "next_state : \"D\";\n\
              clocked_on : \"!CK",
                "next_state : \"!\";\nclocked_on : \"!CK",
                13,
                "found `!`",
            ),
            ("\"!D IQ\"", "\"!R\"", 14, "clear, a function"),
            (
                "clocked_on : \"!CK\";",
                "",
                12,
                "clocked_on, a function of the cell's pins in the ff `IQ`",
            ),
            (
                "\"TQ\"",
                "\"UQ\"",
                18,
                "in the pin `Q` of the test_cell of the cell `FLOP`",
            ),
            ("enable : \"G\"", "enable : \"H\"", 19, "enable, a function"),
            (
                "data_in : \"D\"",
                "data_in : \"D D2\"",
                19,
                "data_in, a function",
            ),
            ("\"G M N\"", "\"G M O\"", 22, "state_function, a function"),
            (
                "\"!A[1:0]\"",
                "\"!B[1:0]\"",
                23,
                "in the bus `Y` of the cell `WIDE`",
            ),
            ("A<0>", "C<0>", 24, "related_pin, pins of the cell"),
            (
                "12.5",
                "12x",
                4,
                "value, a number of at most 1 W in the leakage_power",
            ),
            ("12.5", "1e10", 4, "value, a number of at most 1 W"),
            (": 0.5", ": nan", 3, "cell_leakage_power, a number"),
            (
                "1.5",
                "1e30",
                6,
                "capacitance, a number of 0 to 1 nF in the pin `A`",
            ),
            ("1.5", "-1", 6, "capacitance, a number of 0 to 1 nF"),
            (
                "rise_capacitance : 1",
                "rise_capacitance : l",
                7,
                "rise_capacitance, ",
            ),
            ("1e30", "1e3O", 8, "max_capacitance, a number of 0 or more"),
            (
                "area : 1",
                "area : 1e9",
                3,
                "area, a number of 0 to 1e8 um^2",
            ),
        ] {
            let text = CELLS.replacen(from, to, 1);
            assert_ne!(text, CELLS, "{from}");
            let said = checked(&text).unwrap_err().to_string();
            let place = format!("t.lib, line {line}: expected ");
            assert!(
                said.starts_with(&place) && said.contains(expected),
                "{from} to {to}: {said}"
            );
        }
    }
}
