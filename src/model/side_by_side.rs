//! Table of many scenes.

use potamoi_explore::system::{BY_TRAFFIC, Modelled, Paper, gathering_speed_up};
use potamoi_system::system_model::{Alone, AtBounds, Outcome, Scenario};

use super::clock;
use super::means;
use super::report::Report;
use super::tables::{figure, percent, scenarios, times};
use crate::bounds::{range, ratio, saving};
use crate::stdout::say;
use crate::tables;

/// Speed-ups and energy savings of many scenes, their means, and the paper's.
pub(super) fn print(report: &Report<Modelled>) {
    let Some(first) = report.scenes.first() else {
        return;
    };
    for (at, scenario) in scenarios(&first.outcomes) {
        let own: Vec<usize> = (0..first.outcomes.len())
            .filter(|i| first.outcomes[*i].scenario == scenario)
            .collect();
        let mut header = vec![
            "speed-up (saving)".to_owned(),
            "GHz".to_owned(),
            "frames/s of the baseline".to_owned(),
        ];
        header.extend(
            own.iter()
                .map(|i| first.outcomes[*i].variant.name.to_owned()),
        );
        let mut rows = tables::plain(header);
        for found in &report.scenes {
            let mut row = vec![
                clock::marked(&found.scene, &found.clock),
                format!("{:.2}", found.clock.ghz),
                range(&found.outcomes[at].run.frames_per_second()),
            ];
            row.extend(own.iter().map(|i| {
                let o = &found.outcomes[*i];
                format!(
                    "{} ({})",
                    ratio(&found.speed_up(o)),
                    saving(found.saving(o).as_ref())
                )
            }));
            rows.add_row(row);
        }
        for (name, row) in mean_rows(report, &own) {
            let name = clock::marked_mean(&name, report.scenes.iter().map(|own| &own.clock));
            rows.add_row([vec![name, String::new(), String::new()], row].concat());
        }
        let mut row = vec!["the paper's mean".to_owned(), String::new(), String::new()];
        row.extend(own.iter().map(|i| {
            let paper = Paper::of(&first.outcomes[*i], first.options.window);
            format!("{} ({})", figure(paper.speed_up), figure(paper.saving))
        }));
        rows.add_row(row);
        let rows = tables::fitted(&rows, &[]);
        say!("\n{}\n{rows}", scenario.heading());
    }
    alone(report);
    gathering(report);
}

/// Means over the scenes of these outcomes, and without a scene that decides one.
fn mean_rows(report: &Report<Modelled>, outcomes: &[usize]) -> Vec<(String, Vec<String>)> {
    let each = |of: &dyn Fn(&Modelled, &Outcome) -> Option<AtBounds<f64>>, i: usize| {
        let all = report.scenes.iter();
        let all = all.map(|found| of(found, &found.outcomes[i]));
        all.collect::<Option<Vec<_>>>()
    };
    let speed_ups = outcomes.iter();
    let speed_ups = speed_ups.filter_map(|i| each(&|found, o| Some(found.speed_up(o)), *i));
    let speed_ups: Vec<Vec<AtBounds<f64>>> = speed_ups.collect();
    let savings: Vec<_> = (outcomes.iter())
        .map(|i| each(&Modelled::saving, *i))
        .collect();
    let row = |mean: &dyn Fn(&[AtBounds<f64>]) -> AtBounds<f64>| {
        let both = speed_ups.iter().zip(&savings);
        both.map(|(speed_up, own)| {
            let of_energy = own.as_ref().map(|own| mean(own));
            format!(
                "{} ({})",
                ratio(&mean(speed_up)),
                saving(of_energy.as_ref())
            )
        })
        .collect()
    };
    let mut rows = vec![
        ("mean".to_owned(), row(&means::mean)),
        ("geometric mean".to_owned(), row(&means::geometric)),
    ];
    let columns = savings.iter().flatten().chain(&speed_ups).cloned();
    if let Some(scene) = means::deciding(&columns.collect::<Vec<_>>()) {
        let name = format!("mean without {}", report.scenes[scene].scene);
        rows.push((name, row(&|all| means::mean(&means::without(all, scene)))));
    }
    rows
}

/// The last variant beside the GPU alone, by scene.
fn alone(report: &Report<Modelled>) {
    let mut rows = tables::plain([
        "beside the GPU alone",
        "GHz",
        "fused program, frames/s",
        "published program, frames/s",
        "variant",
        "its frames/s",
        "over fused",
        "over published",
    ]);
    for found in &report.scenes {
        let per_second = |alone: &Alone| range(&alone.frame_ns.map(|ns| 1e9 / ns));
        let gpu = &found.gpu_only;
        for o in &found.outcomes {
            if o.scenario != Scenario::Local || !["fs+gu", "potamoi"].contains(&o.variant.name) {
                continue;
            }
            let none = || "-".to_owned();
            let published = gpu.published.as_ref();
            rows.add_row([
                clock::marked(&found.scene, &found.clock),
                format!("{:.2}", found.clock.ghz),
                per_second(&gpu.fused),
                published.map_or_else(none, per_second),
                o.variant.name.to_owned(),
                range(&o.run.frames_per_second()),
                ratio(&found.over_gpu(o, &gpu.fused)),
                published.map_or_else(none, |own| ratio(&found.over_gpu(o, own))),
            ]);
        }
    }
    say!("\n{rows}");
}

/// Gathering alone, by scene.
fn gathering(report: &Report<Modelled>) {
    let mut rows = tables::plain([
        "gathering alone",
        "GHz",
        "ms on the GPU",
        "ms on the unit",
        "speed-up",
        "the paper",
        "memory, mJ",
        "saved by less traffic",
        "the paper",
    ]);
    for found in &report.scenes {
        let (own, memory) = (&found.gathered, &found.gathered.memory);
        let (paper, _) = gathering_speed_up(&found.algorithm);
        rows.add_row([
            clock::marked(&found.scene, &found.clock),
            format!("{:.2}", found.clock.ghz),
            range(&own.gpu_ns.map(|ns| ns * 1e-6)),
            range(&own.unit_ns.map(|ns| ns * 1e-6)),
            times(&own.gpu_ns, &own.unit_ns),
            paper.to_string(),
            format!(
                "{:.3} > {:.3}",
                memory.before_pj * 1e-9,
                memory.after_pj * 1e-9
            ),
            percent(memory.traffic_share()),
            percent(Some(BY_TRAFFIC)),
        ]);
    }
    say!("\n{rows}");
}
