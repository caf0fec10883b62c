//! Checks that look-up tables of a library are complete, for all later readers.

use potamoi_base::file_keys::told;
use std::collections::BTreeMap;

use super::SynthError;
use super::liberty::Group;
use super::physical_units::Units;

/// Axes of a table.
const AXES: [&str; 3] = ["index_1", "index_2", "index_3"];
/// Names of an axis of input transitions.
const TRANSITIONS: [&str; 2] = ["input_net_transition", "input_transition_time"];

/// Templates by kind and name.
type Templates<'a> = BTreeMap<(&'a str, &'a str), &'a Group>;

/// Checks the tables of a library's cells and their templates; `path` names the file in errors.
pub(super) fn check(library: &Group, units: &Units, path: &str) -> Result<(), SynthError> {
    let mut templates = Templates::new();
    let groups = library.groups.iter();
    for template in groups.filter(|g| g.kind.ends_with("_template")) {
        numbers(template, path)?;
        templates.insert((&template.kind, template.name()), template);
    }
    let checker = Checker {
        templates,
        units,
        path,
    };
    let mut cells = library.groups("cell");
    cells.try_for_each(|cell| checker.inside(cell).map_err(|error| of_cell(error, cell)))
}

/// Adds the cell's name to an error in one of its groups.
fn of_cell(mut error: SynthError, cell: &Group) -> SynthError {
    if let SynthError::Liberty { expected, .. } = &mut error {
        *expected += &format!(" of the cell `{}`", told(cell.name()));
    }
    error
}

struct Checker<'a> {
    templates: Templates<'a>,
    units: &'a Units,
    path: &'a str,
}

impl Checker<'_> {
    fn inside(&self, group: &Group) -> Result<(), SynthError> {
        numbers(group, self.path)?;
        if let Some(kind) = template_of(&group.kind) {
            self.table(group, kind)?;
        }
        let mut inner = group.groups.iter();
        inner.try_for_each(|inner| self.inside(inner))
    }

    /// Checks that a table has as many values as its axes have points, all within bounds.
    fn table(&self, table: &Group, kind: &str) -> Result<(), SynthError> {
        let axes = self.axes(table, kind)?;
        let expected: usize = axes.iter().map(|(_, points)| points.len()).product();
        let values = table.numbers("values").unwrap_or_default();
        if values.len() != expected {
            let found = values.len().to_string();
            return Err(table.wrong(self.path, &format!("{expected} values"), &found));
        }
        let inputs = axes
            .iter()
            .filter(|(name, _)| TRANSITIONS.contains(&&**name));
        let slowest = inputs.filter_map(|(_, points)| points.last().copied());
        let slowest = slowest.reduce(f64::max);
        let Some(bounds) = self.units.bounds(&table.kind, slowest) else {
            return Ok(());
        };
        match values.into_iter().find(|value| !bounds.has(*value)) {
            None => Ok(()),
            Some(value) => {
                let expected = format!("values, numbers {}", bounds.words);
                Err(table.wrong(self.path, &expected, &value.to_string()))
            }
        }
    }

    /// Axes of a table with their points.
    fn axes(&self, table: &Group, kind: &str) -> Result<Vec<(String, Vec<f64>)>, SynthError> {
        let name = table.name();
        let Some(template) = self.templates.get(&(kind, name)) else {
            return match name {
                "" | "scalar" => Ok(vec![]),
                _ => Err(table.wrong(self.path, &format!("a {kind} of the library"), name)),
            };
        };
        let mut axes = vec![];
        for (axis, index) in AXES.into_iter().enumerate() {
            let Some(variable) = template.value(&format!("variable_{}", axis + 1)) else {
                break;
            };
            let of = |group: &Group| group.numbers(index).unwrap_or_default();
            let own = of(table);
            let points = if own.is_empty() { of(template) } else { own };
            axes.push((variable.to_owned(), points));
        }
        Ok(axes)
    }
}

/// Kind of template for a table of delays, transitions, constraints or energies.
fn template_of(kind: &str) -> Option<&'static str> {
    match kind {
        "cell_rise" | "cell_fall" | "rise_transition" | "fall_transition" | "rise_constraint"
        | "fall_constraint" => Some("lu_table_template"),
        "rise_power" | "fall_power" | "power" => Some("power_lut_template"),
        _ => None,
    }
}

