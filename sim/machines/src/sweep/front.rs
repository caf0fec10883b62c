//! Fronts: rows that no other row is at least as good as in every column, and better in one.

use super::SweepError;
use crate::cells::Cell;

/// The better end of a column.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Better {
    /// More is better.
    More,
    /// Less is better.
    Less,
}

/// Columns with a better end.
const ENDS: [(&str, Better); 16] = [
    ("fps", Better::More),
    ("fps_low", Better::More),
    ("fps_high", Better::More),
    ("free_units_fps", Better::More),
    ("clock_ghz", Better::More),
    ("psnr_db", Better::More),
    ("frame_ms", Better::Less),
    ("mj", Better::Less),
    ("mj_low", Better::Less),
    ("mj_high", Better::Less),
    ("gpu_mj", Better::Less),
    ("accelerator_mj", Better::Less),
    ("memory_mj", Better::Less),
    ("mj_ms", Better::Less),
    ("units_mm2", Better::Less),
    ("mm2", Better::Less),
];

/// The better end of a column.
///
/// # Errors
/// The column has none.
pub fn better(name: &str) -> Result<Better, SweepError> {
    let own = ENDS.iter().find(|(known, _)| *known == name);
    own.map(|(_, better)| *better)
        .ok_or_else(|| SweepError::Column {
            name: name.to_owned(),
            known: ENDS.map(|(known, _)| known).join(", "),
        })
}

/// Which rows are on the front of columns. Rows that lack a number in one of them are not.
///
/// # Errors
/// A column has no better end.
pub fn front(rows: &[Vec<Cell>], columns: &[(usize, &str)]) -> Result<Vec<bool>, SweepError> {
    let ends = columns.iter().map(|(at, name)| Ok((*at, better(name)?)));
    let ends = ends.collect::<Result<Vec<_>, SweepError>>()?;
    // More is better in all.
    let place = |row: &Vec<Cell>| -> Option<Vec<f64>> {
        let each = ends.iter().map(|(at, better)| {
            let own = row.get(*at)?.number()?;
            Some(if *better == Better::Less { -own } else { own })
        });
        each.collect()
    };
    let places: Vec<Option<Vec<f64>>> = rows.iter().map(place).collect();
    let is_worse = |own: &[f64], other: &[f64]| {
        let both = || own.iter().zip(other);
        both().all(|(own, other)| own <= other) && both().any(|(own, other)| own < other)
    };
    // What is on the front of those before a row decides as much as all of them.
    let mut order: Vec<usize> = (0..rows.len()).filter(|at| places[*at].is_some()).collect();
    order.sort_by(|a, b| {
        let [a, b] = [a, b].map(|at| places[*at].as_deref().unwrap_or_default());
        b.partial_cmp(a).unwrap_or(std::cmp::Ordering::Equal)
    });
    let (mut on, mut best): (Vec<bool>, Vec<&[f64]>) = (vec![false; rows.len()], vec![]);
    for at in order {
        let own = places[at].as_deref().unwrap_or_default();
        if !best.iter().any(|other| is_worse(own, other)) {
            on[at] = true;
            best.push(own);
        }
    }
    Ok(on)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// By definition, row by row.
        #[test]
        fn no_row_beats_one_on_the_front(
            all in prop::collection::vec((0u8..6, 0u8..6, 0u8..6), 0..40)
        ) {
            let rows: Vec<Vec<Cell>> = (all.iter())
                .map(|(a, b, c)| [*a, *b, *c].map(|v| Cell::Number(f64::from(v))).to_vec())
                .collect();
            let columns = [(0, "fps"), (1, "mj"), (2, "psnr_db")];
            let on = front(&rows, &columns).unwrap();
            for (at, (a, b, c)) in all.iter().enumerate() {
                let is_beaten = all.iter().any(|(x, y, z)| {
                    x >= a && y <= b && z >= c && (x > a || y < b || z > c)
                });
                prop_assert_eq!(on[at], !is_beaten);
            }
        }
    }

    #[test]
    fn an_unknown_figure_is_on_no_front() {
        let rows = [
            vec![Cell::Unknown, Cell::Number(1.0)],
            vec![Cell::Number(2.0), Cell::Number(3.0)],
        ];
        let on = front(&rows, &[(0, "fps"), (1, "mm2")]).unwrap();
        assert_eq!(on, [false, true]);
        let error = front(&rows, &[(0, "scene")]).unwrap_err().to_string();
        assert!(error.contains("scene") && error.contains("fps"), "{error}");
    }
}
