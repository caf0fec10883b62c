//! Plot of errors and clocks.

use potamoi_explore::accuracy::{CostQuality, front};
use potamoi_explore::exponential::{Method, Peer};
use potamoi_plots::look_of;
use serde_json::{Value, json};

use super::PAPER;
use crate::charts::{Labels, labelled, logarithmic, number};

/// Width and height in pixels.
const SIZE: [f64; 2] = [760.0, 560.0];

/// Largest error over all inputs, by clocks a result; peers, which have no clocks, as levels.
pub(super) fn spec(methods: &[Method], peers: &[Peer]) -> Value {
    let errors = methods.iter().map(|m| m.max_ulp);
    let all = errors.chain(peers.iter().map(|p| p.max_ulp));
    let (low, high) = all.fold((f64::MAX, 0.0), |(low, high): (f64, f64), v| {
        (low.min(v), high.max(v))
    });
    let (low, high) = (low / 1.5, high * 1.5);
    let slow = 1.08 * methods.iter().map(|m| m.clocks).fold(0.0, f64::max);
    let places: Vec<CostQuality> = (methods.iter())
        .map(|m| CostQuality {
            cost: m.clocks,
            quality: -m.max_ulp,
        })
        .collect();
    let kept: Vec<Value> = front(&places)
        .into_iter()
        .map(|i| json!({ "clocks": places[i].cost, "ulp": -places[i].quality }))
        .collect();
    let mut families: Vec<&str> = methods.iter().map(|m| m.family).collect();
    families.dedup();
    let points: Vec<Value> = (methods.iter())
        .map(
            |m| json!({ "clocks": m.clocks, "ulp": m.max_ulp, "family": m.family, "name": m.name }),
        )
        .collect();
    let levels: Vec<Value> = (peers.iter())
        .map(|p| json!({ "name": p.name, "ulp": p.max_ulp, "clocks": 0, "end": slow }))
        .collect();
    let mut x = number("clocks", "clocks from one result of a lane to its next");
    x["scale"] = json!({ "domain": [0, slow], "nice": false });
    let title = "largest error in units of the last place of U0.16";
    let y = logarithmic("ulp", title, [low, high]);
    // What is not built has levels of grey and the names beside them.
    let down = |ulp: f64| SIZE[1] * (high / ulp).ln() / (high / low).ln();
    let names = peers
        .iter()
        .map(|p| ([SIZE[0], down(p.max_ulp)], p.name.to_owned()));
    let [leaders, names] = labelled(&Labels::right_of(names.collect(), SIZE));
    let by_family = |of: usize| {
        let range: Vec<&str> = (0..families.len()).map(|at| look_of(at)[of]).collect();
        json!({
            "field": "family", "type": "nominal", "title": null,
            "scale": { "domain": families, "range": range },
            "legend": { "orient": "bottom", "columns": 4 },
        })
    };
    let paper: Vec<&Value> = points.iter().filter(|own| own["name"] == PAPER).collect();
    json!({
        "title": {
            "text": "exponentials: largest error over all inputs, and clocks a result",
            "subtitle": "line: front; ring: the paper's unit; levels: programs and tables of others, without clocks",
        },
        "width": SIZE[0],
        "height": SIZE[1],
        "layer": [
            {
                "data": { "values": levels },
                "mark": { "type": "rule", "opacity": 0.35, "strokeDash": [4, 3] },
                "encoding": { "x": x, "x2": { "field": "end" }, "y": y },
            },
            {
                "data": { "values": kept },
                "mark": { "type": "line", "opacity": 0.7 },
                "encoding": { "x": x, "y": y },
            },
            {
                "data": { "values": points },
                "mark": { "type": "point", "filled": true, "size": 80 },
                "encoding": {
                    "x": x, "y": y, "color": by_family(0), "shape": by_family(1),
                    "tooltip": [
                        { "field": "name" }, number("clocks", "clocks"), number("ulp", "largest error, ulp"),
                    ],
                },
            },
            {
                "data": { "values": paper },
                "mark": { "type": "point", "size": 320, "strokeWidth": 2, "filled": false },
                "encoding": { "x": x, "y": y },
            },
            leaders,
            names,
        ],
    })
}
