//! Stacked bars.

use potamoi_plots::COLOURS;
use serde_json::{Value, json};

use super::{GREY, SERIES, name};

/// Bars below one another, whose segments add up: a segment has `of`, `part`, `value` and `words`.
/// Each has its part's name where that fits, so that no part is known by colour alone.
pub(crate) fn stacked(segments: &[Value], parts: &[String], title: &str) -> Value {
    let total = |of: &Value| -> f64 {
        let own = segments.iter().filter(|s| s["of"] == *of);
        own.filter_map(|s| s["value"].as_f64()).sum()
    };
    let most = segments.iter().map(|s| total(&s["of"]));
    let most = most.fold(f64::MIN_POSITIVE, f64::max);
    let mut begin = 0.0;
    let mut before = Value::Null;
    let mut placed: Vec<Value> = (segments.iter())
        .map(|segment| {
            if segment["of"] != before {
                (before, begin) = (segment["of"].clone(), 0.0);
            }
            let value = segment["value"].as_f64().unwrap_or(0.0);
            let mut own = segment.clone();
            let text = segment["part"].as_str().unwrap_or_default();
            let fits = value / most * BARS > LETTER * text.len() as f64 + 6.0;
            own["begin"] = begin.into();
            begin += value;
            own["end"] = begin.into();
            own["middle"] = (begin - 0.5 * value).into();
            own["label"] = if fits { text.into() } else { "".into() };
            own
        })
        .collect();
    // White letters on the dark blue, black ones on all others.
    for own in &mut placed {
        let is_dark = parts.first().is_some_and(|first| own["part"] == *first);
        own["ink"] = if is_dark { "#ffffff" } else { "#000000" }.into();
    }
    let colours: Vec<&str> = (parts.iter().zip(COLOURS.iter().cycle()))
        .map(|(part, colour)| if part == OTHERS { GREY } else { colour })
        .collect();
    let x = |field: &str| json!({ "field": field, "type": "quantitative", "title": title });
    json!({
        "data": { "values": placed },
        "width": BARS,
        "height": { "step": 34 },
        "encoding": { "y": name("of") },
        "layer": [
            {
                "mark": { "type": "bar", "stroke": "#ffffff", "strokeWidth": 1 },
                "encoding": {
                    "x": x("begin"),
                    "x2": { "field": "end" },
                    "color": {
                        "field": "part", "type": "nominal", "title": null,
                        "scale": { "domain": parts, "range": colours },
                        "legend": { "orient": "bottom", "columns": 4, "symbolType": "square" },
                    },
                    "tooltip": [
                        { "field": "of", "type": "nominal", "title": "of" },
                        { "field": "part", "type": "nominal", "title": "part" },
                        { "field": "words", "type": "nominal", "title": "value" },
                    ],
                },
            },
            {
                "mark": { "type": "text", "fontSize": 11 },
                "encoding": {
                    "x": x("middle"), "text": { "field": "label" },
                    "color": { "field": "ink", "type": "nominal", "scale": null },
                },
            },
        ],
    })
}

/// Widths in pixels of the longest stacked bar, and of a letter in it.
const BARS: f64 = 640.0;
const LETTER: f64 = 6.0;
/// Label of the group of smallest parts.
const OTHERS: &str = "all others";

/// The parts with the largest values, and the others together, as names; a bar is a list of parts by
/// name.
pub(crate) fn largest_parts(bars: &[Vec<(&str, f64)>]) -> Vec<String> {
    let mut all: Vec<(&str, f64)> = vec![];
    for (name, value) in bars.iter().flatten() {
        match all.iter_mut().find(|(known, _)| known == name) {
            Some(own) => own.1 += value,
            None => all.push((name, *value)),
        }
    }
    all.retain(|(_, value)| *value > 0.0);
    let mut sorted = all.clone();
    sorted.sort_by(|a, b| b.1.total_cmp(&a.1));
    let kept = |name: &str| sorted.iter().take(SERIES).any(|(own, _)| *own == name);
    let names = all.iter().filter(|(name, _)| kept(name));
    let mut names: Vec<String> = names.map(|(name, _)| (*name).to_owned()).collect();
    if sorted.len() > SERIES {
        names.push(OTHERS.to_owned());
    }
    names
}

/// Segments of a bar over such parts.
pub(crate) fn segments(of: &str, bar: &[(&str, f64)], parts: &[String], unit: &str) -> Vec<Value> {
    let own = |part: &String| {
        let all = bar.iter().filter(|(name, _)| match part == OTHERS {
            true => parts.iter().all(|known| known != name),
            false => part == name,
        });
        all.map(|(_, value)| value).sum::<f64>()
    };
    let segment = |part: &String| {
        let value = own(part);
        json!({ "of": of, "part": part, "value": value, "words": format!("{value:.3} {unit}") })
    };
    parts.iter().map(segment).collect()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use potamoi_plots::{Ink, Renderer};

    use super::*;

    #[test]
    fn small_parts_are_put_together_and_nothing_is_lost() {
        let names: Vec<String> = (0..9).map(|i| format!("part {i}")).collect();
        let bar: Vec<(&str, f64)> = (names.iter().zip(1..))
            .map(|(name, value)| (name.as_str(), f64::from(value)))
            .collect();
        let parts = largest_parts(std::slice::from_ref(&bar));
        assert_eq!(parts.len(), 8);
        assert_eq!((&*parts[0], &*parts[7]), ("part 2", OTHERS));
        let all = segments("one", &bar, &parts, "ms");
        let sum: f64 = all.iter().map(|s| s["value"].as_f64().unwrap()).sum();
        assert_eq!(sum, 45.0);
        assert_eq!(all[7]["value"], 3.0);
        let spec = stacked(&all, &parts, "ms");
        assert_eq!(spec["data"]["values"][7]["end"], 45.0);
        assert!(Renderer::new().unwrap().svg(&spec, Ink::File).is_ok());
    }
}
