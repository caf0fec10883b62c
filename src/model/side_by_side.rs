//! Table of many scenes.

use potamoi_explore::system::{BY_TRAFFIC, Modelled, Paper, gathering_speed_up};
use potamoi_system::system_model::{Alone, AtBounds, Outcome, Scenario};

use super::bounds::{known, range, ratio};
use super::clock;
use super::report::Report;
use super::tables::{figure, percent, scenarios, times};
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
                    known(found.saving(o).as_ref())
                )
            }));
            rows.add_row(row);
        }
        let count = report.scenes.len() as f64;
        type Ratio = dyn Fn(&Modelled, &Outcome) -> Option<AtBounds<f64>>;
        let mean = |of: &Ratio, i: usize, is_geometric: bool| {
            let all = (report.scenes.iter()).map(|found| of(found, &found.outcomes[i]));
            let all: Vec<AtBounds<f64>> = all.collect::<Option<_>>()?;
            let all = || all.iter().copied();
            let mean = |own: fn(AtBounds<f64>) -> f64| match is_geometric {
                true => (all().map(|all| own(all).ln()).sum::<f64>() / count).exp(),
                false => all().map(own).sum::<f64>() / count,
            };
            Some(AtBounds {
                max: mean(|own| own.max),
                sum: mean(|own| own.sum),
            })
        };
        for (name, is_geometric) in [("mean", false), ("geometric mean", true)] {
            let mut row = vec![name.to_owned(), String::new(), String::new()];
            row.extend(own.iter().map(|i| {
                let speed_up = mean(&|found, o| Some(found.speed_up(o)), *i, is_geometric);
                let saving = mean(&|found, o| found.saving(o), *i, is_geometric);
                let speed_up = speed_up.map_or_else(String::new, |own| ratio(&own));
                format!("{speed_up} ({})", known(saving.as_ref()))
            }));
            rows.add_row(row);
        }
        let mut row = vec!["the paper's mean".to_owned(), String::new(), String::new()];
        row.extend(own.iter().map(|i| {
            let paper = Paper::of(&first.outcomes[*i], first.options.window);
            format!("{} ({})", figure(paper.speed_up), figure(paper.saving))
        }));
        rows.add_row(row);
        say!("\n{scenario:?} rendering\n{rows}");
    }
    alone(report);
    gathering(report);
}

/// The last variant beside the GPU alone, by scene.
fn alone(report: &Report<Modelled>) {
    let mut rows = tables::plain([
        "beside the GPU alone",
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
                found.scene.clone(),
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
            found.scene.clone(),
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
