//! The comparison as text, below 100 columns.

use std::collections::BTreeSet;

use potamoi_machines::{Comparison, Figures, Row};
use potamoi_system::system_model::{ClockOrigin, Frames, Variant};

use crate::bounds::{tight, times};
use crate::stdout::{prose, say};
use crate::tables;

/// Whether a machine renders several frames, each in full.
fn has_full_frames(own: &Figures) -> bool {
    let variant = Variant::named(own.variant);
    own.frames > 1 && variant.is_some_and(|own| own.frames == Frames::Full)
}

pub(crate) fn print(found: &Comparison) {
    for (at, rows) in found.scenes.iter().enumerate() {
        scene(found, at, rows);
    }
    if found.scenes.len() > 1 {
        means(found);
    }
    let any = || found.scenes.iter().flatten().filter_map(Row::figures);
    if any().any(|own| own.clock_origin != ClockOrigin::Synthesised) {
        say!("GHz: ~ estimated by formulas, ! assumed; otherwise synthesised, before wires");
    }
    if any().any(|own| own.clock_origin == ClockOrigin::Guessed) {
        say!("  ? a guess, since the period of a block is not known: the slowest of its kind");
    }
    for own in above_reached(any()) {
        prose!(2, "{own}");
    }
    for own in other_arrays(found) {
        prose!(2, "{own}");
    }
    say!("a range has two ends: all demands of a GPU kernel overlap, and none do");
    if any().any(has_full_frames) {
        say!("frames in full: each has the work of the path's first");
    }
    say!("x: over the first machine, ? where it includes 1");
    let is_alone_twice = found.scenes.iter().any(|rows| {
        let all = alone(rows);
        all.iter().any(|(_, is_known)| *is_known)
    });
    if is_alone_twice {
        say!(
            "as NAME: the GPU alone renders the frames of that machine, whose settings are others"
        );
    }
    say!("mm^2 at 12 nm: units with their memories, and all with array and buffers, before wires");
    let unknown: BTreeSet<String> = any()
        .flat_map(|own| {
            let machine = &own.machine;
            (own.unknown.iter()).map(move |of| format!("{machine}: {}: {}", of.block, of.why))
        })
        .collect();
    if !unknown.is_empty() {
        say!("not known:");
        for own in unknown {
            prose!(2, "{own}");
        }
    }
}

/// Machines whose array or buffers are not those of the first, each once: what an area is paid with.
fn other_arrays(found: &Comparison) -> BTreeSet<String> {
    let parts = |own: &Figures| {
        let ([rows, columns], [features, weights]) = (own.array, own.buffer_bytes);
        let kib = |bytes: u64| match bytes % 1024 {
            0 => format!("{} KiB", bytes / 1024),
            _ => format!("{bytes} bytes"),
        };
        [
            ("an array of", format!("{rows} x {columns}")),
            ("a feature buffer of", kib(features)),
            ("a weight buffer of", kib(weights)),
        ]
    };
    let each = found.scenes.iter().flat_map(|rows| {
        let first = rows.first().and_then(Row::figures);
        let others = rows.iter().filter_map(Row::figures);
        others.filter_map(move |own| {
            let both = parts(own).into_iter().zip(parts(first?));
            let differ = both.filter(|((_, own), (_, first))| own != first);
            let each = differ.map(|((what, own), (_, first))| format!("{what} {own} for {first}"));
            let all: Vec<String> = each.collect();
            (!all.is_empty()).then(|| format!("{} has {}", own.machine, all.join(", ")))
        })
    });
    each.collect()
}

/// Machines whose assumed clock is above the one that they reach, each once.
fn above_reached<'a>(all: impl Iterator<Item = &'a Figures>) -> BTreeSet<String> {
    let above = all.filter_map(|own| {
        let reached = own.reached_ghz?;
        (own.clock_ghz > reached).then(|| {
            let by = own.clock_bound_by.as_deref().unwrap_or("its slowest block");
            format!(
                "{}: {:.2} GHz is assumed, and {reached:.2} reached ({by})",
                own.machine, own.clock_ghz
            )
        })
    });
    above.collect()
}

