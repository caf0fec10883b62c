//! Plots: energy by part, and a roofline.

use potamoi_explore::system::Modelled;
use potamoi_plots::look_of;
use potamoi_system::system_model::{Memory, Outcome, Scenario, System};
use serde_json::{Value, json};

use crate::charts::{Labels, labelled, largest_parts, logarithmic, number, segments, stacked};

/// Width and height of the roofline in pixels.
const SIZE: [f64; 2] = [700.0, 400.0];

/// One bar a variant, stacked by part.
pub(crate) fn energy(found: &Modelled) -> Value {
    let bars: Vec<Vec<(&str, f64)>> = found.outcomes.iter().map(energies).collect();
    let parts = largest_parts(&bars);
    let of = |(own, bar): (&Outcome, &Vec<_>)| segments(&label(own), bar, &parts, "mJ");
    let all: Vec<Value> = found.outcomes.iter().zip(&bars).flat_map(of).collect();
    titled(
        stacked(&all, &parts, "mJ a frame, mean of both bounds"),
        format!(
            "{}, {} x {}: energy of a frame by part{}",
            found.scene,
            found.size[0],
            found.size[1],
            not_known(found)
        ),
    )
}

fn titled(mut spec: Value, title: String) -> Value {
    spec["title"] = title.into();
    spec
}

/// Energy by part, the geometric mean of both bounds of the GPU's kernels; 0 where it is not known,
/// which the title says.
fn energies(of: &Outcome) -> Vec<(&'static str, f64)> {
    let [max, sum] = [&of.run.max, &of.run.sum].map(|run| run.energy.named());
    let both = max.into_iter().zip(sum);
    both.map(|((name, max), (_, sum))| (name, (max.zip(sum)).map_or(0.0, |(a, b)| (a * b).sqrt())))
        .collect()
}

/// Blocks without energy, for the title.
fn not_known(found: &Modelled) -> String {
    let blocks: Vec<_> = (found.energy_unknown.iter())
        .map(|own| own.block.as_str())
        .collect();
    match blocks.is_empty() {
        true => String::new(),
        false => format!("; without {}, not known", blocks.join(" and ")),
    }
}

/// Roofline: multiplications a second over multiplications a byte of memory, below the limits of
/// array and memory.
pub(super) fn roofline(found: &Modelled, system: &System) -> Value {
    let memory = Memory::of(system);
    let array = f64::from(system.array_rows) * f64::from(system.array_columns) * found.clock_ghz;
    let bandwidth = 1.0 / memory.streamed().ns;
    let places: Vec<(f64, f64)> = (found.outcomes.iter())
        .map(|o| {
            let spent = &o.run.max.spent;
            let bytes = spent.streamed_bytes + spent.written_bytes + spent.random_bytes;
            let macs = spent.done.macs as f64;
            (macs / bytes.max(1.0), macs / o.run.span_ns().mid())
        })
        .collect();
    let seen = || places.iter().filter(|(x, y)| *x > 0.0 && *y > 0.0);
    let (left, low) = seen().fold((array / bandwidth, array), |(x, y), own| {
        (x.min(own.0), y.min(own.1))
    });
    let right = seen().map(|p| p.0).fold(array / bandwidth, f64::max);
    // Whole decades.
    let down = |v: f64| 10f64.powf((v / 1.5).log10().floor());
    let up = |v: f64| 10f64.powf((v * 1.5).log10().ceil());
    let ([left, low], [right, high]) = ([left, low].map(down), [right, array].map(up));
    let corners = [left.max(low / bandwidth), array / bandwidth, right];
    let roof: Vec<Value> = (corners.iter())
        .map(|x| json!({ "x": x, "y": (x * bandwidth).min(array) }))
        .collect();
    // A colour and a shape a variant, hollow where references are from afar.
    let same = |a: &Outcome, b: &Outcome| a.scenario == b.scenario;
    let mut points = vec![];
    for (i, (o, (x, y))) in found.outcomes.iter().zip(&places).enumerate() {
        if *x > 0.0 && *y > 0.0 {
            let number = found.outcomes[..i].iter().filter(|b| same(o, b)).count();
            points.push(json!({
                "of": label(o), "x": x, "y": y, "colour": look_of(number)[0],
                "shape": look_of(number)[1], "fill": u8::from(o.scenario == Scenario::Local),
            }));
        }
    }
    let x = logarithmic("x", "multiplications a byte of memory", [left, right]);
    let y = logarithmic("y", "multiplications a nanosecond", [low, high]);
    let places: Vec<([f64; 2], String)> = (points.iter())
        .map(|own| {
            let of = |field: &str| own[field].as_f64().unwrap_or(1.0).log10();
            let across = (of("x") - left.log10()) / (right / left).log10();
            let down = (high.log10() - of("y")) / (high / low).log10();
            let text = own["of"].as_str().unwrap_or_default().to_owned();
            ([across * SIZE[0], down * SIZE[1]], text)
        })
        .collect();
    let marks: Vec<_> = places.iter().map(|(at, _)| *at).collect();
    let names = labelled(&Labels::beside(places, &marks, SIZE));
    let asis = |field: &str| json!({ "field": field, "type": "nominal", "scale": null });
    json!({
        "title": {
            "text": format!(
                "{}, {} x {}: multiplications against what the array and memory allow",
                found.scene, found.size[0], found.size[1]
            ),
            "subtitle": format!(
                "line: array {array:.0} a ns, memory {bandwidth:.1} GB/s; hollow: references from afar"
            ),
        },
        "width": SIZE[0],
        "height": SIZE[1],
        "layer": [
            {
                "data": { "values": roof },
                "mark": { "type": "line", "strokeWidth": 2 },
                "encoding": { "x": x, "y": y },
            },
            {
                "data": { "values": points },
                "mark": { "type": "point", "size": 120, "strokeWidth": 2 },
                "encoding": {
                    "x": x, "y": y,
                    "color": asis("colour"), "fill": asis("colour"), "shape": asis("shape"),
                    "fillOpacity": { "field": "fill", "type": "quantitative", "scale": null },
                    "tooltip": [
                        { "field": "of" },
                        number("x", "multiplications a byte"),
                        number("y", "multiplications a ns"),
                    ],
                },
            },
            names[0],
            names[1],
        ],
    })
}

pub(crate) fn label(of: &Outcome) -> String {
    match of.scenario {
        Scenario::Local => of.variant.name.to_owned(),
        Scenario::Remote => format!("{} remote", of.variant.name),
    }
}
