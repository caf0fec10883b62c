//! Every value of the page is the document's.
#![allow(clippy::unwrap_used, clippy::panic)]

use std::collections::BTreeSet;

use serde_json::{Value, json};

use super::value::Form;
use super::{Images, page};

/// A document with a machine that has all parts, one that is refused, and unknown parts.
fn document() -> Value {
    let both = |max: f64, sum: f64| json!({ "max": max, "sum": sum });
    let free = json!({
        "frames_per_second": both(212.0, 198.0), "frame_ms": both(4.72, 5.05), "mj": both(1.91, 2.02),
        "work_ms": [["vector unit", 3.3]], "parts_mj": [["GPU", 0.0]],
    });
    let more = json!({
        "preset": "paper", "configuration": "0123abcd4567", "arxiv": "2408.06608",
        "clock": { "blocks": [{ "block": "vector_unit", "ps": 1612.5, "from": "synthesis in asap7" }] },
        "area": { "blocks": [
            { "block": "vector_unit", "count": 1, "logic_mm2": 0.0123, "memories_mm2": 0.0, "from": "synthesis in asap7" },
        ] },
        "pictures": {
            "float": { "id": "s0-m0-float" }, "hardware": { "id": "s0-m0-hardware" }, "error": { "id": "s0-m0-error" },
            "scale": 0.0078125, "largest": 0.0231,
            "beside_reference": { "db": 61.237 }, "beside_float": { "db": null },
        },
        "proof": {
            "units": [
                { "unit": "gathering unit", "of": "feature vectors", "compared": 1234, "all": 56789, "share": 0.02173 },
                { "unit": "vector unit", "of": "elements", "compared": 0, "all": 0, "share": null },
            ],
            "not_checked": ["3 of 8 things"],
        },
        "variants": [{
            "name": "fs+gu", "frames_per_second": both(34.2, 28.9), "frame_ms": both(29.2, 34.6),
            "mj": both(310.0, 344.4), "speed_up": both(1.5, 1.7), "saving": null, "full_db": null,
            "work_ms": [["GPU", 21.7], ["vector unit", 3.3]], "parts_mj": [["GPU", 301.5]],
            "if_gpu_were_free": free,
        }],
        "accuracy": { "unknown": "no tool" },
        "effects": { "effects": [
            {
                "name": "sh", "degree": 2, "called_for": true, "evidence": "17 coefficients",
                "cost": { "unit": "vector unit", "cycles": 4711, "wall_ms": 8.88 },
                "saving": { "hardware": null },
            },
            { "name": "warping", "degree": null, "called_for": false, "evidence": "none", "cost": {}, "saving": { "hardware": {
                "area_mm2": { "value": 0.0042, "origin": "synthesised" }, "cycles": { "value": 0.0, "origin": "cycle models" },
                "energy_uj": { "value": null, "origin": "not synthesised" },
            } } },
        ], "units": [{ "unit": "vector_unit", "left_out": [
            { "field": "vu.exp", "left": 4, "asked": 16, "reason": "all are opaque" },
        ] }] },
        "hard_cases": {
            "cases": [
                { "name": "fog", "part": "compositing", "state": "measured", "passes": true, "error": 0.75, "bound": 1.5,
                  "unit": "ulp", "naive": "16 bits", "naive_error": 77.5, "derivation": "half a unit" },
                { "name": "needle", "part": "splats", "state": "does-not-apply", "reason": "no splats" },
            ],
            "pictures": [], "no_pictures": "no splats",
            "scene": [{ "name": "finite", "state": "fails", "evidence": "one is not", "naive": null }], "no_scene": null,
        },
        "paper": [{
            "figure": "potamoi: speed-up", "unit": "times", "paper": "53.1", "ours": both(2.5, 3.1), "reason": "GPUs",
        }],
    });
    let figures = json!({
        "frames_per_second": both(34.2, 28.9), "clock_ghz": 0.6201, "clock_origin": "synthesised",
        "mj": both(310.0, 344.4), "quality": { "beside": "truth", "db": 61.237 }, "units_mm2": 0.2541,
        "mm2": 2.377, "bottleneck": { "max": ["GPU", 0.781], "sum": ["memory", null] },
        "free_units_frames_per_second": both(40.0, 33.0), "variant": "fs+gu",
        "gpu_alone_frames_per_second": both(20.0, 18.0),
        "unknown": [{ "block": "splat_unit", "why": "not synthesised" }],
    });
    json!({
        "version": "0.1.0",
        "libraries": [{ "name": "vega", "version": "6.4.0", "licence": "BSD-3-Clause", "sha256": "8f6a" }],
        "scenes": [{
            "name": "playbot_31k", "hash": "fe12", "size": [64, 48],
            "reference": { "kind": "truth" }, "reference_picture": { "id": "s0-reference" },
            "machines": [
                { "machine": "paper", "figures": figures, "more": more },
                { "machine": "<other>", "figures": { "refused": "it has no lanes" } },
            ],
        }],
        "plots": {},
        "provenance": [{ "figure": "clock", "origin": "synthesis", "how": "at 12 nm", "command": "potamoi model" }],
        "not_checked": ["a </script> & more"],
    })
}