fn scene(found: &Comparison, at: usize, rows: &[Row]) {
    if let Some(first) = rows.iter().find_map(Row::figures) {
        let beside = first.quality.map_or_else(String::new, |own| {
            format!("; PSNR beside {}", own.beside.words())
        });
        prose!(
            0,
            "{} ({}), {} x {}, {} frame{}{beside}",
            first.scene,
            first.algorithm,
            first.size[0],
            first.size[1],
            first.frames,
            if first.frames == 1 { "" } else { "s" }
        );
    }
    let mut table = tables::narrow([
        "", "GHz", "frames/s", "x", "mJ", "x", "dB", "units", "mm^2", "bound by",
    ]);
    for (row, own) in rows.iter().enumerate() {
        if let Row::Figures(own) = own {
            let ratios = found.ratios(at, row);
            let rate = ratios.map_or_else(unknown, |own| times(&own.rate));
            let energy = ratios.and_then(|own| own.energy);
            table.add_row([
                named(own),
                clock(own),
                tight(&own.frames_per_second),
                rate,
                own.mj.map_or_else(unknown, |mj| tight(&mj)),
                energy.map_or_else(unknown, |own| times(&own)),
                decibels(own),
                figure(own.units_mm2, 3),
                figure(own.mm2, 2),
                bound(own),
            ]);
        }
    }
    for (own, is_known) in alone(rows) {
        let name = match is_known {
            // The name of a file is longer than what tells it from others.
            true if own.machine.contains('/') => {
                format!("  as {}", shortened_to(&own.machine, NAME - "  as ".len()))
            }
            true => format!("  as {}", shortened(&own.machine)),
            false => format!("{} alone", own.gpu),
        };
        let first = rows.first().and_then(Row::figures);
        let rate = &own.gpu_alone_frames_per_second;
        let over = first.map(|first| rate.over(&first.frames_per_second));
        let dash = unknown;
        table.add_row([
            name,
            dash(),
            tight(rate),
            over.map_or_else(unknown, |own| times(&own)),
            dash(),
            dash(),
            dash(),
            dash(),
            dash(),
            dash(),
        ]);
    }
    if rows.iter().any(|own| own.figures().is_some()) {
        say!("{}", tables::fitted(&table, &[]));
    }
    for own in rows {
        if let Row::Refused {
            machine, refused, ..
        } = own
        {
            prose!(2, "{machine} is left out: {refused}");
        }
    }
    if rows.first().is_some_and(|own| own.figures().is_none()) {
        say!("  no ratios here: the first machine has no figures");
    }
    say!("");
}

/// Machines whose GPU alone has a row, and whether that GPU has one above: machines that render otherwise are
/// beside another frame of the same GPU, which stands below its first.
fn alone(rows: &[Row]) -> Vec<(&Figures, bool)> {
    let mut all: Vec<(&Figures, bool)> = vec![];
    for own in rows.iter().filter_map(Row::figures) {
        if all.iter().all(|(known, _)| !is_alone_alike(known, own)) {
            let after = all.iter().rposition(|(known, _)| known.gpu == own.gpu);
            let at = after.map_or(all.len(), |at| at + 1);
            all.insert(at, (own, after.is_some()));
        }
    }
    all
}

/// Geometric means over the scenes.
fn means(found: &Comparison) {
    let Some(rows) = found.scenes.first() else {
        return;
    };
    if (0..rows.len()).all(|row| found.means(row).is_none()) {
        say!("no means over scenes: the first machine has figures on none");
        return;
    }
    say!("geometric means over scenes");
    let mut table = tables::plain(["", "scenes", "x frames/s", "x energy"]);
    for (row, own) in rows.iter().enumerate() {
        let name = match own {
            Row::Figures(own) => &own.machine,
            Row::Refused { machine, .. } => machine,
        };
        let Some((ratios, count)) = found.means(row) else {
            continue;
        };
        table.add_row([
            shortened(name),
            count.to_string(),
            times(&ratios.rate),
            ratios.energy.map_or_else(unknown, |own| times(&own)),
        ]);
    }
    say!("{}\n", table.trim_fmt());
}

