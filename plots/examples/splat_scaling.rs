//! Draws the rows that the example `splat_scaling` of `potamoi-scene` prints: from standard input to
//! standard output, as SVG.
#![allow(missing_docs)]

use std::error::Error;

use potamoi_plots::{COLOURS, Ink, Renderer, SHAPES};
use serde_json::{Value, json};

/// What changes, its column, and the title of its axis.
const AXES: [(&str, usize, &str); 3] = [
    ("Gaussians", 1, "Gaussians"),
    ("pixels", 2, "pixels on a side"),
    ("threads", 3, "threads"),
];
/// Columns of times, and their names.
const TIMES: [(usize, &str); 2] = [(4, "elapsed"), (5, "processor")];

fn main() -> Result<(), Box<dyn Error>> {
    let text = std::io::read_to_string(std::io::stdin())?;
    let rows: Vec<Vec<&str>> = text.lines().map(|line| line.split(',').collect()).collect();
    let mut plots = vec![];
    for (changed, column, title) in AXES {
        let mut values: Vec<Value> = vec![];
        for row in rows.iter().filter(|row| row.first() == Some(&changed)) {
            for (time, name) in TIMES {
                let [x, y] =
                    [column, time].map(|at| row.get(at).copied().unwrap_or("").parse::<f64>());
                values.push(json!({ "x": x?, "ms": y?, "time": name }));
            }
        }
        let names = TIMES.map(|own| own.1);
        let by = |range: &[&str]| {
            json!({
                "field": "time", "type": "nominal", "title": null,
                "scale": { "domain": names, "range": range[..2] },
                "legend": { "orient": "bottom" },
            })
        };
        let scale = if changed == "threads" {
            "linear"
        } else {
            "log"
        };
        let ticks: Vec<Value> = (values.iter().step_by(2))
            .map(|own| own["x"].clone())
            .collect();
        plots.push(json!({
            "width": 240,
            "height": 260,
            "data": { "values": values },
            "mark": { "type": "line", "point": { "filled": true, "size": 60 } },
            "encoding": {
                "x": {
                    "field": "x", "type": "quantitative", "title": title,
                    "scale": { "type": scale, "nice": false },
                    "axis": { "values": ticks, "format": "~s" },
                },
                "y": {
                    "field": "ms", "type": "quantitative", "title": "milliseconds a frame",
                    "scale": { "type": if scale == "log" { "log" } else { "linear" } },
                },
                "color": by(&COLOURS), "shape": by(&SHAPES),
            },
        }));
    }
    let spec = json!({
        "title": "a float frame of splats, by Gaussians, pixels and threads",
        "hconcat": plots,
    });
    println!("{}", Renderer::new()?.svg(&spec, Ink::File)?);
    Ok(())
}
