//! The front of a sweep: which rows are on it, and why others cannot be.

use potamoi_machines::Workload;
use potamoi_machines::cells::COLUMNS;
use potamoi_machines::search::is_clock_above_reached;
use potamoi_machines::sweep::{Rows, SweepRow, front};

use crate::failure::Failure;
use crate::stdout::prose;

/// Rows whose clock is above the one that their slowest block reaches, in a sweep that has rows of machines
/// at a clock that they reach; none where all assume one, which is then on purpose.
fn out_of_reach(rows: &Rows) -> Vec<bool> {
    let is_above = |row: &SweepRow| row.refused.is_none() && is_clock_above_reached(&row.cells);
    let above: Vec<bool> = rows.rows.iter().map(is_above).collect();
    let mut both = rows.rows.iter().zip(&above);
    match both.any(|(row, above)| row.refused.is_none() && !above) {
        true => above,
        false => vec![false; above.len()],
    }
}

/// Rows on the front over these columns, scene by scene; `None` without columns.
///
/// # Errors
/// A column that no front can be over.
pub(super) fn on_front(rows: &Rows, names: &[String]) -> Result<Option<Vec<bool>>, Failure> {
    if names.is_empty() {
        return Ok(None);
    }
    let columns: Vec<(usize, &str)> = (names.iter())
        .filter_map(|name| {
            let at = COLUMNS.iter().position(|own| own.name == name)?;
            Some((at, name.as_str()))
        })
        .collect();
    // Each scene has a front of its own: a light one is no better machine.
    let scene_at = COLUMNS.iter().position(|own| own.name == "scene");
    let scene_of = |at: usize| scene_at.and_then(|scene| rows.rows[at].cells.get(scene));
    let is_out = out_of_reach(rows);
    let mut on = vec![false; rows.rows.len()];
    let mut done: Vec<_> = vec![];
    for first in 0..rows.rows.len() {
        let scene = scene_of(first);
        if done.contains(&scene) {
            continue;
        }
        done.push(scene);
        let own: Vec<usize> = (0..rows.rows.len())
            .filter(|at| scene_of(*at) == scene && !is_out[*at])
            .collect();
        let cells: Vec<_> = own.iter().map(|at| rows.rows[*at].cells.clone()).collect();
        for (at, is_on) in own.into_iter().zip(front(&cells, &columns)?) {
            on[at] = is_on;
        }
    }
    Ok(Some(on))
}

/// Says how many rows assume a clock that their machine does not reach.
pub(super) fn say_out_of_reach(rows: &Rows) {
    let count = out_of_reach(rows).into_iter().filter(|own| *own).count();
    if count > 0 {
        prose!(
            2,
            "the clock of {count} of {} rows is above the one that their slowest block reaches: they are on no \
             front",
            rows.rows.len()
        );
    }
}

/// Says why columns of a front keep rows off it: an unknown figure is on no front.
pub(super) fn say_unknown(rows: &Rows, names: &[String], workload: &Workload) {
    let figured: Vec<_> = rows
        .rows
        .iter()
        .filter(|row| row.refused.is_none())
        .collect();
    for name in names {
        let at = COLUMNS.iter().position(|own| own.name == name);
        let is_unknown = |row: &&&SweepRow| at.and_then(|at| row.cells.get(at)?.number()).is_none();
        let count = figured.iter().filter(is_unknown).count();
        let why = match name.as_str() {
            "psnr_db" if !workload.quality => {
                ": the plan has `quality = false` in [workload], so that no picture is rendered for it"
            }
            _ => "",
        };
        if count > 0 {
            prose!(
                2,
                "{name} is not known for {count} of {} rows, which are on no front of it{why}",
                figured.len()
            );
        }
    }
}
