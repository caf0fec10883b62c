//! The search as text, below 100 columns.

use potamoi_machines::search::{Goal, Method, Searched, Trials, Tried};

use crate::bounds::number;
use crate::stdout::say;
use crate::tables;

/// Machines of a search that stand side by side, with their names.
pub(super) fn shown(searched: &Searched) -> Vec<(&'static str, &Tried)> {
    let found = match searched.found() {
        Some(_) => "found",
        None => "nearest",
    };
    let all = [
        Some(("base", &searched.base)),
        searched.nearest().map(|own| (found, own)),
        (searched.random.as_ref())
            .and_then(|own| own.nearest())
            .map(|own| ("random search", own)),
    ];
    all.into_iter().flatten().collect()
}

/// The points that were tried, and the fields of the best.
pub(super) fn settings(searched: &Searched) {
    let own = &searched.trials;
    let tried = own.tried.len();
    match own.method {
        Method::Exhaustive => say!("every point of the space: {tried}"),
        _ => say!(
            "{tried} of {} points, by Parzen estimators",
            searched.points
        ),
    }
    let rows = shown(searched);
    let header = ["field"]
        .into_iter()
        .chain(rows.iter().map(|(name, _)| *name));
    let mut table = tables::plain(header.collect::<Vec<_>>());
    for (at, (field, _)) in searched.base.setting.iter().enumerate() {
        let value = |tried: &Tried| {
            let own = tried.setting.get(at);
            own.map_or_else(|| "-".to_owned(), |(_, value)| value.clone())
        };
        let each = rows.iter().map(|(_, tried)| value(tried));
        table.add_row([field.clone()].into_iter().chain(each).collect::<Vec<_>>());
    }
    say!("{table}\n");
}

/// Machines of the front that are printed; the JSON report has all.
const SHOWN: usize = 12;

/// Machines within the limits that no other is better than in objective, area or quality, and at least as
/// good as in the others.
pub(super) fn front(searched: &Searched, goal: &Goal) {
    let on = searched.front(goal.objective);
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
    say!("{}", tables::fitted(&table, &[]));
    if let Some(more) = on.len().checked_sub(SHOWN).filter(|more| *more > 0) {
        say!("  and {more} more, in --json");
    }
    say!("");
}

/// Most reasons of refusals that are printed; the JSON report has all.
const REASONS: usize = 4;

/// Points without figures, by reason.
pub(super) fn refused(searched: &Searched) {
    let mut reasons: Vec<(&str, usize)> = vec![];
    let all = searched.tried().filter(|own| !own.has_figures());
    for why in all.filter_map(|own| own.scenes.iter().find_map(|own| own.as_ref().err())) {
        match reasons.iter_mut().find(|(known, _)| known == why) {
            Some((_, count)) => *count += 1,
            None => reasons.push((why, 1)),
        }
    }
    reasons.sort_by_key(|(_, count)| std::cmp::Reverse(*count));
    for (why, count) in reasons.iter().take(REASONS) {
        let all = searched.tried().count();
        let text = format!("no figures of {count} of {all} points: {why}");
        say!("{}", tables::broken_at_words(&text, "", "  "));
    }
    if let Some(more) = reasons.len().checked_sub(REASONS).filter(|more| *more > 0) {
        say!("and {more} more reasons, in --json");
    }
}

/// When each method had its best.
pub(super) fn beside_random(searched: &Searched, goal: &Goal) {
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
    let both = searched.trials.nearest().zip(random.nearest());
    if both.is_some_and(|(own, chance)| chance.is_better(own)) {
        say!(
            "the random search found the better machine: a larger --budget may find a better one yet"
        );
    }
}
