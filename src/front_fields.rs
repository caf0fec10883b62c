//! Varied fields of the machines on a front: columns for those that differ, a line for the others.

use crate::stdout::prose;

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

    /// Headers of the columns.
    pub(crate) fn header(&self) -> impl Iterator<Item = &str> {
        self.columns.iter().map(|at| self.names[*at])
    }

    /// Cells of a machine.
    pub(crate) fn cells(&self, values: &[&str]) -> Vec<String> {
        let own = self.columns.iter().map(|at| values[*at].to_owned());
        own.collect()
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

    #[test]
    fn fields_that_differ_are_columns() {
        let machines = [vec!["12", "2", "x"], vec!["24", "2", "y"]];
        let own = FrontFields::of(vec!["vu.lanes", "gu.ports", "render.step"], &machines);
        assert_eq!(
            own.header().collect::<Vec<_>>(),
            ["vu.lanes", "render.step"]
        );
        assert_eq!(own.cells(&machines[1]), ["24", "y"]);
        let one = FrontFields::of(vec!["vu.lanes"], &[vec!["12"]]);
        assert_eq!(one.header().collect::<Vec<_>>(), ["vu.lanes"]);
    }
}
