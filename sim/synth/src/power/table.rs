//! Look-up tables of a library: values by input transition and output load.

use std::collections::BTreeMap;

use crate::SynthError;
use crate::liberty::Group;

/// Largest number of values in a table.
const MOST: usize = 1 << 12;

/// Values by transition, then by load, in the library's units. A missing axis has the single point
/// 0.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Table {
    transitions: Vec<f64>,
    loads: Vec<f64>,
    values: Vec<f64>,
}

impl Table {
    /// Bilinear interpolation. Outside the table the value is that of its edge or, if
    /// `is_extended`, extrapolated from the last two points.
    pub(super) fn at(&self, transition: f64, load: f64, is_extended: bool) -> f64 {
        let (t, along) = place(&self.transitions, transition, is_extended);
        let (l, across) = place(&self.loads, load, is_extended);
        let value = |t: usize, l: usize| {
            let t = t.min(self.transitions.len() - 1);
            self.values[t * self.loads.len() + l.min(self.loads.len() - 1)]
        };
        let of = |t: usize| value(t, l) + across * (value(t, l + 1) - value(t, l));
        of(t) + along * (of(t + 1) - of(t))
    }

    /// Smallest transition.
    pub(super) fn first_transition(&self) -> f64 {
        self.transitions[0]
    }
}

/// Index of the point below, and the fraction to the next.
fn place(points: &[f64], at: f64, is_extended: bool) -> (usize, f64) {
    let Some(last) = points.len().checked_sub(2) else {
        return (0, 0.0);
    };
    let below = points.iter().take(last + 1).rposition(|p| *p <= at);
    let below = below.unwrap_or(0);
    let part = (at - points[below]) / (points[below + 1] - points[below]);
    let part = if is_extended {
        part
    } else {
        part.clamp(0.0, 1.0)
    };
    (below, part)
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Axis {
    Transition,
    Load,
}

#[derive(Debug)]
struct Template<'a> {
    axes: Vec<Axis>,
    group: &'a Group,
}

/// Templates of a library, with which its tables are read.
pub(super) struct Tables<'a> {
    origin: &'a str,
    templates: BTreeMap<(&'a str, &'a str), Option<Template<'a>>>,
}

