//! Plots of the page.

use potamoi_explore::accuracy::Sweep;
use potamoi_machines::Comparison;
use potamoi_plots::{Ink, look::dressed};
use serde_json::{Value, json};

use super::document::VariantFound;
use crate::charts::{largest_parts, number, segments, stacked};
use crate::{compare, cost};

/// Machines beside one another, as `compare --plot` draws them.
pub(super) fn comparison(found: &Comparison) -> Value {
    dressed(&compare::picture::spec(found), Ink::Page)
}

/// Quality over time by knob, as `cost --plot` draws it; a knob can be picked.
pub(super) fn accuracy(sweep: &Sweep) -> Vec<(&'static str, Value)> {
    let panels = cost::pictures::panels(sweep).into_iter();
    panels
        .map(|(beside, mut spec)| {
            spec["params"] = json!([{ "name": "knob", "value": "all" }]);
            for layer in spec["layer"].as_array_mut().into_iter().flatten() {
                let has_knobs = layer["data"]["values"][0]["knob"].is_string();
                if has_knobs {
                    let full = layer["mark"]["opacity"].as_f64().unwrap_or(1.0);
                    layer["encoding"]["opacity"] = json!({
                        "condition": { "test": "knob == 'all' || datum.knob == knob", "value": full },
                        "value": 0.06,
                    });
                }
            }
            (beside, dressed(&spec, Ink::Page))
        })
        .collect()
}

/// Time and energy by variant, each beside the same with a GPU that takes none.
pub(super) fn variants(all: &[VariantFound]) -> [Value; 2] {
    let of = |own: &[(&'static str, f64)]| own.to_vec();
    let bars = |times: bool| -> Vec<(String, Vec<(&'static str, f64)>)> {
        let both = all.iter().map(|own| match times {
            true => [of(&own.work_ms), of(&own.if_gpu_were_free.work_ms)],
            false => [of(&own.parts_mj), of(&own.if_gpu_were_free.parts_mj)],
        });
        let named = all.iter().zip(both);
        named
            .flat_map(|(own, [plain, free])| {
                [
                    (own.name.to_owned(), plain),
                    (format!("{}, GPU free", own.name), free),
                ]
            })
            .collect()
    };
    [(true, "ms"), (false, "mJ")].map(|(times, unit)| {
        let bars = bars(times);
        let values: Vec<_> = bars.iter().map(|(_, own)| own.clone()).collect();
        let parts = largest_parts(&values);
        let rows = bars
            .iter()
            .flat_map(|(name, own)| segments(name, own, &parts, unit));
        let rows: Vec<Value> = rows.collect();
        let title = match times {
            true => "ms of work a frame; tick: ms from frame to frame",
            false => "mJ a frame",
        };
        let mut spec = stacked(&rows, &parts, title);
        if times {
            frames(&mut spec, all, title);
        }
        dressed(&spec, Ink::Page)
    })
}

/// Adds the time from frame to frame as a tick: work overlaps, so that bars may be longer.
fn frames(spec: &mut Value, all: &[VariantFound], title: &str) {
    let ticks: Vec<Value> = (all.iter())
        .flat_map(|own| {
            [
                json!({ "of": own.name, "ms": own.frame_ms.mid() }),
                json!({
                    "of": format!("{}, GPU free", own.name), "ms": own.if_gpu_were_free.frame_ms.mid(),
                }),
            ]
        })
        .collect();
    let layer = json!({
        "data": { "values": ticks },
        "mark": { "type": "tick", "thickness": 3, "color": "currentColor", "height": 26 },
        "encoding": { "x": number("ms", title) },
    });
    if let Some(layers) = spec["layer"].as_array_mut() {
        layers.push(layer);
    }
}