fn unknown() -> String {
    "-".to_owned()
}

/// The machine, with its variant where that is not full frames through the unit: of a name within the usual
/// length.
fn named(own: &Figures) -> String {
    match own.variant {
        "fs+gu" => shortened(&own.machine),
        variant => {
            let room = NAME.saturating_sub(variant.len() + 2).max(8);
            format!("{}: {variant}", shortened_to(&own.machine, room))
        }
    }
}

/// Longest name of a machine in a table, in characters.
const NAME: usize = 20;

/// A long name in short: of a path its last part, then without `.toml`, then its end. Files differ there.
pub(crate) fn shortened(name: &str) -> String {
    shortened_to(name, NAME)
}

/// As [`shortened`], to so many characters.
fn shortened_to(name: &str, most: usize) -> String {
    let last = name.rsplit_once('/').map(|(_, last)| format!("../{last}"));
    let stem = last.as_ref().and_then(|own| own.strip_suffix(".toml"));
    let shorter = [Some(name), last.as_deref(), stem];
    let fits = |own: &&str| own.chars().count() <= most;
    match shorter.into_iter().flatten().find(fits) {
        Some(own) => own.to_owned(),
        None => {
            let own = stem.unwrap_or(name);
            let cut = own.chars().count() + 2 - most;
            format!("..{}", own.chars().skip(cut).collect::<String>())
        }
    }
}

/// Whether the same GPU alone renders the same frames for two machines.
fn is_alone_alike(one: &Figures, other: &Figures) -> bool {
    one.gpu == other.gpu && one.gpu_alone_frames_per_second == other.gpu_alone_frames_per_second
}

fn clock(own: &Figures) -> String {
    format!("{}{:.2}", own.clock_origin.mark(), own.clock_ghz)
}

fn decibels(own: &Figures) -> String {
    match own.quality {
        None => unknown(),
        Some(own) => own
            .db
            .map_or_else(|| "same".to_owned(), |db| format!("{db:.1}")),
    }
}

fn figure(of: Option<f64>, digits: usize) -> String {
    of.map_or_else(unknown, |mm2| format!("{mm2:.digits$}"))
}

/// The bottleneck at both bounds.
pub(super) fn bound(own: &Figures) -> String {
    let of = |(name, share): (&'static str, Option<f64>)| match share {
        Some(share) => format!("{} {:.0} %", short(name), 100.0 * share),
        None => short(name).to_owned(),
    };
    let [max, sum] = [own.bottleneck.max, own.bottleneck.sum];
    match max.0 == sum.0 {
        true => of(max),
        false => format!("{}, {}", short(max.0), short(sum.0)),
    }
}

/// A resource without the word for what kind it is.
fn short(name: &str) -> &str {
    let kinds = [" unit", " units", " buffer"];
    let cut = kinds.iter().find_map(|kind| name.strip_suffix(kind));
    cut.unwrap_or(name)
}

#[cfg(test)]
mod tests {
    use super::shortened_to;

    #[test]
    fn long_names_keep_what_files_differ_in() {
        let of = |name| shortened_to(name, 20);
        assert_eq!(of("paper"), "paper");
        assert_eq!(of("a/paper.toml"), "a/paper.toml");
        assert_eq!(of("a/long/folder/paper.toml"), "../paper.toml");
        assert_eq!(of("docs/smaller-array.toml"), "../smaller-array");
        assert_eq!(
            of("docs/smaller-array-orin-nx.toml"),
            "..ller-array-orin-nx"
        );
        assert_eq!(of("a-name-without-a-folder"), "..e-without-a-folder");
    }
}