impl<'a> Tables<'a> {
    /// `origin` names the file in errors.
    pub(super) fn of(library: &'a Group, origin: &'a str) -> Self {
        let kinds = ["lu_table_template", "power_lut_template"];
        let groups = library.groups.iter().filter(|g| kinds.contains(&&*g.kind));
        let template = |group: &'a Group| {
            let variables = (1..=3).map(|i| group.value(&format!("variable_{i}")));
            let axis = |name: &str| match name {
                "input_net_transition" | "input_transition_time" => Some(Axis::Transition),
                "total_output_net_capacitance" => Some(Axis::Load),
                _ => None,
            };
            let axes = variables.flatten().map(axis).collect::<Option<Vec<_>>>()?;
            let is_of_two = axes.len() == 2 && axes[0] != axes[1];
            (axes.len() == 1 || is_of_two).then_some(Template { axes, group })
        };
        Self {
            origin,
            templates: groups
                .map(|g| ((&*g.kind, g.name()), template(g)))
                .collect(),
        }
    }

    pub(super) fn wrong(&self, group: &Group, expected: &str, found: &str) -> SynthError {
        group.wrong(self.origin, expected, found)
    }

    /// Reads a table with a template of this kind.
    pub(super) fn read(&self, group: &Group, kind: &str) -> Result<Table, SynthError> {
        let scalar = Template {
            axes: vec![],
            group,
        };
        let name = group.name();
        let template = match self.templates.get(&(kind, name)) {
            Some(Some(template)) => template,
            None if name == "scalar" || name.is_empty() => &scalar,
            _ => {
                let expected = "a template over input transition and output load";
                return Err(self.wrong(group, expected, name));
            }
        };
        let [mut transitions, mut loads] = [vec![0.0], vec![0.0]];
        for (i, axis) in template.axes.iter().enumerate() {
            let index = format!("index_{}", i + 1);
            let own = group
                .numbers(&index)
                .map_err(|w| self.wrong(group, &index, &w))?;
            let points = match own.is_empty() {
                false => own,
                true => template
                    .group
                    .numbers(&index)
                    .map_err(|w| self.wrong(template.group, &index, &w))?,
            };
            if points.is_empty() || points.windows(2).any(|p| p[0] >= p[1]) {
                let expected = format!("{index}, numbers that increase");
                return Err(self.wrong(group, &expected, &format!("{} points", points.len())));
            }
            match axis {
                Axis::Transition => transitions = points,
                Axis::Load => loads = points,
            }
        }
        let mut values = group
            .numbers("values")
            .map_err(|w| self.wrong(group, "values", &w))?;
        let count = transitions.len() * loads.len();
        if values.len() != count || count > MOST {
            let expected = format!("{count} values, and at most {MOST}");
            return Err(self.wrong(group, &expected, &values.len().to_string()));
        }
        if template.axes.first() == Some(&Axis::Load) {
            let at = |i: usize| values[i % loads.len() * transitions.len() + i / loads.len()];
            values = (0..count).map(at).collect();
        }
        Ok(Table {
            transitions,
            loads,
            values,
        })
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::liberty::parse;

    const LIBRARY: &str = "library (l) {\n\
        power_lut_template (by_both) { variable_1 : input_transition_time; \
        variable_2 : total_output_net_capacitance; index_1 (\"10, 20\"); index_2 (\"1, 3, 5\"); }\n\
        power_lut_template (by_load_first) { variable_1 : total_output_net_capacitance; \
        variable_2 : input_transition_time; index_1 (\"1, 3, 5\"); index_2 (\"10, 20\"); }\n\
        power_lut_template (by_one) { variable_1 : input_transition_time; index_1 (\"10, 20\"); }\n\
        power_lut_template (odd) { variable_1 : related_pin_transition; index_1 (\"10, 20\"); }\n\
        t (by_both) { values (\"1, 2, 4\", \\\n \"3, 6, 12\"); }\n\
        t (by_load_first) { values (\"1, 3\", \"2, 6\", \"4, 12\"); }\n\
        t (by_one) { index_1 (\"0, 100\"); values (\"7, 9\"); }\n\
        t (scalar) { values (\"5\"); }\n}\n";

    fn tables(text: &str) -> Vec<Result<Table, SynthError>> {
        let library = parse(text, "t.lib").unwrap();
        let tables = Tables::of(&library, "t.lib");
        library
            .groups("t")
            .map(|t| tables.read(t, "power_lut_template"))
            .collect()
    }

    #[test]
    fn values_lie_between_the_points() {
        let tables: Vec<_> = tables(LIBRARY).into_iter().map(Result::unwrap).collect();
        let [both, turned, one, scalar] = &tables[..] else {
            unreachable!("four tables")
        };
        assert_eq!(both, turned);
        // By hand: at a load of 2, 1.5 and 4.5; half way, 3.
        for (transition, load, expected, extended) in [
            (10.0, 1.0, 1.0, 1.0),
            (15.0, 2.0, 3.0, 3.0),
            (20.0, 5.0, 12.0, 12.0),
            (10.0, 4.0, 3.0, 3.0),
            // Past the ends: 4 + 2 x 1, and 12 + 1 x (12 - 4).
            (10.0, 7.0, 4.0, 6.0),
            (30.0, 5.0, 12.0, 20.0),
            (10.0, 0.0, 1.0, 0.5),
        ] {
            let found = [false, true].map(|is| both.at(transition, load, is));
            assert!((found[0] - expected).abs() < 1e-12, "{found:?}");
            assert!((found[1] - extended).abs() < 1e-12, "{found:?}");
        }
        assert!((one.at(25.0, 99.0, true) - 7.5).abs() < 1e-12);
        assert!((scalar.at(3.0, 4.0, true) - 5.0).abs() < 1e-12);
    }

    #[test]
    fn wrong_tables_are_named_with_their_line() {
        for (from, to, expected) in [
            ("\"1, 2, 4\"", "\"1, 2\"", "line 6: expected 6 values"),
            ("\"1, 2, 4\"", "\"1, 2, x\"", "line 6: expected values"),
            (
                "\"10, 20\"); index_2 (\"1, 3, 5\")",
                "\"20, 10\"); index_2 (\"1, 3, 5\")",
                "increase",
            ),
            ("t (by_one)", "t (odd)", "a template over"),
            ("t (by_one)", "t (gone)", "found `gone`"),
        ] {
            let text = LIBRARY.replacen(from, to, 1);
            assert_ne!(text, LIBRARY);
            let error = tables(&text).into_iter().find_map(Result::err).unwrap();
            let said = error.to_string();
            assert!(
                said.starts_with("t.lib, ") && said.contains(expected),
                "{said}"
            );
        }
    }
}
