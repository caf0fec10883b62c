//! Energy by part and a roofline, as SVG.

use std::path::Path;

use plotters::coord::Shift;
use plotters::prelude::*;
use potamoi_sim::soc::{Memory, Outcome, System};

use super::report::Found;
use crate::failure::Failure;
use crate::files;

const SIZE: (u32, u32) = (900, 540);
const LETTERS: (&str, u32) = ("sans-serif", 14);
const TITLE: (&str, u32) = ("sans-serif", 18);
/// Colours that are told apart by the colour-blind (Okabe and Ito, "Color Universal Design", 2008),
/// and two greys.
const COLOURS: [RGBColor; 9] = [
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(86, 180, 233),
    RGBColor(0, 114, 178),
    RGBColor(240, 228, 66),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(90, 90, 90),
    RGBColor(170, 170, 170),
];

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
type Drawn = Result<(), Box<dyn std::error::Error>>;

/// Draws, and writes the file whole or not at all.
fn picture(path: &Path, draw: impl FnOnce(&Area<'_>) -> Drawn) -> Result<(), Failure> {
    let mut text = String::new();
    {
        let area = SVGBackend::with_string(&mut text, SIZE).into_drawing_area();
        let drawn = area
            .fill(&WHITE)
            .map_err(Into::into)
            .and_then(|()| draw(&area))
            .and_then(|()| area.present().map_err(Into::into));
        drawn.map_err(|error| Failure::Usage(format!("{}: {error}", path.display())))?;
    }
    Ok(files::write(path, &text)?)
}

/// A bar a variant, in parts.
pub(super) fn energy(path: &Path, found: &Found) -> Result<(), Failure> {
    let outcomes = &found.outcomes;
    let names: Vec<String> = outcomes.iter().map(label).collect();
    let most = outcomes
        .iter()
        .map(|o| o.run.energy.total_mj())
        .fold(0.0, f64::max);
    picture(path, |area| {
        let title = format!(
            "{}, {} x {}: energy of a frame by part",
            found.scene, found.size[0], found.size[1]
        );
        let mut chart = ChartBuilder::on(area)
            .caption(title, TITLE)
            .margin(12)
            .x_label_area_size(40)
            .y_label_area_size(64)
            .build_cartesian_2d(
                (0..(outcomes.len() as u32).saturating_sub(1)).into_segmented(),
                0.0..most * 1.05,
            )?;
        chart
            .configure_mesh()
            .disable_x_mesh()
            .x_labels(outcomes.len())
            .x_label_formatter(&|at| match at {
                SegmentValue::CenterOf(i) => names.get(*i as usize).cloned().unwrap_or_default(),
                SegmentValue::Exact(_) | SegmentValue::Last => String::new(),
            })
            .y_desc("mJ")
            .max_light_lines(1)
            .label_style(LETTERS)
            .draw()?;
        for (part, colour) in COLOURS.iter().enumerate() {
            let name = outcomes
                .first()
                .map_or("", |o| o.run.energy.named()[part].0);
            let bars = outcomes.iter().enumerate().map(|(i, o)| {
                let own = o.run.energy.named();
                let below: f64 = own[..part].iter().map(|(_, mj)| mj).sum();
                let x = |at: u32| SegmentValue::Exact(at);
                let mut bar = Rectangle::new(
                    [(x(i as u32), below), (x(i as u32 + 1), below + own[part].1)],
                    colour.filled(),
                );
                bar.set_margin(0, 0, 12, 12);
                bar
            });
            chart.draw_series(bars)?.label(name).legend(move |(x, y)| {
                Rectangle::new([(x, y - 6), (x + 12, y + 6)], colour.filled())
            });
        }
        legend(&mut chart, SeriesLabelPosition::UpperRight)
    })
}

/// Multiplications a second over multiplications a byte of memory, below the array and memory.
pub(super) fn roofline(path: &Path, found: &Found, system: &System) -> Result<(), Failure> {
    let memory = Memory::lpddr3(system.memory_channels);
    let array = f64::from(system.array_rows) * f64::from(system.array_columns) * found.clock_ghz;
    let bandwidth = 1.0 / memory.streamed().ns;
    let points: Vec<(f64, f64)> = found
        .outcomes
        .iter()
        .map(|o| {
            let spent = &o.run.spent;
            let bytes = spent.streamed_bytes + spent.written_bytes + spent.random_bytes;
            let macs = spent.done.macs as f64;
            (macs / bytes.max(1.0), macs / o.run.span_ns)
        })
        .collect();
    let seen = points.iter().filter(|(x, y)| *x > 0.0 && *y > 0.0);
    let (left, low) = seen.fold((array / bandwidth, array), |(x, y), own| {
        (x.min(own.0), y.min(own.1))
    });
    let right = points.iter().map(|p| p.0).fold(array / bandwidth, f64::max) * 10.0;
    picture(path, |area| {
        let title = format!(
            "{}, {} x {}: multiplications against what the array and memory allow",
            found.scene, found.size[0], found.size[1]
        );
        let mut chart = ChartBuilder::on(area)
            .caption(title, TITLE)
            .margin(12)
            .x_label_area_size(44)
            .y_label_area_size(64)
            .build_cartesian_2d(
                (left / 2.0..right).log_scale(),
                (low / 2.0..array * 3.0).log_scale(),
            )?;
        chart
            .configure_mesh()
            .x_desc("multiplications a byte of memory")
            .y_desc("multiplications a nanosecond")
            .label_style(LETTERS)
            .draw()?;
        let steps =
            (0..=200).map(|i| left / 2.0 * (right / (left / 2.0)).powf(f64::from(i) / 200.0));
        let roof = steps.map(|x| (x, (x * bandwidth).min(array)));
        chart
            .draw_series(LineSeries::new(roof, BLACK.stroke_width(2)))?
            .label(format!("array {array:.0} a ns, memory {bandwidth:.1} GB/s"))
            .legend(|(x, y)| PathElement::new([(x, y), (x + 12, y)], BLACK.stroke_width(2)));
        for ((o, at), colour) in found
            .outcomes
            .iter()
            .zip(&points)
            .zip(COLOURS.iter().cycle())
        {
            if at.0 > 0.0 && at.1 > 0.0 {
                chart
                    .draw_series([Circle::new(*at, 6, colour.filled())])?
                    .label(label(o))
                    .legend(move |(x, y)| Circle::new((x + 6, y), 5, colour.filled()));
            }
        }
        legend(&mut chart, SeriesLabelPosition::LowerRight)
    })
}

fn label(of: &Outcome) -> String {
    match of.scenario {
        potamoi_sim::soc::Scenario::Local => of.variant.name.to_owned(),
        potamoi_sim::soc::Scenario::Remote => format!("{} remote", of.variant.name),
    }
}

/// Who is who, in a corner of the chart.
fn legend<'a, 'b, X: Ranged, Y: Ranged>(
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
