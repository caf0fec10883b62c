//! The page of a report: HTML of the report's document and of its pictures, by itself in one file.
//!
//! The page needs no network: styles, scripts and pictures are in it. Every value that it shows is read from
//! the document, by path; what the document does not have is shown as "-".
//!
//! ```no_run
//! let document = serde_json::json!({ "version": "1.0", "scenes": [] });
//! let page = potamoi_page::page(&document, &Default::default())?;
//! assert!(page.starts_with("<!DOCTYPE html>"));
//! # Ok::<(), potamoi_plots::PlotError>(())
//! ```

mod effects;
mod hard_cases;
mod sections;
mod shots;
mod tables;
#[cfg(test)]
mod tests;
mod value;

use maud::{DOCTYPE, Markup, PreEscaped, html};
use potamoi_plots::library::LIBRARIES;
use potamoi_plots::{PlotError, Renderer};
use serde_json::Value;

use std::collections::BTreeMap;

use value::Place;

/// Pictures by name, as data URIs.
pub type Images = BTreeMap<String, String>;

/// What the marks of the plot of a front are.
pub const FRONT_LINES: &str = "line: front; square: default; ring: knee of the front; settings with equal pictures are not shown";

/// Colours of the scale of errors, from none to the end: those of viridis (van der Walt and Smith,
/// 2015, public domain), which rise in lightness, so that they are told apart without hue.
pub const SCALE: [[u8; 3]; 5] = [
    [68, 1, 84],
    [59, 82, 139],
    [33, 145, 140],
    [94, 201, 98],
    [253, 231, 37],
];

/// What sections are made of: the document, its pictures, and its plots as SVG.
struct Page<'a> {
    root: Place<'a>,
    images: &'a Images,
    renderer: Renderer,
}

/// The page of a document.
///
/// # Errors
/// A plot that cannot be drawn.
pub fn page(document: &Value, images: &Images) -> Result<String, PlotError> {
    let own = Page {
        root: Place::root(document),
        images,
        renderer: Renderer::new()?,
    };
    let sections = own.sections()?;
    let names: Vec<&str> = own
        .root
        .get("scenes")
        .all()
        .iter()
        .map(|s| s.get("name").text())
        .collect();
    let title = format!("Potamoi: {}", names.join(", "));
    let markup = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                meta name="color-scheme" content="light dark";
                meta http-equiv="Content-Security-Policy" content="default-src 'none'; img-src data:; style-src 'unsafe-inline'; script-src 'unsafe-inline' 'unsafe-eval'";
                title { (title) }
                link rel="icon" href="data:,";
                style { (PreEscaped(include_str!("style.css"))) }
            }
            body {
                a class="skip" href="#main" { "To the verdict" }
                header {
                    h1 { (title) }
                    p { "By potamoi " (own.root.get("version").text()) ". Every value is read from the data that this page holds; the last section says where each comes from." }
                    nav aria-label="Sections" { ol { @for (id, title, _) in &sections { li { a href=(format!("#{id}")) { (title) } } } } }
                }
                main id="main" {
                    @for (id, title, body) in &sections {
                        section id=(id) aria-labelledby=(format!("{id}-title")) {
                            h2 id=(format!("{id}-title")) { (title) }
                            (body)
                        }
                    }
                }
                footer { (licences(&own.root)) }
                script type="application/json" id="document" { (PreEscaped(inert(document))) }
                @for own in LIBRARIES { script { (PreEscaped(own.text)) } }
                script { (PreEscaped(include_str!("script.js"))) }
            }
        }
    };
    Ok(markup.into_string())
}

/// JSON that cannot end the element that holds it.
fn inert(document: &Value) -> String {
    document.to_string().replace('<', "\\u003c")
}

/// The libraries in the page, and the texts of their licences.
fn licences(root: &Place<'_>) -> Markup {
    html! {
        h2 { "Libraries in this page" }
        (tables::table("Libraries in this page", &["library", "version", "licence", "SHA-256"],
            root.get("libraries").all().iter().map(|own| {
                vec![
                    html! { (own.get("name").text()) },
                    html! { (own.get("version").text()) },
                    html! { (own.get("licence").text()) },
                    html! { code class="hash" { (own.get("sha256").text()) } },
                ]
            }).collect()))
        @for own in LIBRARIES {
            details { summary { "Licence of " (own.name) } pre { (own.licence_text) } }
        }
    }
}

impl Page<'_> {
    /// A plot of the document as SVG, which the page's script makes interactive.
    fn plot(&self, name: &str, caption: &str) -> Result<Markup, PlotError> {
        let place = self.root.get("plots").get(name);
        if place.is_null() {
            return Ok(html! { p { "-: no plot of this name" } });
        }
        let svg = self.renderer.dressed_svg(place.json())?;
        Ok(html! {
            figure {
                figcaption { (caption) }
                div class="scroll plot" data-plot=(name) role="group" aria-label=(caption) tabindex="0" {
                    (PreEscaped(svg))
                }
            }
        })
    }
}
