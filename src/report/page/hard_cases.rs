//! The strip of hard cases.

use maud::{Markup, html};
use serde_json::Value;

use super::tables::table;
use super::value::{Form, Place};

/// The cases of the given document, a column for each field that one has.
pub(super) fn hard_cases(found: &Place<'_>) -> Markup {
    if found.is_null() {
        return html! {
            p { "-: no hard cases were run on this configuration. " code { "--hard-cases FILE" } " adds those of a JSON file. docs/explanation/hard-cases.md has those of the presets, which the tests hold." }
        };
    }
    let cases = found.get("cases").all();
    let mut keys: Vec<&str> = vec![];
    for (key, own) in cases
        .iter()
        .filter_map(|own| own.json().as_object())
        .flatten()
    {
        if !keys.contains(&key.as_str()) && !own.is_object() && !own.is_array() {
            keys.push(key);
        }
    }
    let names: Vec<String> = keys.iter().map(|own| own.replace('_', " ")).collect();
    let header: Vec<&str> = names.iter().map(String::as_str).collect();
    let rows = cases.iter().map(|own| {
        let cell = |key: &&str| {
            let place = own.get(key);
            match place.json() {
                Value::Number(_) => place.number(Form::Small),
                Value::String(text) => html! { (text) },
                Value::Bool(true) => html! { "✓ yes" },
                Value::Bool(false) => html! { "✗ no" },
                _ => html! { "-" },
            }
        };
        keys.iter().map(cell).collect()
    });
    html! { (table("Hard cases on this configuration", &header, rows.collect())) }
}
