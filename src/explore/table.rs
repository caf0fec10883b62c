//! The search as text, below 100 columns.

use potamoi_machines::cells::{COLUMNS, Cell};
use potamoi_machines::search::{Goal, Method, Searched, Trials, Tried};
use potamoi_scene::Scene;

use crate::bounds::number;
use crate::stdout::say;
use crate::tables;

pub(super) fn print(searched: &Searched, scenes: &[Scene], goal: &Goal) {
    let own = &searched.trials;
    let tried = own.tried.len();
    match own.method {
        Method::Exhaustive => say!("every point of the space: {tried}"),
        _ => say!(
            "{tried} of {} points, by Parzen estimators",
            searched.points
        ),
    }
    let mut rows = vec![("base", Some(&searched.base))];
    rows.push((
        match own.found() {
            Some(_) => "found",
            None => "nearest",
        },
        own.nearest(),
    ));
    if let Some(random) = &searched.random {
        rows.push(("random search", random.nearest()));
    }
    let fields: Vec<&str> = own
        .nearest()
        .map(|tried| {
            tried
                .setting
                .iter()
                .map(|(field, _)| field.as_str())
                .collect()
        })
        .unwrap_or_default();
    let mut settings = tables::plain(
        [
            &["field"][..],
            &["base", "found", "random search"][..rows.len()],
        ]
        .concat(),
    );
    for (at, field) in fields.iter().enumerate() {
        let value = |tried: Option<&Tried>| {
            let own = tried.and_then(|own| own.setting.get(at));
            own.map_or_else(|| "-".to_owned(), |(_, value)| value.clone())
        };
        let each = rows.iter().map(|(_, tried)| value(*tried));
        settings.add_row(
            [(*field).to_owned()]
                .into_iter()
                .chain(each)
                .collect::<Vec<_>>(),
        );
    }
    say!("{settings}\n");
    for (at, scene) in scenes.iter().enumerate() {
        say!("{}", scene.name());
        let mut table = tables::narrow([
            "", "GHz", "frames/s", "x", "mJ", "x", "dB", "units", "mm^2", "bound by",
        ]);
        let base = searched
            .base
            .scenes
            .get(at)
            .and_then(|own| own.as_ref().ok());
        for (name, tried) in &rows {
            let cells = tried.and_then(|own| own.scenes.get(at));
            match cells {
                Some(Ok(cells)) => {
                    table.add_row(row(name, cells, base.map(Vec::as_slice)));
                }
                Some(Err(why)) => say!("  {name}: {why}"),
                None => {}
            }
        }
        say!("{table}\n");
    }
    front(own, goal);
    beside_random(searched, goal);
}

/// Machines of the front that are printed; the JSON report has all.
const SHOWN: usize = 12;

/// Machines within the limits that no other is better than in objective, area or quality, and at least as
/// good as in the others.
fn front(trials: &Trials, goal: &Goal) {
    let on: Vec<&Tried> = trials
        .front
        .iter()
        .filter_map(|at| trials.tried.get(*at))
        .collect();
    let Some(first) = on.first() else { return };
    let (column, _) = goal.objective.column();
    say!("front of {column}, area and quality: {} machines", on.len());
    let fields = first.setting.iter().map(|(field, _)| field.as_str());
    let figures = [column, "mm2", "psnr_db"].into_iter();
    let mut figures: Vec<&str> = figures.collect();
    figures.dedup();
    let mut table = tables::narrow(fields.chain(figures.iter().copied()).collect::<Vec<_>>());
    for own in on.iter().take(SHOWN) {
        let Some([objective, area, psnr]) = own.place(goal.objective) else {
            continue;
        };
        let psnr = match psnr.is_finite() {
            true => number(psnr),
            false => "same".to_owned(),
        };
        let cells = match column {
            "mm2" => vec![number(area), psnr],
            _ => vec![number(objective), number(area), psnr],
        };
        let values = own.setting.iter().map(|(_, value)| value.clone());
        table.add_row(values.chain(cells).collect::<Vec<_>>());
    }
    say!("{table}");
    if let Some(more) = on.len().checked_sub(SHOWN).filter(|more| *more > 0) {
        say!("  and {more} more, in --json");
    }
    say!("");
}

fn row(name: &str, cells: &[Cell], base: Option<&[Cell]>) -> Vec<String> {
    let figure = |cells: &[Cell], column: &str| {
        let at = COLUMNS.iter().position(|own| own.name == column)?;
        cells.get(at).cloned()
    };
    let own = |column| figure(cells, column);
    let shown = |column| match own(column) {
        Some(Cell::Number(own)) => number(own),
        Some(Cell::Text(own)) => own,
        _ => "-".to_owned(),
    };
    let over = |column: &str, more: bool| {
        let [own, base] = [Some(cells), base].map(|of| figure(of?, column)?.number());
        let both = own.zip(base);
        both.map_or_else(
            || "-".to_owned(),
            |(own, base)| number(if more { own / base } else { base / own }),
        )
    };
    vec![
        name.to_owned(),
        shown("clock_ghz"),
        shown("fps"),
        over("fps", true),
        shown("mj"),
        over("mj", false),
        shown("psnr_db"),
        shown("units_mm2"),
        shown("mm2"),
        shown("bottleneck"),
    ]
}

/// When each method had its best.
fn beside_random(searched: &Searched, goal: &Goal) {
    let Some(random) = &searched.random else {
        return;
    };
    let after = |trials: &Trials| trials.best.map_or(0, |at| at + 1);
    let (column, _) = goal.objective.column();
    say!(
        "best {column}: after {} points by estimators, after {} by a random search of the same budget",
        after(&searched.trials),
        after(random)
    );
}
