//! Tables of numbers.

use std::sync::atomic::{AtomicBool, Ordering};

use comfy_table::{
    Cell, CellAlignment, Column, ColumnConstraint, ContentArrangement, Row, Table, presets,
};

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

/// A table as [`narrow`], whose first column is of figures too.
pub(crate) fn figures(header: impl Into<Row>) -> Table {
    let mut table = narrow(header);
    if let Some(first) = table.column_mut(0) {
        first.set_cell_alignment(CellAlignment::Right);
    }
    table
}

/// A table as [`plain`], whose long cells are broken at words, within a hundred characters.
pub(crate) fn side_by_side(header: impl Into<Row>) -> Table {
    let mut table = plain(header);
    table
        .set_content_arrangement(ContentArrangement::Dynamic)
        .set_width(LINE);
    if let Some(names) = table.column_mut(0) {
        names.set_constraint(ColumnConstraint::ContentWidth);
    }
    table
}

/// Most columns of a line.
const LINE: u16 = 98;

/// A table of texts without rules, whose last column is broken at words, within a hundred characters.
pub(crate) fn wrapped() -> Table {
    let mut table = Table::new();
    table
        .load_preset(presets::NOTHING)
        .set_content_arrangement(ContentArrangement::Dynamic)
        .set_width(LINE);
    table
}

/// A text broken at words, within a hundred characters: what its first and its other lines begin with.
pub(crate) fn broken_at_words(text: &str, first: &str, rest: &str) -> String {
    let mut out = first.to_owned();
    let mut line = first.chars().count();
    let mut is_begun = false;
    for word in text.split_whitespace() {
        let own = word.chars().count();
        if is_begun && line + 1 + own > usize::from(LINE) {
            out.push('\n');
            out.push_str(rest);
            line = rest.chars().count();
        } else if is_begun {
            out.push(' ');
            line += 1;
        }
        out.push_str(word);
        line += own;
        is_begun = true;
    }
    out
}

/// Whether tables have all their columns, whatever their width (`--wide`).
static WIDE: AtomicBool = AtomicBool::new(false);

/// Shows all columns of tables from now on.
pub(crate) fn show_all_columns() {
    WIDE.store(true, Ordering::Relaxed);
}

/// A table's text, within a hundred characters unless `--wide` is given: headers are broken at words,
/// then columns are left out, in the order of `last`, and a line below names them.
pub(crate) fn fitted(table: &Table, last: &[&str]) -> String {
    match WIDE.load(Ordering::Relaxed) {
        true => table.trim_fmt(),
        false => narrowed(table, last),
    }
}

fn width(table: &Table) -> usize {
    let lines = table.lines();
    lines.map(|line| line.chars().count()).max().unwrap_or(0)
}

/// Longest part of a field's path that is not broken at its words, in characters.
const PART: usize = 10;

/// Parts of a header between which a line may end: words, those of a field's path, and words of its long
/// ones.
fn parts(header: &str) -> impl Iterator<Item = &str> {
    header.split_inclusive([' ', '.']).flat_map(|part| {
        let is_long = part.chars().count() > PART;
        part.split_inclusive(move |c| is_long && c == '_')
    })
}

/// A header of several lines, each as wide as its column's cells or its longest part.
fn broken(header: &str, cells: usize) -> String {
    let width = |part: &str| part.trim_end().chars().count();
    let most = parts(header).map(width).max().unwrap_or(0).max(cells);
    let (mut lines, mut line): (Vec<String>, String) = (vec![], String::new());
    for part in parts(header) {
        if !line.is_empty() && line.chars().count() + width(part) > most {
            lines.push(line.trim_end().to_owned());
            line.clear();
        }
        line.push_str(part);
    }
    lines.push(line.trim_end().to_owned());
    lines.join("\n")
}

/// Least width of a column of texts that is broken at words.
const TEXT: usize = 24;

/// Whether a column's cells are texts of several words.
fn is_text(table: &Table, column: usize) -> bool {
    let mut cells = table
        .row_iter()
        .filter_map(|row| row.cell_iter().nth(column));
    cells.any(|cell| {
        cell.content()
            .split(' ')
            .filter(|word| word.len() > 1)
            .count()
            > 3
    })
}

/// The table without a column.
fn without(table: &Table, column: usize) -> Table {
    let mut own = table.clone();
    if let Some(column) = own.column_mut(column) {
        column.set_constraint(ColumnConstraint::Hidden);
    }
    own
}

