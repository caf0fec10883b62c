//! Tables of results.

use potamoi_explore::system::{
    BY_TRAFFIC, Modelled, Paper, PathPairs, frames_per_second, gathering_speed_up,
};
use potamoi_splats::PairTest;
use potamoi_system::system_model::job_scheduler::Resource;
use potamoi_system::system_model::work::{PathReplay, PixelPairs, Replayed};
use potamoi_system::system_model::{AtBounds, Clock, Frames, Outcome, Run, Scenario, System};
use potamoi_warp::Profile;

use super::assumptions;
use super::clock;
use super::limits;
use crate::bounds::{known, range, ratio, saving, with_mid};
use crate::stdout::{prose, say};
use crate::tables;

fn db(of: Option<f64>) -> String {
    of.map_or_else(|| "-".to_owned(), |db| format!("{db:.2}"))
}

/// A figure of the paper, or a note that there is none.
pub(super) fn figure(of: Option<f64>) -> String {
    of.map_or_else(|| "-".to_owned(), |v| format!("{v:.1}"))
}

pub(super) fn percent(of: Option<f64>) -> String {
    of.map_or_else(|| "-".to_owned(), |share| format!("{:.1} %", 100.0 * share))
}

/// Counters of the GPU and memory, a frame.
fn counters(clock: &Clock, outcomes: &[&Outcome]) -> comfy_table::Table {
    let is_remote = outcomes.iter().any(|o| o.run.max.remote_mj.is_some());
    let title = format!("counts per frame, {}", clock::at(clock));
    let mut header = vec![
        title.as_str(),
        "operations",
        "warps' instructions, millions",
        "L1, millions of lines",
        "L2, MB",
        "GPU's memory, MB",
        "DMA transfers",
        "rows opened",
        "refreshes",
    ];
    header.extend(is_remote.then_some("remote GPU, mJ, not the device's"));
    let mut table = tables::plain(&header);
    for o in outcomes {
        // Both bounds do the same work.
        let run = &o.run.max;
        let (spent, frames) = (&run.spent, run.frames as f64);
        let gpu = &spent.gpu;
        let mut row = vec![
            clock::marked(o.variant.name, clock),
            format!("{:.1}", gpu.launches / frames),
            format!("{:.2}", gpu.instructions * 1e-6 / frames),
            format!("{:.2}", gpu.l1_lines * 1e-6 / frames),
            format!("{:.2}", gpu.l2_bytes * 1e-6 / frames),
            format!("{:.2}", gpu.memory_bytes * 1e-6 / frames),
            format!("{:.0}", spent.transfers as f64 / frames),
            format!("{:.0}", spent.rows_opened / frames),
            range(&o.run.map(|run| run.refreshes as f64 / frames)),
        ];
        if is_remote {
            row.push(match run.remote_mj {
                None => "-".to_owned(),
                Some(_) => range(&o.run.map(|run| run.remote_mj.unwrap_or_default())),
            });
        }
        table.add_row(row);
    }
    table
}

/// Utilisation of each part of the system.
fn utilisation(clock: &Clock, outcomes: &[&Outcome]) -> comfy_table::Table {
    let parts = [
        (Resource::Gpu, "GPU"),
        (Resource::GatheringUnit, "gathering unit"),
        (Resource::Npu, "MAC array"),
        (Resource::VectorUnit, "vector unit"),
        (Resource::SplatUnits, "splat units"),
        (Resource::Link, "link"),
        (Resource::Remote, "remote GPU"),
    ];
    let used = |of: &Resource| {
        outcomes
            .iter()
            .any(|o| o.run.max.utilisation.contains_key(of))
    };
    let parts: Vec<_> = parts.into_iter().filter(|(of, _)| used(of)).collect();
    let title = format!("utilisation, {}", clock::at(clock));
    let mut header = vec![
        title.as_str(),
        "memory",
        "interconnect",
        "feature buffer",
        "weight buffer",
    ];
    header.extend(parts.iter().map(|(_, name)| *name));
    let mut table = tables::plain(&header);
    for o in outcomes {
        let share =
            |of: &dyn Fn(&Run) -> f64| format!("{} %", range(&o.run.map(|run| 100.0 * of(run))));
        let mut row = vec![
            clock::marked(o.variant.name, clock),
            share(&|run| run.memory_utilisation),
            share(&|run| run.interconnect_utilisation),
            share(&|run| run.feature_buffer_utilisation),
            share(&|run| run.weight_buffer_utilisation),
        ];
        row.extend(
            parts
                .iter()
                .map(|(of, _)| match o.run.max.utilisation.contains_key(of) {
                    true => share(&|run| run.utilisation.get(of).copied().unwrap_or_default()),
                    false => "-".to_owned(),
                }),
        );
        table.add_row(row);
    }
    table
}

/// A table within a hundred characters.
fn shown(table: &comfy_table::Table) -> String {
    tables::fitted(table, &[])
}

