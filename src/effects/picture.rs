//! Plot of effects: those called for, and the simulator time of each.

use potamoi_explore::effects::{Effects, FoundEffect};
use potamoi_plots::COLOURS;
use serde_json::{Value, json};

use super::report::cost_words;
use crate::charts::{GREY, name, number};

/// Widths in pixels of the longest bar, and of the space before the words beside it.
const WIDTH: u32 = 420;
const SPACE: u32 = 14;

/// One row an effect: wall time with it, its part of that time, and the spread of the pairs; beside
/// it, its cost in the hardware.
pub(super) fn spec(report: &Effects) -> Value {
    let rows: Vec<Value> = report.effects.iter().map(row).collect();
    let x = |field: &str| number(field, "ms of the simulator");
    let bar = |from: &str, to: &str, opacity: f64| {
        json!({
            "mark": { "type": "bar", "opacity": opacity },
            "encoding": { "x": x(from), "x2": { "field": to } },
        })
    };
    json!({
        "title": {
            "text": format!(
                "{}, {} x {}, {} frames: what is called for, and what it takes",
                report.scene, report.width, report.height, report.frames
            ),
            "subtitle": "light what was timed with the effect, dark its own, black the spread",
        },
        "data": { "values": rows },
        "width": WIDTH,
        "height": { "step": 30 },
        "encoding": {
            "y": {
                "field": "effect", "type": "nominal", "sort": null, "title": null,
            },
            "color": {
                "field": "is", "type": "nominal", "title": null,
                "scale": {
                    "domain": ["called for", "not called for"],
                    "range": [COLOURS[2], GREY],
                },
                "legend": { "orient": "bottom", "symbolOpacity": 1 },
            },
        },
        "layer": [
            bar("zero", "rest", 0.35),
            bar("rest", "with", 1.0),
            {
                "mark": { "type": "rule", "strokeWidth": 2 },
                "encoding": {
                    "x": x("least"), "x2": { "field": "most" }, "color": Value::Null,
                },
            },
            {
                "mark": { "type": "text", "align": "left" },
                "encoding": {
                    "x": { "value": WIDTH + SPACE },
                    "y": name("effect"),
                    "text": { "field": "words" },
                    "color": Value::Null,
                },
            },
        ],
    })
}

fn row(found: &FoundEffect) -> Value {
    let is = match found.called_for {
        true => "called for",
        false => "not called for",
    };
    let mut row =
        json!({ "effect": found.title(), "is": is, "words": cost_words(found), "zero": 0 });
    if let Some(wall) = found.timed() {
        let own = wall.difference_ms.clamp(0.0, wall.with_ms);
        row["rest"] = (wall.with_ms - own).into();
        row["with"] = wall.with_ms.into();
        if let Some(spread) = wall.spread_ms {
            row["least"] = (wall.with_ms - spread).into();
            row["most"] = (wall.with_ms + spread).into();
        }
    }
    row
}
