//! The look that all plots share.

use serde_json::{Value, json};

/// Colours distinguishable with colour blindness (Okabe and Ito, "Color Universal Design", 2008),
/// those first that also stand out on white and on black. The last is a grey for what is not
/// compared.
pub const COLOURS: [&str; 8] = [
    "#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#B5A642", "#8A8A8A",
];

/// Shapes of points, one a colour, so that a series is known without its colour.
pub const SHAPES: [&str; 8] = [
    "circle",
    "square",
    "triangle-up",
    "diamond",
    "cross",
    "triangle-down",
    "triangle-right",
    "stroke",
];

/// Colours but the grey, and as many shapes.
const LOOKS: usize = COLOURS.len() - 1;

/// Colour and shape of a series. Past the last colour they come again with other shapes, so that 49
/// series differ.
#[must_use]
pub const fn look_of(series: usize) -> [&'static str; 2] {
    [
        COLOURS[series % LOOKS],
        SHAPES[(series + series / LOOKS) % LOOKS],
    ]
}

/// What a plot is drawn on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ink {
    /// A file by itself: dark on white.
    File,
    /// A page, whose colour of text it takes, light or dark.
    Page,
}

impl Ink {
    /// The colour of letters and lines.
    #[must_use]
    pub const fn colour(self) -> &'static str {
        match self {
            Self::File => "#1c1c1c",
            Self::Page => "currentColor",
        }
    }
}

/// A specification with the schema's version and the common look; what it sets itself stays.
#[must_use]
pub fn dressed(spec: &Value, ink: Ink) -> Value {
    let mut spec = spec.clone();
    if let Some(fields) = spec.as_object_mut() {
        let schema = "https://vega.github.io/schema/vega-lite/v6.json";
        fields.insert("$schema".to_owned(), schema.into());
        fields.insert("config".to_owned(), config(ink));
    }
    spec
}

fn config(ink: Ink) -> Value {
    let (own, faint) = (ink.colour(), "#8a8a8a");
    json!({
        "background": match ink { Ink::File => json!("white"), Ink::Page => Value::Null },
        "font": "system-ui, 'Segoe UI', 'DejaVu Sans', sans-serif",
        "padding": 8,
        "view": { "stroke": null },
        "mark": { "color": COLOURS[0] },
        "axis": {
            "labelFontSize": 12, "titleFontSize": 13, "titleFontWeight": "normal", "labelLimit": 400,
            "labelColor": own, "titleColor": own, "domainColor": faint, "tickColor": faint,
            "gridColor": faint, "gridOpacity": 0.3,
        },
        "header": {
            "labelFontSize": 13, "labelFontWeight": "bold", "labelColor": own, "titleColor": own,
            "labelLimit": 900,
        },
        "legend": {
            "labelFontSize": 12, "titleFontSize": 12, "titleFontWeight": "normal", "labelLimit": 320,
            "labelColor": own, "titleColor": own, "symbolSize": 110,
        },
        "title": {
            "anchor": "start", "fontSize": 15, "fontWeight": "bold", "color": own, "subtitleColor": own,
            "subtitleFontSize": 12, "offset": 12,
        },
        "text": { "color": own, "fontSize": 12 },
        "rule": { "color": own },
        "line": { "color": own },
        "range": { "category": COLOURS, "symbol": SHAPES },
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn series_differ_in_colour_or_shape() {
        let all: std::collections::BTreeSet<_> = (0..49).map(look_of).collect();
        assert_eq!(all.len(), 49);
    }
}
