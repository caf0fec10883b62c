//! Machines side by side, sweeps, and searches.

mod compare;
mod given_syntheses;
mod search;
mod sweep;

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
    let mut read = csv::Reader::from_path(path).unwrap();
    read.deserialize().map(Result::unwrap).collect()
}
