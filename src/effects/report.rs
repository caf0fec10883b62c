//! Report of `potamoi effects`.

use potamoi_base::effects::Effect;
use potamoi_explore::effects::{
    Effects, Figure, Forced, FoundEffect, HardwareSaving, UnitUse, Without,
};
use schemars::JsonSchema;
use serde::Serialize;

use crate::stdout::{prose, say};
use crate::tables;

/// Version of the JSON report.
pub(super) const FORMAT_VERSION: u32 = 2;

#[derive(Serialize, JsonSchema)]
pub(super) struct Report {
    pub(super) format_version: u32,
    pub(super) command: &'static str,
    #[serde(flatten)]
    pub(super) found: Effects,
    pub(super) seconds: f64,
    /// Unused or assumed parts of the scene's files, and whether the view is empty.
    pub(super) not_checked: Vec<String>,
}

/// Cost of an effect as text, if it is called for.
pub(super) fn cost_words(effect: &FoundEffect) -> String {
    match effect.called_for {
        true => effect.cost.work.words(),
        false => "not called for".to_owned(),
    }
}

/// A figure; where it is not known a dash, whose reason is printed below.
fn figure(of: &Figure, digits: usize) -> String {
    of.value
        .map_or_else(|| "-".to_owned(), |v| format!("{v:.digits$}"))
}

/// The answer at a glance: how many effects are called for, and what the others would cost.
fn answer(found: &Effects) -> String {
    let called_for = found.effects.iter().filter(|own| own.called_for).count();
    let saved = &found.all_saved;
    let known = |of: &Figure, digits: usize, unit: &str| {
        of.value.map(|value| format!("{value:.digits$} {unit}"))
    };
    let figures = [
        known(&saved.area_mm2, 4, "mm^2 at 12 nm"),
        known(&saved.cycles, 0, "cycles"),
        known(&saved.energy_uj, 3, "uJ a frame"),
    ];
    let figures: Vec<String> = figures.into_iter().flatten().collect();
    format!(
        "{called_for} of {} effects are called for; leaving out the others saves {}",
        found.effects.len(),
        match figures.as_slice() {
            [] => "what is not known (see below)".to_owned(),
            own => own.join(", "),
        }
    )
}

/// Which effects are called for, and the hardware that leaving out each of the others saves.
fn print_savings(found: &Effects) {
    let mut table = tables::narrow([
        "effect",
        "called for",
        "saves mm^2 (12 nm)",
        "cycles",
        "uJ a frame",
    ]);
    let row = |name: String, called_for: &str, saving: Option<&HardwareSaving>| {
        let cell = |of: fn(&HardwareSaving) -> &Figure, digits: usize| {
            saving.map_or_else(String::new, |own| figure(of(own), digits))
        };
        [
            name,
            called_for.to_owned(),
            cell(|own| &own.area_mm2, 4),
            cell(|own| &own.cycles, 0),
            cell(|own| &own.energy_uj, 3),
        ]
    };
    for effect in &found.effects {
        let word = if effect.called_for { "yes" } else { "no" };
        table.add_row(row(effect.title(), word, effect.saving.hardware.as_ref()));
    }
    let all = "all that no camera needs".to_owned();
    table.add_row(row(all, "", Some(&found.all_saved)));
    say!("{table}");
    print_origins(found);
}

/// Origins of the figures, and why others are not known; each with the effects that it is of.
fn print_origins(found: &Effects) {
    let own = found.effects.iter();
    let own = own.filter_map(|own| Some((own.title(), own.saving.hardware.as_ref()?)));
    let all = own.chain([("all".to_owned(), &found.all_saved)]);
    // Origin, quantities and effects, in the order of their first use.
    let mut origins: Vec<(&str, Vec<&str>, Vec<String>)> = vec![];
    for (effect, saving) in all {
        for (what, of) in [("mm^2", &saving.area_mm2), ("uJ", &saving.energy_uj)] {
            let at = origins.iter().position(|(text, ..)| *text == of.origin);
            let at = at.unwrap_or_else(|| {
                origins.push((&of.origin, vec![], vec![]));
                origins.len() - 1
            });
            let (_, quantities, effects) = &mut origins[at];
            if !quantities.contains(&what) {
                quantities.push(what);
            }
            if !effects.contains(&effect) {
                effects.push(effect.clone());
            }
        }
    }
    for (origin, quantities, effects) in origins {
        let text = format!(
            "{}, {}: {origin}",
            quantities.join(" and "),
            effects.join(", ")
        );
        prose!(2, "{text}");
    }
    let text = format!("cycles: {}", found.all_saved.cycles.origin);
    prose!(2, "{text}");
    say!(
        "  blank: called for, so that leaving it out saves nothing; -: not known, for the reasons above"
    );
}

/// Evidence for each decision, and what the effect takes.
fn print_evidence(found: &Effects) {
    let mut table = tables::wrapped();
    for effect in &found.effects {
        let mut lines = vec![effect.evidence.clone()];
        if effect.called_for {
            lines.push(format!("takes {}", effect.cost.work.words()));
        }
        lines.extend(wall_words(effect));
        table.add_row([effect.title(), lines.join("\n")]);
    }
    say!("\n{}", table.trim_fmt());
}

