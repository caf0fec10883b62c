//! Tables of a library: that each is whole, whoever reads it later.

use std::collections::BTreeMap;

use super::SynthError;
use super::liberty::Group;

/// Axes of a table.
const AXES: [&str; 3] = ["index_1", "index_2", "index_3"];

/// Templates by kind and name.
type Templates<'a> = BTreeMap<(&'a str, &'a str), &'a Group>;

/// Checks the tables of a library's cells and their templates; `path` names the file in
/// errors.
pub(super) fn check(library: &Group, path: &str) -> Result<(), SynthError> {
    let mut known = Templates::new();
    let groups = library.groups.iter();
    for template in groups.filter(|g| g.kind.ends_with("_template")) {
        numbers(template, path)?;
        known.insert((&template.kind, template.name()), template);
    }
    let mut cells = library.groups("cell");
    cells.try_for_each(|cell| inside(cell, &known, path))
}

fn inside(group: &Group, templates: &Templates<'_>, path: &str) -> Result<(), SynthError> {
    numbers(group, path)?;
    if let Some(kind) = template_of(&group.kind) {
        let count = group.numbers("values").unwrap_or_default().len();
        let expected = points(group, kind, templates, path)?;
        if count != expected {
            return Err(group.wrong(path, &format!("{expected} values"), &count.to_string()));
        }
    }
    let mut inner = group.groups.iter();
    inner.try_for_each(|inner| inside(inner, templates, path))
}

/// The kind of template of a table of delays, transitions, constraints or energies.
fn template_of(kind: &str) -> Option<&'static str> {
    match kind {
        "cell_rise" | "cell_fall" | "rise_transition" | "fall_transition" | "rise_constraint"
        | "fall_constraint" => Some("lu_table_template"),
        "rise_power" | "fall_power" | "power" => Some("power_lut_template"),
        _ => None,
    }
}

/// How many values a table has to have.
fn points(
    table: &Group,
    kind: &str,
    templates: &Templates<'_>,
    path: &str,
) -> Result<usize, SynthError> {
    let name = table.name();
    let Some(template) = templates.get(&(kind, name)) else {
        return match name {
            "" | "scalar" => Ok(1),
            _ => Err(table.wrong(path, &format!("a {kind} of the library"), name)),
        };
    };
    let mut count = 1;
    for (axis, index) in AXES.into_iter().enumerate() {
        if template.value(&format!("variable_{}", axis + 1)).is_none() {
            break;
        }
        let of = |group: &Group| group.numbers(index).map_or(0, |n| n.len());
        count *= match of(table) {
            0 => of(template),
            own => own,
        };
    }
    Ok(count)
}

/// That values are numbers, and axes numbers that increase.
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
    use crate::synth::liberty::parse;

    const HANDFUL: &str = include_str!("../../cells/handful.lib");

    fn checked(text: &str) -> Result<(), SynthError> {
        check(&parse(text, "t.lib").unwrap(), "t.lib")
    }

    #[test]
    fn a_table_that_is_damaged_is_named_with_its_line() {
        checked(HANDFUL).unwrap();
        for (kind, from, to, expected) in [
            (
                "cell_rise (",
                "\"",
                "\"1e9x, ",
                "values, numbers in the cell_rise `by_slew_and_load`, found `1e9x`",
            ),
            (
                "rise_transition (",
                "\"",
                "\"inf, ",
                "values, numbers in the rise_transition `by_slew_and_load`, found `inf`",
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
                "library (l) {{ lu_table_template (t) {{ variable_1 : input_net_transition;\n\
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
}
