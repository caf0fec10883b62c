//! Plot of points and their Pareto front.

use std::path::Path;

use plotters::prelude::*;
use potamoi_explore::accuracy::{CostQuality, ImageQuality, Point, ReferenceKind, Sweep, front};

use crate::charts::{Area, COLOURS, Drawn, LETTERS, TITLE, legend, picture};
use crate::failure::Failure;

const SIZE: (u32, u32) = (1240, 620);
/// Index of the default among the points.
const DEFAULT: usize = 0;
/// Frame of the default's mark.
const FRAME: ShapeStyle = ShapeStyle {
    color: RGBAColor(200, 0, 0, 1.0),
    filled: false,
    stroke_width: 2,
};

/// Place of a point by one of its qualities; `None` where pictures are equal or the quality is
/// unknown.
fn place(point: &Point, of: impl Fn(&Point) -> Option<ImageQuality>) -> Option<CostQuality> {
    Some(CostQuality {
        cost: point.frame_ns * 1e-3,
        quality: of(point)?.db?,
    })
}

/// Quality over time, against the ground truth where it is known, and against the converged picture.
pub(super) fn plot(path: &Path, report: &Sweep) -> Result<(), Failure> {
    picture(path, SIZE, |area| {
        let title = format!(
            "{}, {} x {}: quality and time of a frame by knob",
            report.scene, report.size[0], report.size[1]
        );
        let area = area.titled(&title, TITLE)?;
        let has_truth = report.reference.kind == ReferenceKind::Truth;
        let aside = if has_truth { 0.9 } else { 0.4 };
        let panels = area.split_evenly((1, 1 + usize::from(has_truth)));
        let (first, rest) = panels.split_at(usize::from(has_truth));
        for own in first {
            let what = "dB beside the truth, which the model was sampled from";
            panel(own, report, what, aside, |p| p.truth)?;
        }
        for own in rest {
            let what = "dB beside the converged picture of the model";
            panel(own, report, what, aside, |p| Some(p.converged))?;
        }
        Ok(())
    })
}

/// `aside` is the room for labels to the right of the slowest point, as a share of the range of
/// times.
fn panel(
    area: &Area<'_>,
    report: &Sweep,
    what: &str,
    aside: f64,
    of: impl Fn(&Point) -> Option<ImageQuality>,
) -> Drawn {
    let seen: Vec<(usize, CostQuality)> = (report.points.iter().enumerate())
        .filter_map(|(i, point)| Some((i, place(point, &of)?)))
        .collect();
    let range = |of: fn(&CostQuality) -> f64| {
        let all = seen.iter().map(|(_, place)| of(place));
        all.fold((f64::MAX, f64::MIN), |(low, high), v| {
            (low.min(v), high.max(v))
        })
    };
    let (fast, slow) = range(|p| p.cost);
    let (low, high) = range(|p| p.quality);
    let room = (0.06 * (high - low)).max(0.5);
    let mut chart = ChartBuilder::on(area)
        .margin(12)
        .x_label_area_size(44)
        .y_label_area_size(58)
        .build_cartesian_2d(
            0.95 * fast..slow + aside * (slow - fast) + 0.05 * fast,
            low - room..high + room,
        )?;
    chart
        .configure_mesh()
        .x_desc("microseconds a frame")
        .y_desc(what)
        .x_label_formatter(&|v| format!("{v:.0}"))
        .y_label_formatter(&|v| format!("{v:.0}"))
        .label_style(LETTERS)
        .max_light_lines(1)
        .draw()?;
    let places: Vec<CostQuality> = seen.iter().map(|(_, place)| *place).collect();
    let kept = front(&places)
        .into_iter()
        .map(|i| (places[i].cost, places[i].quality));
    chart
        .draw_series(LineSeries::new(kept, BLACK.mix(0.6)))?
        .label("front")
        .legend(|(x, y)| PathElement::new([(x, y), (x + 12, y)], BLACK.mix(0.6)));
    let mut names: Vec<&str> = vec![];
    for (i, _) in &seen {
        let knob = report.points[*i].knob.as_str();
        if *i != DEFAULT && !names.contains(&knob) {
            names.push(knob);
        }
    }
    for (k, name) in names.iter().enumerate() {
        let colour = COLOURS[k % COLOURS.len()];
        // Colours come again with another shape.
        let shape = k / COLOURS.len();
        let own = seen.iter().filter(|(i, _)| report.points[*i].knob == *name);
        let at = own.map(|(_, p)| (p.cost, p.quality));
        // The way of a knob from setting to setting.
        chart.draw_series(LineSeries::new(at.clone(), colour.mix(0.35)))?;
        let filled = colour.filled();
        let drawn = match shape {
            0 => chart
                .draw_series(at.map(|at| Circle::new(at, 5, filled)))?
                .legend(move |(x, y)| Circle::new((x + 6, y), 5, filled)),
            1 => chart
                .draw_series(at.map(|at| TriangleMarker::new(at, 6, filled)))?
                .legend(move |(x, y)| TriangleMarker::new((x + 6, y), 6, filled)),
            _ => chart
                .draw_series(at.map(|at| Cross::new(at, 5, filled)))?
                .legend(move |(x, y)| Cross::new((x + 6, y), 5, filled)),
        };
        drawn.label(*name);
    }
    let at = |wanted: usize| {
        let found = seen.iter().find(|(i, _)| *i == wanted);
        found.map(|(_, place)| (place.cost, place.quality))
    };
    // Many settings lie where the default does: a frame around it is seen.
    let square = |at| EmptyElement::at(at) + Rectangle::new([(-9, -9), (9, 9)], FRAME);
    chart
        .draw_series(at(DEFAULT).map(square))?
        .label("default")
        .legend(|(x, y)| Rectangle::new([(x, y - 6), (x + 12, y + 6)], FRAME));
    if let Some(at) = report.knee.and_then(at) {
        chart
            .draw_series([Circle::new(at, 10, BLACK.stroke_width(2))])?
            .label("knee of the front")
            .legend(|(x, y)| Circle::new((x + 6, y), 6, BLACK.stroke_width(2)));
    }
    legend(&mut chart, SeriesLabelPosition::LowerRight)
}
