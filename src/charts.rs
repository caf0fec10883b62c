//! Charts as SVG.

use std::path::{Path, PathBuf};

use plotters::coord::Shift;
use plotters::prelude::*;
use potamoi_base::outputs as files;

use crate::failure::Failure;

pub(crate) const LETTERS: (&str, u32) = ("sans-serif", 14);
pub(crate) const TITLE: (&str, u32) = ("sans-serif", 18);
/// Colours distinguishable with colour blindness (Okabe and Ito, "Color Universal Design", 2008),
/// and two greys.
pub(crate) const COLOURS: [RGBColor; 12] = [
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(86, 180, 233),
    RGBColor(0, 114, 178),
    RGBColor(240, 228, 66),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(90, 90, 90),
    RGBColor(170, 170, 170),
    RGBColor(128, 64, 32),
    RGBColor(120, 94, 240),
    RGBColor(0, 68, 27),
];

pub(crate) type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
pub(crate) type Drawn = Result<(), Box<dyn std::error::Error>>;

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

/// Draws a chart, and writes the file atomically.
pub(crate) fn picture(
    path: &Path,
    size: (u32, u32),
    draw: impl FnOnce(&Area<'_>) -> Drawn,
) -> Result<(), Failure> {
    let mut text = String::new();
    {
        let area = SVGBackend::with_string(&mut text, size).into_drawing_area();
        let drawn = area
            .fill(&WHITE)
            .map_err(Into::into)
            .and_then(|()| draw(&area))
            .and_then(|()| area.present().map_err(Into::into));
        drawn.map_err(|error| Failure::Usage(format!("{}: {error}", path.display())))?;
    }
    Ok(files::write(path, &text)?)
}

/// Legend in a corner of the chart.
pub(crate) fn legend<'a, 'b, X: Ranged, Y: Ranged>(
    chart: &mut ChartContext<'a, SVGBackend<'b>, Cartesian2d<X, Y>>,
    corner: SeriesLabelPosition,
) -> Drawn
where
    'b: 'a,
{
    chart
        .configure_series_labels()
        .position(corner)
        .background_style(WHITE.mix(0.85))
        .border_style(BLACK.mix(0.3))
        .label_font(LETTERS)
        .draw()?;
    Ok(())
}