/// What lies between two marks, and the rest.
fn between<'a>(text: &'a str, from: &str, to: &str) -> Option<(&'a str, &'a str)> {
    let (_, rest) = text.split_once(from)?;
    rest.split_once(to)
}

fn attribute<'a>(tag: &'a str, name: &str) -> &'a str {
    between(tag, &format!(" {name}=\""), "\"").unwrap().0
}

/// All strings and keys of a document.
fn texts(of: &Value, into: &mut BTreeSet<String>) {
    match of {
        Value::String(own) => {
            into.insert(own.clone());
        }
        Value::Array(all) => all.iter().for_each(|own| texts(own, into)),
        Value::Object(all) => all.iter().for_each(|(key, own)| {
            into.insert(key.clone());
            texts(own, into);
        }),
        _ => {}
    }
}

/// The contents of the page without plots, pictures, scripts and styles, and with the numbers of the
/// document taken out, each of which was compared.
fn rest_of(main: &str, document: &Value) -> (String, usize) {
    let (mut rest, mut left, mut count) = (main, String::new(), 0);
    while let Some((before, after)) = rest.split_once("<data") {
        left += before;
        let (tag, after) = after.split_once('>').unwrap();
        let (shown, after) = after.split_once("</data>").unwrap();
        let place = document.pointer(attribute(tag, "data-of")).unwrap();
        assert_eq!(place.to_string(), attribute(tag, "value"));
        let form = Form::named(attribute(tag, "data-as")).unwrap();
        assert_eq!(form.text(place.as_f64().unwrap()), shown, "{tag}");
        (rest, count) = (after, count + 1);
    }
    left += rest;
    let mut text = String::new();
    let mut is_tag = false;
    for c in left.chars() {
        match c {
            '<' => is_tag = true,
            '>' => (is_tag, text) = (false, text + " "),
            c if !is_tag => text.push(c),
            _ => {}
        }
    }
    (text, count)
}

#[test]
fn every_number_of_the_page_is_the_document_s() {
    let document = document();
    let text = page(&document, &Images::new()).unwrap();
    let (main, _) = between(&text, "<main", "</main>").unwrap();
    let (rest, count) = rest_of(main, &document);
    assert!(count > 50, "{count}");
    let mut known = BTreeSet::new();
    texts(&document, &mut known);
    let words = rest.split(|c: char| !(c.is_alphanumeric() || "._".contains(c)));
    for word in words.filter(|own| own.contains(|c: char| c.is_ascii_digit())) {
        // The scale of errors begins at 0.
        let is_known = word == "0"
            || known
                .iter()
                .any(|own| own.contains(word.trim_end_matches('.')));
        assert!(is_known, "{word} is not of the document");
    }
    for shown in ["34.2", "2.2 %", "1,234", "61.24", "0.62", "0.008"] {
        assert!(main.contains(shown), "{shown}");
    }
}

#[test]
fn a_number_that_is_not_the_document_s_is_found() {
    let document = json!({ "a": 1.25 });
    let place = super::Place::root(&document).get("a");
    let good = place.number(Form::Short).into_string();
    assert_eq!(rest_of(&good, &document).1, 1);
    let wrong = good.replace(">1.25<", ">1.26<");
    assert!(std::panic::catch_unwind(|| rest_of(&wrong, &document)).is_err());
}

#[test]
fn text_of_users_is_escaped() {
    let text = page(&document(), &Images::new()).unwrap();
    assert!(text.contains("&lt;other&gt; is left out"));
    assert!(!text.contains("<other>"));
    assert!(text.contains(r#"a \u003c/script> & more"#));
}

#[test]
fn effects_have_the_hardware_saved_with_its_origin_and_none_of_the_simulator_s_figures() {
    let text = page(&document(), &Images::new()).unwrap();
    let (own, _) = between(&text, "id=\"effects\"", "</section>").unwrap();
    assert!(own.contains("0.004") && own.contains("4,711") && own.contains("synthesised"));
    assert!(!own.contains("8.88"), "{own}");
}

#[test]
fn hard_cases_have_their_verdicts_and_the_reasons_of_those_that_do_not_apply() {
    let text = page(&document(), &Images::new()).unwrap();
    let (own, _) = between(&text, "id=\"hard-cases\"", "</section>").unwrap();
    for word in [
        "✓ passes",
        "✗ fails",
        "- does not apply",
        "no splats",
        "77.500",
        "16 bits",
    ] {
        assert!(own.contains(word), "{word}: {own}");
    }
}
