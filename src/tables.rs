//! Tables of numbers.

use comfy_table::{CellAlignment, Row, Table, presets};

/// A table without rules: a column of names, then right-aligned numbers.
pub(crate) fn plain(header: impl Into<Row>) -> Table {
    numbers(presets::NOTHING, 1, header)
}

/// A table as [`plain`], whose columns are one space apart: for ten columns within a hundred characters.
pub(crate) fn narrow(header: impl Into<Row>) -> Table {
    let mut table = plain(header);
    for (at, column) in table.column_iter_mut().enumerate() {
        column.set_padding((u16::from(at > 0), 0));
    }
    table
}

/// A table with rules: `names` columns of names, then right-aligned numbers.
pub(crate) fn lined(names: usize, header: impl Into<Row>) -> Table {
    numbers(presets::ASCII_BORDERS_ONLY_CONDENSED, names, header)
}

fn numbers(preset: &str, names: usize, header: impl Into<Row>) -> Table {
    let mut table = Table::new();
    table.load_preset(preset).set_header(header);
    for column in table.column_iter_mut().skip(names) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_to_the_right_of_names() {
        let mut table = plain(["name", "count"]);
        table.add_row(["a", "7"]);
        assert_eq!(table.to_string(), " name  count \n a         7 ");
        let mut table = narrow(["name", "count"]);
        table.add_row(["a", "7"]);
        assert_eq!(table.to_string(), "name count\na        7");
        let mut table = lined(2, ["name", "kind", "count"]);
        table.add_row(["a", "b", "7"]);
        let text = table.to_string();
        assert!(text.contains("| a      b          7 |"), "{text}");
    }
}
