//! Hard cases: a strip with a mark for each, and a table of what was found.

use maud::{Markup, html};

use super::tables::table;
use super::value::{Form, Place};

/// Hard cases of a machine on a scene.
pub(super) fn hard_cases(found: &Place<'_>) -> Markup {
    let cases = found.get("cases").all();
    let checks: Vec<_> = ["pictures", "scene"]
        .iter()
        .flat_map(|part| found.get(part).all())
        .collect();
    let marks = cases.iter().chain(&checks);
    let header = [
        "case",
        "part",
        "verdict",
        "ours",
        "at most",
        "unit",
        "obvious form",
        "its error",
        "bound from",
    ];
    let none = [found.get("no_pictures"), found.get("no_scene")];
    html! {
        ul class="strip" aria-label="Verdict of each hard case" {
            @for own in marks {
                @let (mark, word) = verdict(own);
                li class=(word) title=(own.get("name").text()) { (mark) " " (own.get("name").text()) }
            }
        }
        (table("Hard cases with this configuration, ours beside the obvious form", &header, cases.iter().map(row).collect()))
        @if !checks.is_empty() {
            (table(
                "Pictures of hard scenes, and this scene",
                &["case", "verdict", "evidence", "obvious form"],
                checks.iter().map(check).collect(),
            ))
        }
        @for why in none.iter().filter(|own| !own.is_null()) { p { "-: " (why.text()) } }
    }
}

/// A mark and a word for what was found.
fn verdict(own: &Place<'_>) -> (&'static str, &'static str) {
    match (own.get("state").text(), own.get("passes").json().as_bool()) {
        ("measured", Some(true)) | ("passes", _) => ("✓", "passes"),
        ("does-not-apply", _) => ("-", "does not apply"),
        _ => ("✗", "fails"),
    }
}

fn row(own: &Place<'_>) -> Vec<Markup> {
    let (mark, word) = verdict(own);
    let is_measured = own.get("state").text() == "measured";
    let figure = |key: &str| match own.get(key).json().as_f64() {
        None if is_measured => html! { "no number" },
        None => html! { "-" },
        Some(value) if value.fract() == 0.0 => own.get(key).number(Form::Count),
        Some(_) => own.get(key).number(Form::Small),
    };
    let reason = own.get("reason");
    let from = if reason.is_null() {
        own.get("derivation")
    } else {
        reason
    };
    vec![
        html! { (own.get("name").text()) },
        html! { (own.get("part").text()) },
        html! { (mark) " " (word) },
        figure("error"),
        figure("bound"),
        html! { (own.get("unit").text()) },
        html! { (own.get("naive").text()) },
        figure("naive_error"),
        html! { (from.text()) },
    ]
}

fn check(own: &Place<'_>) -> Vec<Markup> {
    let (mark, word) = verdict(own);
    vec![
        html! { (own.get("name").text()) },
        html! { (mark) " " (word) },
        html! { (own.get("evidence").text()) },
        html! { (own.get("naive").text()) },
    ]
}