fn header_of(table: &Table) -> Vec<String> {
    match table.header() {
        Some(header) => header.cell_iter().map(Cell::content).collect(),
        None => vec![],
    }
}

/// The table with headers of several lines.
fn with_broken_header(table: &Table) -> Table {
    let mut own = table.clone();
    let wide = |column: usize| {
        let cells = table
            .row_iter()
            .filter_map(|row| row.cell_iter().nth(column));
        let lines = cells.map(|cell| cell.content().lines().map(|l| l.chars().count()).max());
        lines.flatten().max().unwrap_or(0)
    };
    let names = header_of(table);
    let each = names.iter().enumerate();
    own.set_header(each.map(|(at, name)| broken(name, wide(at))));
    own
}

/// Whether [`fitted`] leaves no column of a table out.
pub(crate) fn fits(table: &Table) -> bool {
    let is_wide = WIDE.load(Ordering::Relaxed);
    is_wide || width(&with_broken_header(table)) <= usize::from(LINE)
}

fn narrowed(table: &Table, last: &[&str]) -> String {
    let line = usize::from(LINE);
    if width(table) <= line {
        return table.trim_fmt();
    }
    let names = header_of(table);
    let mut own = with_broken_header(table);
    let mut hidden: Vec<&str> = vec![];
    for name in last {
        if width(&own) <= line {
            break;
        }
        let columns = names.iter().enumerate().filter(|(_, own)| own == name);
        let columns: Vec<usize> = columns.map(|(at, _)| at).collect();
        for column in &columns {
            if let Some(column) = own.column_mut(*column) {
                column.set_constraint(ColumnConstraint::Hidden);
            }
        }
        if !columns.is_empty() {
            hidden.push(name);
        }
    }
    let end = names.len().saturating_sub(1);
    if width(&own) > line && is_text(table, end) && width(&without(&own, end)) + TEXT <= line {
        // A column of texts at the end is broken at words.
        for column in own.column_iter_mut().take(end) {
            if column.constraint().is_none() {
                column.set_constraint(ColumnConstraint::ContentWidth);
            }
        }
        own.set_content_arrangement(ContentArrangement::Dynamic)
            .set_width(LINE);
    }
    for column in (2..names.len()).rev() {
        if width(&own) <= line {
            break;
        }
        if !own.column(column).is_some_and(Column::is_hidden) {
            own = without(&own, column);
            hidden.push(&names[column]);
        }
    }
    match hidden.is_empty() {
        true => own.trim_fmt(),
        false => {
            let names = format!("left out: {} (--wide)", hidden.join(", "));
            format!("{}\n{}", own.trim_fmt(), broken_at_words(&names, "", "  "))
        }
    }
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
    fn wide_tables_break_their_headers_and_then_leave_columns_out() {
        let names = (0..12).map(|i| format!("a long header {i}"));
        let mut table = plain(names.collect::<Vec<_>>());
        table.add_row((0..12).map(|i| format!("{i}.000")));
        assert!(width(&table) > 150);
        let text = narrowed(&table, &["a long header 3"]);
        assert!(
            text.lines().all(|line| line.chars().count() <= 98),
            "{text}"
        );
        assert!(!text.contains("left out"), "{text}");
        let mut table = plain((0..30).map(|i| format!("c{i}")).collect::<Vec<_>>());
        table.add_row((0..30).map(|i| format!("{i}.000")));
        let names: Vec<String> = (10..30).map(|i| format!("c{i}")).collect();
        let last: Vec<&str> = names.iter().map(|name| &**name).collect();
        let text = narrowed(&table, &last);
        assert!(text.contains("left out: c10, c11"), "{text}");
        assert!(
            text.lines().take(2).all(|line| line.chars().count() <= 98),
            "{text}"
        );
    }

    #[test]
    fn headers_end_their_lines_between_words_and_parts_of_paths() {
        assert_eq!(
            broken("speed-up the paper's mean", 4),
            "speed-up\nthe\npaper's\nmean"
        );
        assert_eq!(broken("system.array_rows", 3), "system.\narray_rows");
        assert_eq!(
            broken("system.array_columns", 3),
            "system.\narray_\ncolumns"
        );
        assert_eq!(broken("psnr_db", 3), "psnr_db");
        assert_eq!(broken("vu.exp.pipelined", 6), "vu.exp.\npipelined");
        assert_eq!(broken("mm2", 9), "mm2");
    }

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