/// Checks that values are numbers, and that axes increase.
fn numbers(group: &Group, path: &str) -> Result<(), SynthError> {
    let read = |name: &str| {
        let wrong = |found: String| group.wrong(path, &format!("{name}, numbers"), &found);
        group.numbers(name).map_err(wrong)
    };
    read("values")?;
    for index in AXES {
        let points = read(index)?;
        if let Some(pair) = points.windows(2).find(|p| p[0] >= p[1]) {
            let expected = format!("{index}, numbers that increase");
            return Err(group.wrong(path, &expected, &format!("{}, {}", pair[0], pair[1])));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::liberty::parse;

    const HANDFUL: &str = include_str!("../cells/handful.lib");

    fn checked(text: &str) -> Result<(), SynthError> {
        let library = parse(text, "t.lib").unwrap();
        check(&library, &Units::read(&library, "t.lib")?, "t.lib")
    }

    #[test]
    fn a_table_that_is_damaged_is_named_with_its_line() {
        checked(HANDFUL).unwrap();
        for (kind, from, to, expected) in [
            (
                "cell_rise (",
                "\"",
                "\"1e9x, ",
                "values, numbers in the cell_rise `by_slew_and_load` of the cell `INV`, found `1e9x`",
            ),
            (
                "rise_transition (",
                "\"",
                "\"inf, ",
                "values, numbers in the rise_transition `by_slew_and_load` of the cell `INV`, found `inf`",
            ),
            ("fall_power (", "\"", "\"1, ", "values in the fall_power"),
            (
                "rise_constraint (",
                "(",
                "(un",
                "a lu_table_template of the library in the rise_constraint `unof_edges`",
            ),
            (
                "power_lut_template (",
                "\"10, ",
                "\"10, 10, ",
                "index_1, numbers that increase in the power_lut_template `by_slew_and_load`, found `10, 10`",
            ),
            (
                "lu_table_template (",
                "\"10, ",
                "\"1O, ",
                "index_1, numbers in the lu_table_template `by_slew_and_load`, found `1O`",
            ),
        ] {
            let at = HANDFUL.find(kind).unwrap();
            let (before, after) = HANDFUL.split_at(at);
            let text = before.to_owned() + &after.replacen(from, to, 1);
            let said = checked(&text).unwrap_err().to_string();
            let line = before.matches('\n').count() + 1;
            let place = format!("t.lib, line {line}: expected ");
            assert!(
                said.starts_with(&place) && said.contains(expected),
                "{said}"
            );
        }
    }

    #[test]
    fn axes_of_a_table_come_before_those_of_its_template() {
        let table = |own: &str| {
            format!(
                "library (l) {{ capacitive_load_unit (1, ff);\
                 lu_table_template (t) {{ variable_1 : input_net_transition;\n\
                 index_1 (\"1, 2\"); }}\n cell (c) {{ pin (Y) {{ timing () {{\n\
                 cell_rise (t) {{ {own} }} }} }} }} }}"
            )
        };
        checked(&table("values (\"5, 6\");")).unwrap();
        checked(&table("index_1 (\"1, 2, 3\"); values (\"5, 6, 7\");")).unwrap();
        let said = checked(&table("index_1 (\"1, 2, 3\"); values (\"5, 6\");"));
        let said = said.unwrap_err().to_string();
        assert!(
            said.contains("line 4: expected 3 values") && said.contains("found `2`"),
            "{said}"
        );
    }

    /// Refuses values in picoseconds and femtojoules beyond any cell, and accepts possible ones.
    #[test]
    fn values_beyond_all_cells_are_refused() {
        let read = |unit: &str, table: &str, values: &str| {
            checked(&format!(
                "library (l) {{ time_unit : \"1{unit}\"; capacitive_load_unit (1, ff);\n\
                 lu_table_template (t) {{ variable_1 : total_output_net_capacitance;\n\
                 variable_2 : input_net_transition; index_1 (\"1, 2\"); index_2 (\"1, 300\"); }}\n\
                 cell (c) {{ pin (Y) {{ timing () {{\n{table} {{ values (\"{values}\"); }} }} }} }} }}"
            ))
        };
        for (unit, table, values, expected) in [
            ("ps", "cell_rise (t)", "5, 5, -500, 5", "-500"),
            ("ps", "cell_rise (t)", "5, 5, 5, 1000000000", "1000000000"),
            ("ns", "cell_fall (scalar)", "-500", "-500"),
            ("ns", "cell_fall (scalar)", "1e9", "1000000000"),
            ("ps", "fall_transition (t)", "5, -1, 5, 5", "-1"),
            ("ps", "rise_transition (scalar)", "1e9", "1000000000"),
            ("ps", "rise_constraint (scalar)", "-1e9", "-1000000000"),
            (
                "ps",
                "rise_power (scalar)",
                "1e30",
                "1000000000000000000000000000000",
            ),
        ] {
            let said = read(unit, table, values).unwrap_err().to_string();
            assert!(
                said.starts_with("t.lib, line 5: expected values, numbers of ")
                    && said.ends_with(&format!("found `{expected}`")),
                "{table}: {said}"
            );
        }
        for (unit, table, values) in [
            ("ps", "cell_rise (t)", "5, 5, -300, 99999999"),
            ("ns", "cell_fall (scalar)", "-0.9"),
            ("ns", "cell_fall (t)", "-0.9, 1, 2, 99999"),
            ("ps", "fall_constraint (scalar)", "-321.5"),
            ("ps", "fall_power (scalar)", "-0.4"),
        ] {
            read(unit, table, values).unwrap();
        }
    }
}
