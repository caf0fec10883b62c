//! Charts: specifications of Vega-Lite, drawn as SVG.

mod labels;
mod stacked;

use std::path::{Path, PathBuf};

use potamoi_base::outputs as files;
use potamoi_plots::{COLOURS, Ink, Renderer};
use serde_json::{Value, json};

use crate::failure::Failure;

pub(crate) use labels::{Labels, labelled};
pub(crate) use stacked::{largest_parts, segments, stacked};

/// Most series that have colours and shapes of their own in one plot.
pub(crate) const SERIES: usize = 7;
/// Grey of marks without a colour of their own: the GPU alone, and knobs beyond the coloured ones.
pub(crate) const GREY: &str = COLOURS[SERIES];

/// Parses the file name of a chart.
///
/// # Errors
/// Another file type: charts are SVG.
pub(crate) fn svg(given: &str) -> Result<PathBuf, String> {
    let path = PathBuf::from(given);
    match path.extension().is_some_and(|kind| kind == "svg") {
        true => Ok(path),
        false => Err("pictures of charts are SVG: expected a name that ends in .svg".to_owned()),
    }
}

/// Draws a specification, and writes the file atomically.
pub(crate) fn write(path: &Path, spec: &Value) -> Result<(), Failure> {
    let drawn = Renderer::new().and_then(|own| own.svg(spec, Ink::File));
    let text = drawn.map_err(|error| Failure::Usage(format!("{}: {error}", path.display())))?;
    Ok(files::write(path, &text)?)
}

/// An encoding by a number.
pub(crate) fn number(field: &str, title: &str) -> Value {
    json!({ "field": field, "type": "quantitative", "title": title })
}

/// An encoding by a number on a logarithmic axis, with marks at 1, 2 and 5 of each decade.
pub(crate) fn logarithmic(field: &str, title: &str, domain: [f64; 2]) -> Value {
    let decades = domain.map(|end| end.log10().floor() as i32);
    let all = (decades[0]..=decades[1])
        .flat_map(|decade| [1.0, 2.0, 5.0].map(|first| first * 10f64.powi(decade)));
    let marks: Vec<f64> = all
        .filter(|mark| (domain[0]..=domain[1]).contains(mark))
        .collect();
    let mut own = number(field, title);
    own["scale"] = json!({ "type": "log", "domain": domain, "nice": false });
    own["axis"] = json!({ "values": marks });
    own
}

/// An encoding by a name, in the order of the data.
pub(crate) fn name(field: &str) -> Value {
    json!({ "field": field, "type": "nominal", "sort": null, "title": null })
}
