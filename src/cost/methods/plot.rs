//! Plot of errors and clocks.

use std::path::Path;

use plotters::prelude::*;
use potamoi_explore::accuracy::{CostQuality, front};
use potamoi_explore::exponential::{Method, Peer};

use super::PAPER;
use crate::charts::{COLOURS, LETTERS, TITLE, legend, picture};
use crate::failure::Failure;

const SIZE: (u32, u32) = (1240, 780);

/// Peers with the positions of their labels on the logarithmic axis: at their error, or far enough
/// above the label before to be legible.
fn labels(peers: &[Peer]) -> Vec<(String, f64, f64)> {
    const SAME: f64 = 1.1;
    const APART: f64 = 1.45;
    let mut sorted: Vec<&Peer> = peers.iter().collect();
    sorted.sort_by(|a, b| a.max_ulp.total_cmp(&b.max_ulp));
    let mut least = 0.0;
    let groups = sorted.chunk_by(|a, b| b.max_ulp < SAME * a.max_ulp);
    groups
        .map(|own| {
            let error = own[0].max_ulp;
            let at = error.max(least);
            least = at * APART;
            let names: Vec<&str> = own.iter().map(|peer| peer.name).collect();
            (names.join("; "), error, at)
        })
        .collect()
}

pub(super) fn plot(path: &Path, methods: &[Method], peers: &[Peer]) -> Result<(), Failure> {
    let all = || {
        methods
            .iter()
            .map(|m| m.max_ulp)
            .chain(peers.iter().map(|p| p.max_ulp))
    };
    let (low, high) = (all().fold(f64::MAX, f64::min), all().fold(0.0, f64::max));
    let slow = methods.iter().map(|m| m.clocks).fold(0.0, f64::max);
    picture(path, SIZE, |area| {
        let mut chart = ChartBuilder::on(area)
            .caption(
                "exponentials: largest error over all inputs, and clocks a result",
                TITLE,
            )
            .margin(12)
            .x_label_area_size(44)
            .y_label_area_size(64)
            .build_cartesian_2d(0.0..slow * 2.0, (low / 1.5..high * 2.0).log_scale())?;
        chart
            .configure_mesh()
            .x_desc("clocks from one result of a lane to its next")
            .y_desc("units of the last place of U0.16")
            .label_style(LETTERS)
            .max_light_lines(1)
            .draw()?;
        let places: Vec<CostQuality> = (methods.iter())
            .map(|m| CostQuality {
                cost: m.clocks,
                quality: -m.max_ulp,
            })
            .collect();
        let kept = front(&places)
            .into_iter()
            .map(|i| (places[i].cost, -places[i].quality));
        chart
            .draw_series(LineSeries::new(kept, BLACK.mix(0.6)))?
            .label("front")
            .legend(|(x, y)| PathElement::new([(x, y), (x + 12, y)], BLACK.mix(0.6)));
        let mut families: Vec<&str> = methods.iter().map(|m| m.family).collect();
        families.dedup();
        for (family, colour) in families.iter().zip(COLOURS.into_iter().cycle()) {
            let own = methods.iter().filter(|m| m.family == *family);
            let at = own.clone().map(|m| (m.clocks, m.max_ulp));
            let filled = colour.filled();
            // What is not built has another shape.
            let drawn = match own.clone().any(|m| m.bound_ulp.is_some()) {
                true => chart
                    .draw_series(at.map(|at| Circle::new(at, 5, filled)))?
                    .legend(move |(x, y)| Circle::new((x + 6, y), 5, filled)),
                false => chart
                    .draw_series(at.map(|at| TriangleMarker::new(at, 7, filled)))?
                    .legend(move |(x, y)| TriangleMarker::new((x + 6, y), 7, filled)),
            };
            drawn.label(*family);
        }
        if let Some(own) = methods.iter().find(|m| m.name == PAPER) {
            let ring = Circle::new((own.clocks, own.max_ulp), 9, BLACK.stroke_width(2));
            chart
                .draw_series([ring])?
                .label("the paper's unit")
                .legend(|(x, y)| Circle::new((x + 6, y), 6, BLACK.stroke_width(2)));
        }
        for peer in peers {
            let level = [(0.0, peer.max_ulp), (slow, peer.max_ulp)];
            chart.draw_series(LineSeries::new(level, BLACK.mix(0.25)))?;
        }
        for (name, error, at) in labels(peers) {
            let leader = [(slow, error), (slow * 1.03, at)];
            chart.draw_series(LineSeries::new(leader, BLACK.mix(0.25)))?;
            chart.draw_series([Text::new(name, (slow * 1.04, at * 1.12), LETTERS)])?;
        }
        legend(&mut chart, SeriesLabelPosition::UpperRight)
    })
}
