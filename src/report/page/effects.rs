//! The checklist of effects.

use maud::{Markup, html};
use serde_json::Value;

use super::tables::table;
use super::value::{Form, Place};

/// Parts of an effect that hold what it takes and what leaving it out saves.
const GROUPS: [&str; 2] = ["cost", "saving"];
/// Figures of the simulator: none of the hardware.
const OF_SIMULATOR: &str = "wall";

/// The effects that the scene and its path call for; a column for each figure that the study has.
pub(super) fn effects(found: &Place<'_>) -> Markup {
    if let Some(why) = found.unknown() {
        return html! { p { "-: " (why) } };
    }
    let all = found.get("effects").all();
    let mut columns: Vec<Vec<String>> = vec![];
    for own in &all {
        for group in GROUPS {
            leaves(
                own.get(group).json(),
                &mut vec![group.to_owned()],
                &mut columns,
            );
        }
    }
    let names: Vec<String> = columns
        .iter()
        .map(|path| path.join(" ").replace('_', " "))
        .collect();
    let mut header = vec!["effect", "called for", "evidence"];
    header.extend(names.iter().map(String::as_str));
    let rows = all.iter().map(|own| {
        let is = own.get("called_for").json() == &Value::Bool(true);
        let mut row = vec![
            html! { (own.get("name").text()) @if !own.get("degree").is_null() { " " (own.get("degree").number(Form::Count)) } },
            html! { @if is { "✓ yes" } @else { "✗ no" } },
            html! { (own.get("evidence").text()) },
        ];
        row.extend(columns.iter().map(|path| {
            let place = path.iter().fold(own.clone(), |at, key| at.get(key));
            cell(&place)
        }));
        row
    });
    let units = found.get("units").all();
    let left = units.iter().flat_map(|unit| {
        let parts = unit.get("left_out").all().into_iter();
        parts.map(|part| {
            vec![
                html! { (unit.get("unit").text()) },
                html! { code { (part.get("field").text()) } },
                html! { (scalar(&part.get("left"))) },
                html! { (scalar(&part.get("asked"))) },
                html! { (part.get("reason").text()) },
            ]
        })
    });
    let left: Vec<_> = left.collect();
    html! {
        (table("Effects that the scene and its path call for", &header, rows.collect()))
        @if left.is_empty() {
            p { "The hardware has no part that this scene does not call for." }
        } @else {
            (table("Parts of the hardware that the scene does not call for", &["unit", "field", "needed", "configured", "reason"], left))
        }
    }
}

/// Paths of a group's figures that some effect has, each once; those of the simulator are left out.
fn leaves(of: &Value, path: &mut Vec<String>, columns: &mut Vec<Vec<String>>) {
    match of {
        Value::Object(fields) => {
            for (key, own) in fields
                .iter()
                .filter(|(key, _)| !key.starts_with(OF_SIMULATOR))
            {
                path.push(key.clone());
                leaves(own, path, columns);
                path.pop();
            }
        }
        Value::Null => {}
        _ if !columns.contains(path) => columns.push(path.clone()),
        _ => {}
    }
}

fn cell(place: &Place<'_>) -> Markup {
    let form = match place.json().is_u64() {
        true => Form::Count,
        false => Form::Small,
    };
    match place.json() {
        Value::Number(_) => place.number(form),
        _ => scalar(place),
    }
}

/// A text, a truth value or a number as it is written.
fn scalar(place: &Place<'_>) -> Markup {
    match place.json() {
        Value::Null => html! { "-" },
        Value::String(text) => html! { (text) },
        Value::Number(_) => place.number(Form::Short),
        other => html! { (other.to_string()) },
    }
}
