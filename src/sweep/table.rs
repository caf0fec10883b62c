//! Fronts and differences as text.

use potamoi_machines::cells::{COLUMNS, Cell};
use potamoi_machines::search::is_clock_above_reached;
use potamoi_machines::sweep::{Change, Rows, SweepRow, by_column};

use crate::bounds::number;
use crate::compare::table::shortened;
use crate::front_fields::FrontFields;
use crate::stdout::say;
use crate::tables;

/// Rows of a table that are printed; files have all.
const SHOWN: usize = 20;

/// The rows on a front, in the order of its first column, with the varied fields.
pub(super) fn front(rows: &Rows, on: &[bool], names: &[String]) {
    let mut own: Vec<_> = rows.rows.iter().zip(on).filter(|(_, on)| **on).collect();
    let at = |name: &str| COLUMNS.iter().position(|own| own.name == name);
    let first = names.first().and_then(|name| at(name));
    let key = |cells: &[Cell]| first.and_then(|at| cells.get(at)?.number()).unwrap_or(0.0);
    let scene = |cells: &[Cell]| {
        at("scene")
            .and_then(|at| cells.get(at))
            .map(ToString::to_string)
    };
    own.sort_by(|(a, _), (b, _)| {
        let by_scene = scene(&a.cells).cmp(&scene(&b.cells));
        by_scene.then(key(&b.cells).total_cmp(&key(&a.cells)))
    });
    say!(
        "\nfront of {}, of each scene: {} of {} rows",
        names.join(", "),
        own.len(),
        rows.rows.len()
    );
    if own.is_empty() {
        return;
    }
    let shown = ["machine", "scene"];
    let several = |name: &str| {
        let mut all = rows.rows.iter().filter_map(|row| row.cells.get(at(name)?));
        let first = all.next();
        all.any(|other| Some(other) != first)
    };
    // Rows alike in what the front is of stand once.
    let alike = |row: &SweepRow| -> Vec<Cell> {
        let names = names.iter().map(String::as_str).chain(["scene"]);
        let each = names.filter_map(|name| row.cells.get(at(name)?).cloned());
        each.collect()
    };
    let count = own.len();
    own.dedup_by(|(b, _), (a, _)| alike(a) == alike(b));
    let hidden = count - own.len();
    let settings: Vec<Vec<&str>> = (own.iter())
        .map(|(row, _)| row.setting.iter().map(String::as_str).collect())
        .collect();
    let fields = FrontFields::of(rows.fields.iter().map(String::as_str).collect(), &settings);
    let is_above = own
        .iter()
        .any(|(row, _)| is_clock_above_reached(&row.cells));
    let columns: Vec<&str> = (shown.into_iter().filter(|name| several(name)))
        .chain(names.iter().map(String::as_str))
        .chain((is_above && !names.iter().any(|own| own == "clock_ghz")).then_some("clock_ghz"))
        .chain(["bottleneck"])
        .collect();
    let rows = own
        .iter()
        .zip(&settings)
        .take(SHOWN)
        .map(|((row, _), values)| {
            let cells = columns.iter().map(|name| {
                let cell = at(name).and_then(|at| row.cells.get(at));
                let own = cell.map_or_else(String::new, shown_cell);
                let own = match shown.contains(name) {
                    true => shortened(&own),
                    false => own,
                };
                match *name == "clock_ghz" && is_clock_above_reached(&row.cells) {
                    true => format!("!{own}"),
                    false => own,
                }
            });
            (cells.collect(), values)
        });
    let table = fields.table(&columns, &rows.collect::<Vec<_>>());
    say!("{}", tables::fitted(&table, &["bottleneck"]));
    fields.say_others();
    if is_above {
        say!("  !: above the clock that the slowest block reaches, or that one is not known");
    }
    more(own.len());
    if hidden > 0 {
        say!("  {hidden} rows with the same figures as one of them are left out");
    }
}

/// Figures that differ from another sweep's: by how much, column by column, and then each.
pub(super) fn changes((found, alone): &(Vec<Change>, usize)) {
    say!(
        "\nbeside the other sweep: {} figures differ; {alone} points are in one of both alone",
        found.len()
    );
    if found.is_empty() {
        return;
    }
    let mut table = tables::plain(["figure", "differ", "least ratio", "mean", "greatest"]);
    for own in by_column(found) {
        let [least, mean, most] = match own.ratios {
            Some(all) => all.map(|own| format!("{own:.4}")),
            None => ["-"; 3].map(str::to_owned),
        };
        table.add_row([
            own.column.to_owned(),
            own.figures.to_string(),
            least,
            mean,
            most,
        ]);
    }
    say!("{}", tables::fitted(&table, &[]));
    say!(
        "  ratio: this sweep over the other, of the figures that differ; -: no positive numbers\n"
    );
    let mut table = tables::plain(["figure", "there", "here", "point"]);
    for own in found.iter().take(SHOWN) {
        let [there, here] = own.cells.each_ref().map(shown_cell);
        table.add_row([own.column.to_owned(), there, here, own.point.clone()]);
    }
    say!("{}", tables::fitted(&table, &[]));
    if let Some(more) = found.len().checked_sub(SHOWN).filter(|more| *more > 0) {
        say!("  and {more} more");
    }
}

fn more(count: usize) {
    if let Some(more) = count.checked_sub(SHOWN).filter(|more| *more > 0) {
        say!("  and {more} more, in the files");
    }
}

fn shown_cell(cell: &Cell) -> String {
    match cell {
        Cell::Unknown => "-".to_owned(),
        Cell::Number(own) => number(*own),
        Cell::Text(own) => own.clone(),
    }
}
