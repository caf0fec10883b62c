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

/// How far the figures of a column differ.
#[derive(Debug, Clone, PartialEq)]
pub struct ColumnChange {
    /// The column.
    pub column: &'static str,
    /// The number of figures that differ.
    pub figures: usize,
    /// This sweep over the other one: the least ratio, the geometric mean and the greatest of the figures that
    /// differ; none where one of them is no positive number.
    pub ratios: Option<[f64; 3]>,
}

/// Differences by column, in the order of the columns.
#[must_use]
pub fn by_column(changes: &[Change]) -> Vec<ColumnChange> {
    let of = |name: &'static str| {
        let own: Vec<&Change> = changes.iter().filter(|own| own.column == name).collect();
        (!own.is_empty()).then(|| ColumnChange {
            column: name,
            figures: own.len(),
            ratios: ratios(&own),
        })
    };
    COLUMNS.iter().filter_map(|own| of(own.name)).collect()
}

fn ratios(changes: &[&Change]) -> Option<[f64; 3]> {
    let positive = |cell: &Cell| cell.number().filter(|own| *own > 0.0);
    let each: Option<Vec<f64>> = (changes.iter())
        .map(|own| Some(positive(&own.cells[1])? / positive(&own.cells[0])?))
        .collect();
    let each = each?;
    let least = each.iter().copied().fold(f64::INFINITY, f64::min);
    let most = each.iter().copied().fold(0.0, f64::max);
    let logarithms: f64 = each.iter().map(|own| own.ln()).sum();
    Some([least, (logarithms / each.len() as f64).exp(), most])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn change(column: &'static str, there: impl Into<Cell>, here: impl Into<Cell>) -> Change {
        Change {
            point: String::new(),
            column,
            cells: [there.into(), here.into()],
        }
    }

    #[test]
    fn columns_have_the_ratios_of_their_figures() {
        let found = by_column(&[
            change("mj", 2.0, 1.0),
            change("fps", 1.0, 2.0),
            change("fidelity", "demand", "schedule"),
            change("fps", 4.0, 2.0),
            change("fps", 10.0, 10.5),
        ]);
        let names: Vec<_> = found.iter().map(|own| (own.column, own.figures)).collect();
        assert_eq!(names, [("fidelity", 1), ("fps", 3), ("mj", 1)]);
        assert_eq!(found[0].ratios, None);
        let [least, mean, most] = found[1].ratios.unwrap_or_default();
        assert_eq!([least, most], [0.5, 2.0]);
        assert!((mean.powi(3) - 1.05).abs() < 1e-12, "{mean}");
    }
}
