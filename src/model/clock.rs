//! The accelerator's clock: said beside the figures that it touches, and the blocks that bound it.

use potamoi_system::system_model::{Clock, ClockOrigin};

use crate::tables;

/// The clock with its origin, in a sentence.
pub(crate) fn said(clock: &Clock) -> String {
    let slowest = clock.blocks.first();
    let slowest = slowest.map_or_else(String::new, |own| match own.ps {
        Some(ps) => format!("{} of {ps:.0} ps", own.block),
        None => "no known block".to_owned(),
    });
    let wires = match clock.wire_margin > 0.0 {
        true => format!("with {:.0} % for wires", 100.0 * clock.wire_margin),
        false => "before wires".to_owned(),
    };
    let reached = clock
        .reached_ghz
        .map_or_else(|| "nothing".to_owned(), |ghz| format!("{ghz:.2} GHz"));
    match clock.origin {
        ClockOrigin::Assumed => format!(
            "{} GHz assumed ({reached} reached at 12 nm {wires}, by {slowest})",
            clock.ghz
        ),
        origin => format!(
            "{:.2} GHz, {} at 12 nm {wires}, bound by {slowest}",
            clock.ghz,
            origin.word()
        ),
    }
}

/// The clock and its origin, for the heading of a table.
pub(super) fn at(clock: &Clock) -> String {
    format!("{:.2} GHz, {}", clock.ghz, clock.origin.word())
}

/// The name of a row of figures, with the clock where that is not synthesised.
pub(crate) fn marked(name: &str, clock: &Clock) -> String {
    match clock.origin {
        ClockOrigin::Synthesised => name.to_owned(),
        origin => format!("{name} (at {:.2} GHz, {})", clock.ghz, origin.word()),
    }
}

/// The name of a row of means over scenes, with the worst origin of their clocks.
pub(super) fn marked_mean<'a>(name: &str, clocks: impl IntoIterator<Item = &'a Clock>) -> String {
    let origins: Vec<ClockOrigin> = clocks.into_iter().map(|own| own.origin).collect();
    let worst = [ClockOrigin::Assumed, ClockOrigin::Estimated];
    match worst.into_iter().find(|origin| origins.contains(origin)) {
        Some(origin) => format!("{name} (clocks {})", origin.word()),
        None => name.to_owned(),
    }
}

/// Scenes, each with its clock.
pub(super) fn listed<'a>(scenes: impl IntoIterator<Item = (&'a str, &'a Clock)>) -> String {
    let each = scenes.into_iter().map(|(scene, own)| {
        let origin = own.origin.word();
        format!("{scene} at {:.2} GHz, {origin}", own.ghz)
    });
    each.collect::<Vec<_>>().join("; ")
}

/// The blocks, the slowest first.
pub(super) fn table(clock: &Clock) -> comfy_table::Table {
    let mut table = tables::plain(["the accelerator's clock", "ps at 12 nm", "GHz", "origin"]);
    for own in &clock.blocks {
        let figure = |of: Option<String>| of.unwrap_or_else(|| "-".to_owned());
        table.add_row([
            own.block.clone(),
            figure(own.ps.map(|ps| format!("{ps:.0}"))),
            figure(own.ps.map(|ps| format!("{:.2}", 1e3 / ps))),
            own.from.clone(),
        ]);
    }
    table
}
