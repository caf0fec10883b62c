//! Varied fields of the machines on a front: columns for those that differ, a line for the others.

use comfy_table::{CellAlignment, Table};

use crate::stdout::prose;
use crate::tables;

/// Fields of a front, and which of them are columns.
pub(crate) struct FrontFields<'a> {
    names: Vec<&'a str>,
    /// Values of the first machine.
    first: Vec<&'a str>,
    /// Places of the fields that differ among the machines; all, where there is one machine.
    columns: Vec<usize>,
}

impl<'a> FrontFields<'a> {
    /// Fields by name, and the values of each machine in the same order.
    pub(crate) fn of(names: Vec<&'a str>, machines: &[Vec<&'a str>]) -> Self {
        let first = machines.first().cloned().unwrap_or_default();
        let differs = |at: &usize| machines.iter().any(|own| own[*at] != first[*at]);
        let columns = (0..names.len()).filter(|at| machines.len() < 2 || differs(at));
        Self {
            columns: columns.collect(),
            names,
            first,
        }
    }

    /// A table of figures with these fields: a column each, or where those do not fit on a line one of texts.
    pub(crate) fn table(&self, header: &[&str], rows: &[(Vec<String>, &Vec<&str>)]) -> Table {
        let names = || self.columns.iter().map(|at| self.names[*at]);
        let mut table = tables::figures(header.iter().copied().chain(names()).collect::<Vec<_>>());
        for (figures, values) in rows {
            let own = self.columns.iter().map(|at| values[*at].to_owned());
            table.add_row(figures.iter().cloned().chain(own).collect::<Vec<_>>());
        }
        if tables::fits(&table) {
            return table;
        }
        let header = header.iter().copied().chain(["fields"]);
        let mut table = tables::figures(header.collect::<Vec<_>>());
        for (figures, values) in rows {
            let own = self.columns.iter();
            let own = own.map(|at| format!("{} = {}", self.names[*at], values[*at]));
            let text = own.collect::<Vec<_>>().join(", ");
            table.add_row(figures.iter().cloned().chain([text]).collect::<Vec<_>>());
        }
        if let Some(last) = table.column_iter_mut().last() {
            last.set_cell_alignment(CellAlignment::Left);
        }
        table
    }

    /// Says the fields that all machines have alike.
    pub(crate) fn say_others(&self) {
        let others = (0..self.names.len()).filter(|at| !self.columns.contains(at));
        let each: Vec<String> = others
            .map(|at| format!("{} = {}", self.names[at], self.first[at]))
            .collect();
        if !each.is_empty() {
            let text = format!("alike in all: {}", each.join(", "));
            prose!(2, "{text}");
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Eight fields fit as columns where their values are short, and stand in a text where they are long.
    #[test]
    fn fields_that_differ_are_columns_while_they_fit() {
        let names = vec!["vu.lanes", "gu.ports", "render.step", "system.gpu.device"];
        let machines = [vec!["12", "2", "x", "a"], vec!["24", "2", "y", "b"]];
        let figures = || vec!["1.00".to_owned()];
        let printed = |own: &FrontFields<'_>, all: &[Vec<&str>]| {
            let rows: Vec<_> = all.iter().map(|values| (figures(), values)).collect();
            tables::fitted(&own.table(&["fps"], &rows), &[])
        };
        let own = FrontFields::of(names.clone(), &machines);
        let text = printed(&own, &machines);
        assert!(
            text.starts_with(" fps vu.lanes render.step system.gpu.device"),
            "{text}"
        );
        let long = "a-device-with-a-long-name".repeat(3);
        let machines = [vec!["12", "2", &long, "a"], vec!["24", "2", "y", &long]];
        let own = FrontFields::of(names, &machines);
        let text = printed(&own, &machines);
        assert!(
            text.contains("vu.lanes = 24") && !text.contains("left out"),
            "{text}"
        );
    }
}
