//! Pictures of the page, side by side and one over the other.

use maud::{Markup, html};

use super::Page;
use super::SCALE;
use super::value::{Form, Place};

impl Page<'_> {
    fn image(&self, place: &Place<'_>, what: &str, size: &Place<'_>) -> Markup {
        let id = place.get("id").text();
        let [width, height] = [0, 1].map(|at| size.json()[at].as_u64().unwrap_or(1));
        html! {
            img src=(self.images.get(id).map_or("data:,", String::as_str)) alt=(what) width=(width) height=(height);
        }
    }

    /// Truth or reference, float, hardware and error of a machine, and a slider over two of them.
    pub(super) fn shots(&self, scene: &Place<'_>, machine: &Place<'_>, id: &str) -> Markup {
        let own = machine.get("more").get("pictures");
        let (size, name) = (scene.get("size"), scene.get("name").text());
        let reference = match scene.get("reference").get("kind").text() {
            "truth" => "the truth",
            _ => "the converged picture of the model",
        };
        let image =
            |place: &Place<'_>, what: &str| self.image(place, &format!("{name}: {what}"), &size);
        let first = scene.get("reference_picture");
        let hardware = own.get("hardware");
        let stops = SCALE.map(|[r, g, b]| format!("rgb({r},{g},{b})")).join(",");
        let under = |cell: &Place<'_>| {
            html! { @if cell.is_null() { "equal" } @else { (cell.number(Form::Hundredths)) " dB" } }
        };
        html! {
            div class="shots" {
                figure { (image(&first, reference)) figcaption { "Reference: " (reference) } }
                figure { (image(&own.get("float"), "floating point")) figcaption { "Floating point" } }
                figure { (image(&hardware, "hardware")) figcaption {
                    "Hardware: " (under(&own.get("beside_reference").get("db"))) " beside the reference, "
                    (under(&own.get("beside_float").get("db"))) " beside floating point"
                } }
                figure {
                    (image(&own.get("error"), "error of the hardware's picture"))
                    figcaption {
                        "Error: the largest difference of a channel from the reference, at most "
                        (own.get("largest").number(Form::Small))
                        span class="scale" style=(format!("background:linear-gradient(to right,{stops})")) {}
                        span class="ends" { span { "0" } span { (own.get("scale").number(Form::Small)) " and more" } }
                    }
                }
            }
            div class="slider" data-slider="" {
                div class="two" {
                    (image(&first, reference))
                    div class="over" { (image(&hardware, "hardware, over the reference")) }
                }
                label for=(format!("{id}-slide")) { "Left of the line hardware, right of it the reference" }
                input id=(format!("{id}-slide")) type="range" min="0" max="100" value="50";
            }
        }
    }
}
