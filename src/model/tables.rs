//! Tables for people.

use comfy_table::{CellAlignment, Table, presets};
use potamoi_sim::soc::{Outcome, System};

use super::report::{Found, Report};
use crate::say::say;

fn table(header: &[&str]) -> Table {
    let mut table = Table::new();
    table.load_preset(presets::NOTHING).set_header(header);
    table
}

/// All columns but the first to the right.
fn aligned(mut table: Table) -> Table {
    table
        .column_iter_mut()
        .skip(1)
        .for_each(|c| c.set_cell_alignment(CellAlignment::Right));
    table
}

fn db(of: Option<f64>) -> String {
    of.map_or_else(|| "-".to_owned(), |db| format!("{db:.2}"))
}

pub(super) fn print(found: &Found, system: &System) {
    let options = &found.options;
    say!(
        "{} ({}), {} x {}, {} frames, window {}{}",
        found.scene,
        found.algorithm,
        found.size[0],
        found.size[1],
        options.frames,
        options.window,
        match found.was_kept {
            true => "; counted earlier",
            false => "",
        }
    );
    say!(
        "  units: {}, {} GHz; full frames are counted at the references' poses; {:.1} % of what targets show is rendered",
        found.preset.map_or_else(
            || "as configured".to_owned(),
            |name| format!("preset {name}")
        ),
        found.clock_ghz,
        100.0 * found.rendered_share
    );
    for scenario in found
        .outcomes
        .iter()
        .map(|o| o.scenario)
        .collect::<std::collections::BTreeSet<_>>()
    {
        let own: Vec<&Outcome> = found
            .outcomes
            .iter()
            .filter(|o| o.scenario == scenario)
            .collect();
        let mut speed = table(&[
            "",
            "frames/s",
            "ms a frame",
            "speed-up",
            "mJ a frame",
            "saving",
            "streamed MB",
            "random MB",
            "dB beside the model",
            "beside the truth",
        ]);
        for o in &own {
            let frames = o.frames as f64;
            speed.add_row([
                o.variant.name.to_owned(),
                format!("{:.2}", o.frames_per_second),
                format!("{:.2}", o.span_ns * 1e-6 / frames),
                format!("{:.2}", found.speed_up(o)),
                format!("{:.2}", o.energy.total_mj()),
                format!("{:.2}", found.saving(o)),
                format!(
                    "{:.2}",
                    (o.spent.streamed_bytes + o.spent.written_bytes) * 1e-6 / frames
                ),
                format!("{:.2}", o.spent.random_bytes * 1e-6 / frames),
                db(o.quality.model_db),
                db(o.quality.truth_db),
            ]);
        }
        say!("\n{scenario:?} rendering\n{}", aligned(speed));
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
            .filter(|s| own.iter().any(|o| o.stages.contains_key(s)))
            .collect();
        let mut header = vec!["ms a frame: own work + waiting for bytes"];
        header.extend(&used);
        let mut times = table(&header);
        for o in &own {
            let mut row = vec![o.variant.name.to_owned()];
            row.extend(used.iter().map(|stage| {
                o.stages.get(stage).map_or_else(
                    || "-".to_owned(),
                    |t| format!("{:.2} + {:.2}", t.own_ns * 1e-6, t.memory_ns * 1e-6),
                )
            }));
            times.add_row(row);
        }
        say!("\n{}", aligned(times));
        let parts = own[0].energy.named().map(|(name, _)| name);
        let mut header = vec!["mJ a frame"];
        header.extend(parts);
        let mut energy = table(&header);
        for o in &own {
            let mut row = vec![o.variant.name.to_owned()];
            row.extend(o.energy.named().map(|(_, mj)| format!("{mj:.3}")));
            energy.add_row(row);
        }
        say!("\n{}", aligned(energy));
    }
    say!("\nenergy: {}", found.energy_origin);
    say!(
        "calibrated: the GPU's programs reach {} of its best for fields, {} for splats (potamoi model --calibrate); assumed: {} W at work, {} W idle",
        system.gpu.fields_efficiency,
        system.gpu.splats_efficiency,
        system.gpu.watts,
        system.gpu.idle_watts
    );
}

/// Speed-ups and savings of many scenes.
pub(super) fn side_by_side(report: &Report) {
    let Some(first) = report.scenes.first() else {
        return;
    };
    let columns: Vec<String> = first
        .outcomes
        .iter()
        .map(|o| format!("{} {:?}", o.variant.name, o.scenario).to_lowercase())
        .collect();
    let mut header = vec!["speed-up (saving)", "frames/s of the first"];
    header.extend(columns.iter().map(String::as_str));
    let mut rows = table(&header);
    for found in &report.scenes {
        let mut row = vec![
            found.scene.clone(),
            format!("{:.2}", found.outcomes[0].frames_per_second),
        ];
        row.extend(
            found
                .outcomes
                .iter()
                .map(|o| format!("{:.2} ({:.2})", found.speed_up(o), found.saving(o))),
        );
        rows.add_row(row);
    }
    say!("{}", aligned(rows));
}
