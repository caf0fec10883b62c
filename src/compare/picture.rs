//! The comparison as a picture: a group of bars a scene.

use potamoi_machines::{Comparison, Figures, Row};
use potamoi_plots::COLOURS;
use potamoi_system::system_model::AtBounds;
use serde_json::{Value, json};

use crate::charts::{GREY, SERIES, name, number};

/// Width of the longest bar in pixels.
const WIDTH: u32 = 600;

/// Bars from 0 to the lower bound, and lighter ones on to the higher; a group a scene.
pub(crate) fn spec(found: &Comparison) -> Value {
    let rates = groups(found, |own| Some(own.frames_per_second), true);
    let energies = groups(found, |own| own.mj, false);
    let mut all = panels(&rates, "frames a second");
    all.extend(panels(&energies, "millijoules a frame"));
    json!({
        "title": {
            "text": "machines on scenes",
            "subtitle": "full colour up to where no demands of a GPU kernel overlap, or all do; lighter up to the other",
        },
        "vconcat": all,
    })
}

fn groups(
    found: &Comparison,
    of: impl Fn(&Figures) -> Option<AtBounds<f64>>,
    has_gpus: bool,
) -> Vec<(String, Vec<Value>)> {
    let mut all = vec![];
    for rows in &found.scenes {
        let figures: Vec<&Figures> = rows.iter().filter_map(Row::figures).collect();
        let Some(first) = figures.first() else {
            continue;
        };
        let [width, height] = first.size;
        let scene = format!("{} ({}), {width} x {height}", first.scene, first.algorithm);
        let (mut group, mut known): (Vec<Value>, Vec<String>) = (vec![], vec![]);
        let mut bar = |name: String, of: Option<AtBounds<f64>>, colour: &str| {
            // Bars of one name would lie on one another.
            let name = match known.contains(&name) {
                true => format!("{name} ({})", known.len() + 1),
                false => name,
            };
            let mut own = json!({ "name": name, "colour": colour, "begin": 0 });
            let [low, high] = of.map_or([0.0; 2], |of| [of.low(), of.high()]);
            own["low"] = low.into();
            own["high"] = high.into();
            let words = |of| crate::bounds::tight(&of);
            own["words"] = of.map_or_else(|| "not known".to_owned(), words).into();
            group.push(own);
            known.push(name);
        };
        for (at, own) in figures.iter().enumerate() {
            let machine = super::table::shortened(&own.machine);
            let name = format!("{machine} at {:.2} GHz", own.clock_ghz);
            bar(name, of(own), COLOURS[at % SERIES]);
        }
        let mut gpus: Vec<&str> = vec![];
        for own in figures.iter().filter(|_| has_gpus) {
            if !gpus.contains(&&*own.gpu) {
                let alone = own.gpu_alone_frames_per_second;
                bar(format!("{} alone", own.gpu), Some(alone), GREY);
                gpus.push(&own.gpu);
            }
        }
        all.push((scene, group));
    }
    all
}

/// A plot a group, on one scale.
fn panels(groups: &[(String, Vec<Value>)], title: &str) -> Vec<Value> {
    let bars = groups.iter().flat_map(|(_, bars)| bars);
    let most = bars.filter_map(|bar| bar["high"].as_f64());
    let most = most.fold(f64::MIN_POSITIVE, f64::max);
    let panel = |(scene, bars): &(String, Vec<Value>)| panel(scene, bars, title, most);
    groups.iter().map(panel).collect()
}

fn panel(scene: &str, bars: &[Value], title: &str, most: f64) -> Value {
    let x = |field: &str| {
        let mut own = number(field, title);
        own["scale"] = json!({ "domain": [0, most] });
        own
    };
    let colour = json!({ "field": "colour", "type": "nominal", "scale": null });
    let bar = |from: &str, to: &str, opacity: f64| {
        json!({
            "mark": { "type": "bar", "fillOpacity": opacity, "strokeWidth": 1 },
            "encoding": {
                "x": x(from), "x2": { "field": to }, "color": colour, "stroke": colour,
                "tooltip": [{ "field": "name" }, { "field": "words", "title": title }],
            },
        })
    };
    json!({
        "title": format!("{scene}: {title}"),
        "data": { "values": bars },
        "width": WIDTH,
        "height": { "step": 26 },
        "encoding": { "y": name("name") },
        "layer": [
            bar("begin", "low", 1.0),
            bar("low", "high", 0.4),
            {
                "mark": { "type": "text", "align": "left", "dx": 6 },
                "encoding": { "x": x("high"), "text": { "field": "words" } },
            },
        ],
    })
}