pub(super) fn print(found: &Modelled, system: &System) {
    heading(found);
    for (_, scenario) in scenarios(&found.outcomes) {
        let outcomes = found.outcomes.iter();
        let own: Vec<&Outcome> = outcomes.filter(|o| o.scenario == scenario).collect();
        say!("\n{}\n{}", scenario.heading(), shown(&speed(found, &own)));
        say!("\n{}", shown(&limits::table(found, &own)));
        if scenario == Scenario::Local {
            say!("\n{}", shown(&limits::moved(found, &own)));
            say!("  x: over the variant as it is, ? where that includes 1");
        }
        for (bound, at) in [("overlap wholly", true), ("do not overlap", false)] {
            let of = |o: &&Outcome| {
                if at {
                    o.run.max.clone()
                } else {
                    o.run.sum.clone()
                }
            };
            let runs: Vec<Run> = own.iter().map(of).collect();
            say!(
                "\nwhere demands of a GPU kernel {bound}\n{}",
                shown(&stages(&found.clock, &own, &runs))
            );
        }
        say!("\n{}", shown(&utilisation(&found.clock, &own)));
        say!("\n{}", shown(&energy(&found.clock, &own)));
        say!("\n{}", shown(&counters(&found.clock, &own)));
    }
    gathering_alone(found);
    assumptions::print(found, system);
}

/// The modelled path, and the basis of its figures.
fn heading(found: &Modelled) {
    let options = &found.options;
    prose!(
        0,
        "{} ({}), {} x {}, {} frames, window {}{}{}",
        found.scene,
        found.algorithm,
        found.size[0],
        found.size[1],
        options.frames,
        options.window,
        match options.profile {
            Profile::Potamoi => "",
            Profile::Paper => ", warped by the paper's rules",
            Profile::FirstAuthors => ", warped by the first authors' rules",
        },
        match found.was_kept {
            true => "; rendered and counted earlier",
            false => "; rendered and counted now",
        }
    );
    prose!(
        2,
        "units: {}, by cycle models (--ladder: beside formulas and Verilated units), {}; full \
         frames are counted at the references' poses; {:.1} % of the targets' non-void pixels are \
         rendered",
        found.preset.map_or_else(
            || "as configured".to_owned(),
            |name| format!("preset {name}")
        ),
        clock::said(&found.clock),
        100.0 * found.rendered_share
    );
    if let Some(pairs) = found.splats {
        pixel_pairs(pairs);
    }
    if let Some(why) = found.keeps_all_pairs {
        crate::scene::say_all_pairs(why);
    }
    if let Some(memory) = &found.memory {
        memory_rates(memory);
    }
}

/// Pairs of pixel and Gaussian, and how many of them count.
fn pixel_pairs(pairs: PathPairs) {
    let PathPairs { full, rest, .. } = pairs;
    let share = |of: PixelPairs| {
        let counted = of.pairs_drawn + of.pairs_stopped;
        100.0 * counted as f64 / f64::max(of.pairs_evaluated as f64, 1.0)
    };
    prose!(
        2,
        "pairs of pixel and Gaussian whose alpha counts, of those that are evaluated: {:.1} % of \
         {} in full frames, {:.1} % of {} in the rest",
        share(full),
        full.pairs_evaluated,
        share(rest),
        rest.pairs_evaluated
    );
    if let Some([full, rest]) = pairs.tile_tests {
        let share = |of: PairTest| 100.0 * of.left_out as f64 / f64::max(of.pairs as f64, 1.0);
        prose!(
            2,
            "pairs of tile and Gaussian that the GPU tests and leaves out, since no pixel can count: \
             {:.1} % of {} in full frames, {:.1} % of {} in the rest",
            share(full),
            full.pairs,
            share(rest),
            rest.pairs
        );
    }
}

/// Memory rates of the path's own access sequence.
fn memory_rates(memory: &PathReplay) {
    let rate = |of: Option<Replayed>| {
        of.map_or_else(
            || "at the rates of streams and random runs".to_owned(),
            |of| format!("{:.1} GB/s", 1.0 / of.replayed.ns),
        )
    };
    let rest = memory.rest.unwrap_or(memory.full);
    prose!(
        2,
        "memory, with their accesses replayed: misses of the GPU's cache {} in full frames, {} \
         in the rest; MVoxels {} and {}",
        rate(memory.full.missed),
        rate(rest.missed),
        rate(memory.full.loaded),
        rate(rest.loaded)
    );
}

