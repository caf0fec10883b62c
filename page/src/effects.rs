//! The checklist of effects.

use maud::{Markup, html};
use serde_json::Value;

use super::tables::table;
use super::value::{Form, Place};

/// What leaving an effect out saves in hardware: the key, the heading and the form of its figure.
const SAVED: [(&str, &str, Form); 3] = [
    ("area_mm2", "area saved, mm² at 12 nm", Form::Small),
    ("cycles", "cycles saved", Form::Count),
    ("energy_uj", "energy saved, µJ", Form::Small),
];

/// The effects that the scene and its path call for, with the hardware that leaving one out saves.
pub(super) fn effects(found: &Place<'_>) -> Markup {
    if let Some(why) = found.unknown() {
        return html! { p { "-: " (why) } };
    }
    let mut notes = Notes::default();
    let mut header = vec!["effect", "called for", "evidence", "done by", "its cycles"];
    header.extend(SAVED.iter().map(|(_, heading, _)| *heading));
    let all = found.get("effects").all();
    let rows: Vec<_> = all.iter().map(|own| row(own, &mut notes)).collect();
    let left = left_out(found);
    html! {
        (table("Effects that the scene and its path call for", &header, rows))
        (notes.list())
        @if left.is_empty() {
            p { "The hardware has no part that this scene does not call for." }
        } @else {
            (table("Parts of the hardware that the scene does not call for", &["unit", "field", "needed", "configured", "reason"], left))
        }
    }
}

fn row(own: &Place<'_>, notes: &mut Notes) -> Vec<Markup> {
    let is = own.get("called_for").json() == &Value::Bool(true);
    let cost = own.get("cost");
    let mut row = vec![
        html! { (own.get("name").text()) @if !own.get("degree").is_null() { " " (own.get("degree").number(Form::Count)) } },
        html! { @if is { "✓ yes" } @else { "✗ no" } },
        html! { (own.get("evidence").text()) },
        html! { (cost.get("unit").text()) },
        known(&cost.get("cycles"), Form::Count),
    ];
    let saved = own.get("saving").get("hardware");
    row.extend(SAVED.iter().map(|(key, _, form)| {
        let figure = saved.get(key);
        if saved.is_null() {
            return html! { "-" sup { (notes.number("the scene calls for the effect: nothing is left out")) } };
        }
        let note = notes.number(figure.get("origin").text());
        html! { (known(&figure.get("value"), *form)) sup { (note) } }
    }));
    row
}

fn known(place: &Place<'_>, form: Form) -> Markup {
    match place.is_null() {
        true => html! { "-" },
        false => place.number(form),
    }
}

/// Parts of the hardware that the scene does not call for.
fn left_out(found: &Place<'_>) -> Vec<Vec<Markup>> {
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
    left.collect()
}

/// Origins of figures, each once; a letter refers to one.
#[derive(Default)]
struct Notes(Vec<String>);

impl Notes {
    fn number(&mut self, text: &str) -> String {
        let at = self.0.iter().position(|own| own == text);
        let at = at.unwrap_or_else(|| {
            self.0.push(text.to_owned());
            self.0.len() - 1
        });
        Self::letter(at)
    }

    /// a to z, then a to z with another a before.
    fn letter(at: usize) -> String {
        let last = char::from(b'a' + (at % 26) as u8);
        "a".repeat(at / 26) + &last.to_string()
    }

    fn list(&self) -> Markup {
        html! {
            @if !self.0.is_empty() {
                ul class="notes" {
                    @for (at, text) in self.0.iter().enumerate() {
                        li { sup { (Self::letter(at)) } " " (text) }
                    }
                }
            }
        }
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
