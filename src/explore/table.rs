//! The search as text, below 100 columns.

use potamoi_machines::search::{CHECKED, Goal, Method, Searched, Trials, Tried};

use crate::bounds::number;
use crate::front_fields::FrontFields;
use crate::reasons::reasons;
use crate::stdout::{prose, say};
use crate::tables;

/// The best of a method, where it is not what was found.
fn other<'a>(
    name: &'static str,
    trials: Option<&'a Trials>,
    nearest: Option<&Tried>,
) -> Option<(&'static str, &'a Tried)> {
    let own = trials?.nearest()?;
    let is_it = nearest.is_some_and(|best| best.setting == own.setting);
    (!is_it).then_some((name, own))
}

/// Machines with figures of a search that stand side by side, with their names.
pub(super) fn shown(searched: &Searched) -> Vec<(&'static str, &Tried)> {
    let best = |own: &Tried| match (own.keeps_limits, own.is_better(searched.judged_base())) {
        (true, true) => "found",
        (true, false) => "best of all",
        (false, _) => "nearest",
    };
    let nearest = searched.nearest();
    let estimators = (searched.random.is_some()).then_some(&searched.trials);
    let all = [
        Some(("base", &searched.base)),
        nearest.map(|own| (best(own), own)),
        other("estimators", estimators, nearest),
        other("random search", searched.random.as_ref(), nearest),
    ];
    let has_figures = |(name, own): &(&str, &Tried)| *name == "base" || own.has_figures();
    all.into_iter().flatten().filter(has_figures).collect()
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
    let mut table = tables::side_by_side(header.collect::<Vec<_>>());
    for (at, (field, _)) in searched.base.setting.iter().enumerate() {
        let value = |tried: &Tried| {
            let own = tried.setting.get(at);
            own.map_or_else(|| "-".to_owned(), |(_, value)| value.clone())
        };
        let each = rows.iter().map(|(_, tried)| value(tried));
        table.add_row([field.clone()].into_iter().chain(each).collect::<Vec<_>>());
    }
    say!("{}\n", table.trim_fmt());
}

fn values(of: &Tried) -> Vec<&str> {
    let all = of.setting.iter().map(|(_, value)| value.as_str());
    all.collect()
}

/// Machines of the front that are printed; the JSON report has all.
const SHOWN: usize = 12;

/// Machines within the limits that no other is better than in objective, area or quality, and at least as
/// good as in the others: their figures, then the fields in which they differ.
pub(super) fn front(searched: &Searched, goal: &Goal) {
    let on = searched.front(goal.objective);
    let Some(first) = on.first() else { return };
    let (column, _) = goal.objective.column();
    let plural = if on.len() == 1 { "" } else { "s" };
    let by = if searched.by_schedule.is_some() {
        ", by demand"
    } else {
        ""
    };
    say!(
        "front of {column}, area and quality{by}: {} machine{plural}",
        on.len()
    );
    let all: Vec<Vec<&str>> = on.iter().copied().map(values).collect();
    let names = first.setting.iter().map(|(field, _)| field.as_str());
    let fields = FrontFields::of(names.collect(), &all);
    let mut header = vec![column, "mm2", "psnr_db"];
    header.dedup();
    let rows = on.iter().zip(&all).take(SHOWN).filter_map(|(own, values)| {
        let [objective, area, psnr] = own.place(goal.objective)?;
        let psnr = match psnr.is_finite() {
            true => number(psnr),
            false => "same".to_owned(),
        };
        let cells = match column {
            "mm2" => vec![number(area), psnr],
            _ => vec![number(objective), number(area), psnr],
        };
        Some((cells, values))
    });
    let table = fields.table(&header, &rows.collect::<Vec<_>>());
    say!("{}", tables::fitted(&table, &[]));
    fields.say_others();
    if let Some(more) = on.len().checked_sub(SHOWN).filter(|more| *more > 0) {
        say!("  and {more} more, in --json");
    }
    say!("");
}

/// Most reasons of refusals that are printed; the JSON report has all.
const REASONS: usize = 4;