/// Wall time of the simulator, where it was timed: what an effect takes, or what leaving it out saves.
fn wall_words(effect: &FoundEffect) -> Option<String> {
    if let Some(wall) = &effect.cost.wall {
        let verb = if effect.called_for { "takes" } else { "saves" };
        let pairs = &wall.pairs;
        let noise = pairs.spread_ms.unwrap_or(0.0);
        return Some(match pairs.difference_ms > noise {
            true => format!("{verb} {} of the simulator, for {}", pairs.words(), wall.of),
            false => format!(
                "{verb} no time of the simulator that can be told from noise: below {noise:.2} ms of \
                 {:.2} ms for {}",
                pairs.with_ms, wall.of
            ),
        });
    }
    let skipped = !effect.called_for && effect.saving.wall_ms == Some(0.0);
    skipped.then(|| "the simulator skips it, forced or not".to_owned())
}

fn print_unit(unit: &UnitUse) {
    let is = match (unit.instantiated, unit.used_by_path) {
        (false, _) => "not instantiated",
        (true, false) => "not loaded: no camera of the path needs it",
        (true, true) => "instantiated",
    };
    say!("  {:<22} {is}", unit.unit);
    for part in &unit.left_out {
        let text = format!(
            "{}: {} instead of {}, since {}",
            part.field, part.left, part.asked, part.reason
        );
        prose!(4, "{text}");
    }
}

/// Cycles of the splat unit as a part of a list; nothing where there is none.
fn splats(cycles: u64) -> String {
    match cycles {
        0 => String::new(),
        cycles => format!(", {cycles} splat unit"),
    }
}

/// Result of forcing as text.
fn forced_words(forced: &Forced) -> String {
    let same = |is_same: bool| if is_same { "the same" } else { "a DIFFERENT" };
    format!(
        "forced {}: {} image, {} trace ({}), {} modelled cycles ({} gathering, {} vector, {} \
         MAC array{}){}",
        forced.effects.join(", "),
        same(forced.same_image),
        same(forced.same_trace),
        forced.trace,
        same(forced.same_cycles),
        forced.cycles.gather,
        forced.cycles.vector,
        forced.cycles.array,
        splats(forced.cycles.splats),
        forced.wall.map_or_else(String::new, |wall| format!(
            ", which takes {} of the simulator's wall time (median of pairs)",
            wall.words()
        ))
    )
}

/// Result of leaving out an effect as text.
fn without_words(without: &Without) -> String {
    let degree = without.degree.map_or_else(String::new, |d| format!(":{d}"));
    let asked = match without.called_for {
        true => "called for",
        false => "not called for",
    };
    if [Effect::RemoteLink, Effect::RandomDram]
        .map(Effect::name)
        .contains(&without.name)
    {
        return format!(
            "without {} ({asked}): no pixel and no cycle of the units changes, since the effect \
             is the system's; potamoi model would lack {}",
            without.name,
            match without.name == Effect::RandomDram.name() {
                true => "random MB, and their part of gathering's time and of memory's energy",
                false => "the link's time and energy (--scenario remote)",
            }
        );
    }
    let error = match without.psnr_db {
        Some(db) => format!(
            "{db:.1} dB PSNR against {} with it, {} of {} pixels changed, by {:.4} at most",
            without.of, without.pixels_changed, without.pixels, without.largest_difference
        ),
        None => format!("no pixel of {} changes", without.of),
    };
    let cycles = without.cycles_more.map_or_else(String::new, |more| {
        format!("; modelled cycles of the units: {more:+}")
    });
    format!(
        "without {}{degree} ({asked}): {error}{cycles}",
        without.name
    )
}

/// Prints the whole report.
pub(super) fn print(found: &Effects) {
    prose!(0, "{}", answer(found));
    say!(
        "{} ({}) at {} x {}, {} frame{} of its path, configuration {}",
        found.scene,
        found.algorithm,
        found.width,
        found.height,
        found.frames,
        if found.frames == 1 { "" } else { "s" },
        found.configuration
    );
    print_savings(found);
    print_evidence(found);
    if found.pairs > 0 {
        say!(
            "wall times are the simulator's, medians of {} interleaved pairs",
            found.pairs
        );
    }
    found.units.iter().for_each(print_unit);
    if let Some(forced) = &found.forced {
        say!("  {}", forced_words(forced));
    }
    for without in &found.without {
        say!("  {}", without_words(without));
    }
    if let Some(rtl) = &found.rtl {
        say!(
            "  Verilated units: the parts that the scene does not call for take {}; without them \
             {} picture, counts and cycles ({} gathering, {} vector{})",
            rtl.wall
                .map_or_else(|| "an unknown time".to_owned(), |wall| wall.words()),
            if rtl.is_same {
                "the same"
            } else {
                "a DIFFERENT"
            },
            rtl.cycles.gather,
            rtl.cycles.vector,
            splats(rtl.cycles.splat)
        );
    }
}
