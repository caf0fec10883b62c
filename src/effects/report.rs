//! Report of `potamoi effects`.

use potamoi_base::effects::Effect;
use potamoi_explore::effects::{Effects, Forced, FoundEffect, UnitUse, Without};
use serde::Serialize;

use crate::stdout::say;

/// Version of the JSON report.
pub(super) const FORMAT_VERSION: u32 = 1;

#[derive(Serialize)]
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

fn print_effect(effect: &FoundEffect) {
    let asked = if effect.called_for {
        "called for    "
    } else {
        "not called for"
    };
    say!("  {:<22} {asked}  {}", effect.title(), effect.evidence);
    let pad = " ".repeat(41);
    let timed = effect
        .cost
        .wall
        .as_ref()
        .map(|wall| format!("{} for {}", wall.pairs.words(), wall.of));
    match (effect.called_for, timed) {
        (true, Some(timed)) => say!("{pad}costs {}; {timed}", effect.cost.work.words()),
        (true, None) => say!("{pad}costs {}", effect.cost.work.words()),
        (false, Some(timed)) => say!("{pad}saves {timed}"),
        (false, None) if effect.saving.wall_ms == Some(0.0) => {
            say!("{pad}saves nothing: the simulator skips it, forced or not");
        }
        (false, None) => {}
    }
}

fn print_unit(unit: &UnitUse) {
    let is = match (unit.instantiated, unit.used_by_path) {
        (false, _) => "not instantiated",
        (true, false) => "not loaded: no camera of the path needs it",
        (true, true) => "instantiated",
    };
    say!("  {:<22} {is}", unit.unit);
    for part in &unit.left_out {
        say!(
            "    {}: {} instead of {}, since {}",
            part.field,
            part.left,
            part.asked,
            part.reason
        );
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
    found.effects.iter().for_each(print_effect);
    if found.pairs > 0 {
        say!(
            "  wall times are the simulator's, medians of {} interleaved pairs",
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
