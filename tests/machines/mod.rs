//! Machines side by side, sweeps, and searches.

mod compare;
mod search;
mod sweep;

use std::fs;
use std::path::Path;

/// Longest line of a table, in characters.
const COLUMNS: usize = 100;

fn assert_narrow(text: &str) {
    for line in text.lines().filter(|line| !line.starts_with("progress")) {
        assert!(line.chars().count() <= COLUMNS, "{line}");
    }
}

/// Rows of a CSV file, by name of the column.
fn rows(path: &Path) -> Vec<std::collections::BTreeMap<String, String>> {
    let text = fs::read_to_string(path).unwrap();
    let split = |line: &str| -> Vec<String> {
        // Reasons of refusals alone have commas, in quotes, and stand last.
        let (plain, quoted) = match line.split_once('"') {
            Some((plain, rest)) => (
                plain.trim_end_matches(','),
                Some(rest.trim_end_matches('"')),
            ),
            None => (line, None),
        };
        let cells = plain.split(',').chain(quoted);
        cells.map(str::to_owned).collect()
    };
    let mut lines = text.lines();
    let names = split(lines.next().unwrap());
    let each = lines.map(|line| names.iter().cloned().zip(split(line)).collect());
    each.collect()
}
