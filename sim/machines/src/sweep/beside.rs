//! Two sweeps side by side.

use std::collections::HashMap;

use super::rows::{Rows, SweepRow};
use crate::cells::{COLUMNS, Cell};

/// Columns that tell which point a row is of, beside the varied fields.
const NAMES: [&str; 2] = ["machine", "scene"];

/// A figure that differs between two sweeps at the same point.
#[derive(Debug, Clone, PartialEq)]
pub struct Change {
    /// Values of the varied fields, and machine and scene.
    pub point: String,
    /// The column.
    pub column: &'static str,
    /// The figure of the other sweep, and of this one.
    pub cells: [Cell; 2],
}

/// Figures that differ at points of both sweeps, and the number of points that one of them lacks.
#[must_use]
pub fn changes(own: &Rows, other: &Rows) -> (Vec<Change>, usize) {
    let point = |rows: &Rows, row: &SweepRow| {
        let names = COLUMNS.iter().zip(&row.cells);
        let names = names.filter(|(column, _)| NAMES.contains(&column.name));
        let names = names.map(|(_, cell)| cell.to_string());
        let mut fields: Vec<String> = (rows.fields.iter().zip(&row.setting))
            .map(|(field, value)| format!("{field} {value}"))
            .collect();
        fields.sort();
        names.chain(fields).collect::<Vec<_>>().join(", ")
    };
    let known: HashMap<String, &SweepRow> = (other.rows.iter())
        .map(|row| (point(other, row), row))
        .collect();
    let (mut found, mut both) = (vec![], 0);
    for row in &own.rows {
        let at = point(own, row);
        let Some(before) = known.get(&at) else {
            continue;
        };
        both += 1;
        let cells = before.cells.iter().zip(&row.cells).zip(&COLUMNS);
        for ((before, now), column) in cells.filter(|((before, now), _)| before != now) {
            found.push(Change {
                point: at.clone(),
                column: column.name,
                cells: [before.clone(), now.clone()],
            });
        }
    }
    (found, own.rows.len() + other.rows.len() - 2 * both)
}