/// Speed, energy and quality beside the baseline's and the paper's.
fn speed(found: &Modelled, own: &[&Outcome]) -> comfy_table::Table {
    let mut speed = tables::plain([
        &clock::at(&found.clock),
        "frames/s",
        "the paper's, 800 x 800",
        "ms per frame",
        "speed-up",
        "the paper's mean",
        "mJ per frame",
        "saving",
        "the paper's mean",
        "streamed MB",
        "random MB",
        "in floats: PSNR to full frames, dB",
        "in floats: PSNR to truth, dB",
        "loss, dB",
        "the paper's mean",
    ]);
    let whole = own.iter().find(|o| o.variant.frames == Frames::Full);
    let whole = whole.and_then(|o| o.float_quality.truth_db);
    for o in own {
        let frames = o.run.max.frames as f64;
        let spent = &o.run.max.spent;
        let paper = Paper::of(o, found.options.window);
        speed.add_row([
            clock::marked(o.variant.name, &found.clock),
            with_mid(&o.run.frames_per_second()),
            frames_per_second(o, &found.algorithm)
                .unwrap_or("-")
                .to_owned(),
            range(&o.run.span_ns().map(|ns| ns * 1e-6 / frames)),
            ratio(&found.speed_up(o)),
            figure(paper.speed_up),
            known(o.run.total_mj().as_ref()),
            saving(found.saving(o).as_ref()),
            figure(paper.saving),
            format!(
                "{:.2}",
                (spent.streamed_bytes + spent.written_bytes) * 1e-6 / frames
            ),
            format!("{:.2}", spent.random_bytes * 1e-6 / frames),
            db(o.float_quality.full_db),
            db(o.float_quality.truth_db),
            db(whole
                .zip(o.float_quality.truth_db)
                .map(|(whole, own)| whole - own)),
            figure(paper.lost_db),
        ]);
    }
    speed
}

/// Time of a frame by stage.
fn stages(clock: &Clock, own: &[&Outcome], runs: &[Run]) -> comfy_table::Table {
    let stages = [
        "indexing",
        "gathering",
        "computation",
        "compositing",
        "warping",
        "scaling",
        "remote",
        "link",
    ];
    let used: Vec<&str> = stages
        .into_iter()
        .filter(|s| runs.iter().any(|run| run.stages.contains_key(s)))
        .collect();
    let title = format!(
        "ms per frame, {}: own work + memory transfers (bottleneck) + waiting for the unit",
        clock::at(clock)
    );
    let mut header = vec![title.as_str()];
    header.extend(&used);
    let mut times = tables::plain(&header);
    for (o, run) in own.iter().zip(runs) {
        let mut row = vec![clock::marked(o.variant.name, clock)];
        row.extend(used.iter().map(|stage| {
            run.stages.get(stage).map_or_else(
                || "-".to_owned(),
                |t| {
                    let [own, bytes, waiting] =
                        [t.own_ns, t.memory_ns, t.waiting_ns].map(|ns| ns * 1e-6);
                    let by = match bytes < 0.005 {
                        true => String::new(),
                        false => format!(" ({})", t.last_through.most()),
                    };
                    format!("{own:.2} + {bytes:.2}{by} + {waiting:.2}")
                },
            )
        }));
        times.add_row(row);
    }
    times
}

/// Energy of a frame by part.
fn energy(clock: &Clock, own: &[&Outcome]) -> comfy_table::Table {
    let parts = own[0].run.max.energy.named();
    let parts = parts.into_iter().map(|(name, _)| name);
    let title = format!("mJ per frame, {}", clock::at(clock));
    let mut header = vec![title.as_str()];
    header.extend(parts);
    header.push("of memory: data lines");
    let mut energy = tables::plain(&header);
    for o in own {
        let mut row = vec![clock::marked(o.variant.name, clock)];
        let sum = o.run.sum.energy.named();
        let both = o.run.max.energy.named().into_iter().zip(sum);
        row.extend(both.map(|((_, max), (_, sum))| {
            let both = max.zip(sum).map(|(max, sum)| AtBounds { max, sum });
            known(both.as_ref())
        }));
        row.push(range(&o.run.map(|run| run.memory_io_mj)));
        energy.add_row(row);
    }
    energy
}

/// Gathering on the unit beside gathering on the GPU, for one full frame.
fn gathering_alone(found: &Modelled) {
    let gathered = &found.gathered;
    let (paper, whose) = gathering_speed_up(&found.algorithm);
    say!("");
    prose!(
        0,
        "gathering of a full frame, {}: {} ms on the GPU, {} ms on the unit, a speed-up of {} (the \
         paper: {paper} {whose})",
        clock::at(&found.clock),
        range(&gathered.gpu_ns.map(|ns| ns * 1e-6)),
        range(&gathered.unit_ns.map(|ns| ns * 1e-6)),
        times(&gathered.gpu_ns, &gathered.unit_ns)
    );
    let memory = &gathered.memory;
    prose!(
        2,
        "its memory energy: {:.3} > {:.3} mJ; {} of the saving by less traffic, the rest by \
         streaming (the paper: {:.1} %)",
        memory.before_pj * 1e-9,
        memory.after_pj * 1e-9,
        percent(memory.traffic_share()),
        100.0 * BY_TRAFFIC
    );
}

/// Ratio of two times; a dash where there is nothing to gather.
pub(super) fn times(one: &AtBounds<f64>, other: &AtBounds<f64>) -> String {
    if other.low() > 0.0 {
        ratio(&one.over(other))
    } else {
        "-".to_owned()
    }
}

/// Each scenario with the index of its baseline.
pub(super) fn scenarios(outcomes: &[Outcome]) -> Vec<(usize, Scenario)> {
    let mut all: Vec<(usize, Scenario)> = vec![];
    for (at, outcome) in outcomes.iter().enumerate() {
        if all.iter().all(|(_, known)| *known != outcome.scenario) {
            all.push((at, outcome.scenario));
        }
    }
    all
}