/// Points without figures, by reason.
pub(super) fn refused(searched: &Searched) {
    let all = searched.tried().filter(|own| !own.has_figures());
    let texts = all.filter_map(|own| own.scenes.iter().find_map(|own| own.as_ref().err()));
    let reasons = reasons(texts.map(String::as_str));
    let count = searched.tried().count();
    for own in reasons.iter().take(REASONS) {
        prose!(
            0,
            "no figures of {} of {count} points: {}",
            own.points,
            own.words()
        );
    }
    if let Some(more) = reasons.len().checked_sub(REASONS).filter(|more| *more > 0) {
        say!("and {more} more reasons, in --json");
    }
}

/// Points whose area or energy is not known, by the first such block, with the reason at one of them: they
/// keep no limit of it, and are on no front.
pub(super) fn unknown(searched: &Searched) {
    let all: Vec<&str> = searched.tried().filter_map(Tried::unknown).collect();
    let block = |why: &&str| why.split(':').next().unwrap_or_default().to_owned();
    let blocks: Vec<String> = all.iter().map(block).collect();
    for own in reasons(blocks.iter().map(String::as_str)) {
        let name = own.text;
        let why = all.iter().find(|why| block(why) == name);
        prose!(
            0,
            "area or energy of the {name} is not known at {} of {} points; of one of them: {}",
            own.points,
            searched.tried().count(),
            why.map_or("", |why| why[name.len()..].trim_start_matches([':', ' ']))
        );
    }
}

/// Points at clocks that their machines do not reach.
pub(super) fn above_reached_clock(searched: &Searched, goal: &Goal) {
    let count = searched
        .tried()
        .filter(|own| own.is_clock_above_reached())
        .count();
    if goal.needs_reached_clock && count > 0 {
        let all = searched.tried().count();
        let text = format!(
            "the clock of {count} of {all} points is above the one that their slowest block reaches: they keep \
             no limit"
        );
        prose!(0, "{text}");
    }
}

/// What was judged by its schedule, of a search by demand.
pub(super) fn by_schedule(searched: &Searched) {
    let Some(own) = &searched.by_schedule else {
        return;
    };
    let kept = own.tried.iter().filter(|own| own.keeps_limits).count();
    prose!(
        0,
        "the {} best by demand were evaluated again by their schedule, {kept} of which keep the limits: what is \
         found is the best of these",
        own.tried.len().min(CHECKED)
    );
}

/// Points whose clock is a guess.
pub(super) fn guessed_clock(searched: &Searched) {
    let count = searched
        .tried()
        .filter(|own| own.is_clock_guessed())
        .count();
    if count > 0 && !searched.base.is_clock_guessed() {
        prose!(
            0,
            "the clock of {count} of {} points is a guess, since the period of a block is not known: they keep \
             no limit",
            searched.tried().count()
        );
    }
}

/// By how much the best is behind the base in the objective, in words.
pub(super) fn behind(searched: &Searched, found: &Tried, goal: &Goal) -> String {
    let (column, is_more) = goal.objective.column();
    let place = |own: &Tried| own.place(goal.objective).map(|own| own[0]);
    match place(searched.judged_base()).zip(place(found)) {
        Some((base, own)) if own != base => {
            let share = 100.0 * (own / base - 1.0).abs();
            let way = if is_more { "less" } else { "more" };
            format!(" (the best has {share:.2} % {way} {column})")
        }
        _ => String::new(),
    }
}

/// When each method had its best.
pub(super) fn beside_random(searched: &Searched, goal: &Goal) {
    let Some(random) = &searched.random else {
        return;
    };
    let after = |trials: &Trials| trials.best.map_or(0, |at| at + 1);
    let (column, _) = goal.objective.column();
    prose!(
        0,
        "best {column}: after {} points by estimators, after {} by a random search of the same budget",
        after(&searched.trials),
        after(random)
    );
    let both = searched.trials.nearest().zip(random.nearest());
    if both.is_some_and(|(own, chance)| chance.is_better(own)) {
        prose!(
            0,
            "the random search found the better machine: a larger --budget may find a better one yet"
        );
    }
}
