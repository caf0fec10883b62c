//! Table of many scenes.

use potamoi_explore::system::{BY_TRAFFIC, Modelled, Paper, gathering_speed_up};
use potamoi_system::system_model::Outcome;

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
            "frames/s of the baseline".to_owned(),
        ];
        header.extend(
            own.iter()
                .map(|i| first.outcomes[*i].variant.name.to_owned()),
        );
        let mut rows = tables::plain(header);
        for found in &report.scenes {
            let mut row = vec![
                found.scene.clone(),
                format!("{:.2}", found.outcomes[at].run.frames_per_second),
            ];
            row.extend(own.iter().map(|i| {
                let o = &found.outcomes[*i];
                format!("{:.2} ({:.2})", found.speed_up(o), found.saving(o))
            }));
            rows.add_row(row);
        }
        let count = report.scenes.len() as f64;
        let mean = |of: &dyn Fn(&Modelled, &Outcome) -> f64, i: usize, is_geometric: bool| {
            let all = report
                .scenes
                .iter()
                .map(|found| of(found, &found.outcomes[i]));
            match is_geometric {
                true => (all.map(f64::ln).sum::<f64>() / count).exp(),
                false => all.sum::<f64>() / count,
            }
        };
        for (name, is_geometric) in [("mean", false), ("geometric mean", true)] {
            let mut row = vec![name.to_owned(), String::new()];
            row.extend(own.iter().map(|i| {
                let speed_up = mean(&|found, o| found.speed_up(o), *i, is_geometric);
                let saving = mean(&|found, o| found.saving(o), *i, is_geometric);
                format!("{speed_up:.2} ({saving:.2})")
            }));
            rows.add_row(row);
        }
        let mut row = vec!["the paper's mean".to_owned(), String::new()];
        row.extend(own.iter().map(|i| {
            let paper = Paper::of(&first.outcomes[*i], first.options.window);
            format!("{} ({})", figure(paper.speed_up), figure(paper.saving))
        }));
        rows.add_row(row);
        say!("\n{scenario:?} rendering\n{rows}");
    }
    gathering(report);
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
            format!("{:.3}", own.gpu_ns * 1e-6),
            format!("{:.3}", own.unit_ns * 1e-6),
            times(own.gpu_ns, own.unit_ns),
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
