//! Plots: energy by part, and a roofline.

use std::path::Path;

use plotters::prelude::*;
use potamoi_explore::system::Modelled;
use potamoi_system::system_model::{Memory, Outcome, Scenario, System};

use crate::charts::{COLOURS, LETTERS, TITLE, legend, picture};
use crate::failure::Failure;

const SIZE: (u32, u32) = (900, 540);
/// Width of a bar in pixels, and of the legend in bars.
const BAR: u32 = 116;
const BESIDE: u32 = 2;

/// One bar a variant, stacked by part.
pub(super) fn energy(path: &Path, found: &Modelled) -> Result<(), Failure> {
    let outcomes = &found.outcomes;
    let names: Vec<String> = outcomes.iter().map(label).collect();
    let most = outcomes
        .iter()
        .map(|o| mid(o).iter().map(|(_, mj)| mj).sum())
        .fold(0.0, f64::max);
    let bars = outcomes.len() as u32 + BESIDE;
    let size = (SIZE.0.max(bars * BAR), SIZE.1);
    picture(path, size, |area| {
        let title = format!(
            "{}, {} x {}: energy of a frame by part, mean of both bounds{}",
            found.scene,
            found.size[0],
            found.size[1],
            not_known(found)
        );
        let mut chart = ChartBuilder::on(area)
            .caption(title, TITLE)
            .margin(12)
            .x_label_area_size(40)
            .y_label_area_size(64)
            .build_cartesian_2d((0..bars - 1).into_segmented(), 0.0..most * 1.05)?;
        chart
            .configure_mesh()
            .disable_x_mesh()
            // None where the legend is.
            .set_tick_mark_size(LabelAreaPosition::Bottom, 0)
            .x_labels(bars as usize)
            .x_label_formatter(&|at| match at {
                SegmentValue::CenterOf(i) => names.get(*i as usize).cloned().unwrap_or_default(),
                SegmentValue::Exact(_) | SegmentValue::Last => String::new(),
            })
            .y_desc("mJ")
            .max_light_lines(1)
            .label_style(LETTERS)
            .draw()?;
        let names = outcomes.first().map(mid).unwrap_or_default();
        let names = names.into_iter().map(|(name, _)| name);
        for (part, (name, colour)) in names.zip(COLOURS).enumerate() {
            let bars = outcomes.iter().enumerate().map(|(i, o)| {
                let own = mid(o);
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

/// Energy by part, the geometric mean of both bounds of the GPU's kernels; 0 where it is not known,
/// which the title says.
fn mid(of: &Outcome) -> Vec<(&'static str, f64)> {
    let [max, sum] = [&of.run.max, &of.run.sum].map(|run| run.energy.named());
    let both = max.into_iter().zip(sum);
    both.map(|((name, max), (_, sum))| (name, (max.zip(sum)).map_or(0.0, |(a, b)| (a * b).sqrt())))
        .collect()
}

/// Blocks without energy, for the title.
fn not_known(found: &Modelled) -> String {
    let blocks: Vec<_> = (found.energy_unknown.iter()).map(|own| own.block).collect();
    match blocks.is_empty() {
        true => String::new(),
        false => format!("; without {}, not known", blocks.join(" and ")),
    }
}

/// Roofline: multiplications a second over multiplications a byte of memory, below the limits of
/// array and memory.
pub(super) fn roofline(path: &Path, found: &Modelled, system: &System) -> Result<(), Failure> {
    let memory = Memory::of(system);
    let array = f64::from(system.array_rows) * f64::from(system.array_columns) * found.clock_ghz;
    let bandwidth = 1.0 / memory.streamed().ns;
    let points: Vec<(f64, f64)> = found
        .outcomes
        .iter()
        .map(|o| {
            let spent = &o.run.max.spent;
            let bytes = spent.streamed_bytes + spent.written_bytes + spent.random_bytes;
            let macs = spent.done.macs as f64;
            (macs / bytes.max(1.0), macs / o.run.span_ns().mid())
        })
        .collect();
    let seen = points.iter().filter(|(x, y)| *x > 0.0 && *y > 0.0);
    let (left, low) = seen.fold((array / bandwidth, array), |(x, y), own| {
        (x.min(own.0), y.min(own.1))
    });
    let right = points.iter().map(|p| p.0).fold(array / bandwidth, f64::max);
    // Whole decades, and room for the legend.
    let down = |v: f64| 10f64.powf((v / 1.5).log10().floor());
    let up = |v: f64| 10f64.powf((v * 1.5).log10().ceil());
    let ([left, low], [right, high]) = ([left, low].map(down), [right * 4.0, array].map(up));
    picture(path, SIZE, |area| {
        let title = format!(
            "{}, {} x {}: multiplications against what the array and memory allow",
            found.scene, found.size[0], found.size[1]
        );
        let mut chart = ChartBuilder::on(area)
            .caption(title, TITLE)
            .margin(12)
            .margin_right(24)
            .x_label_area_size(44)
            .y_label_area_size(64)
            .build_cartesian_2d((left..right).log_scale(), (low..high).log_scale())?;
        chart
            .configure_mesh()
            .x_label_formatter(&one_two_five)
            .y_label_formatter(&one_two_five)
            .x_desc("multiplications a byte of memory")
            .y_desc("multiplications a nanosecond")
            .label_style(LETTERS)
            .draw()?;
        let corners = [left.max(low / bandwidth), array / bandwidth, right];
        let roof = corners.map(|x| (x, (x * bandwidth).min(array)));
        chart
            .draw_series(LineSeries::new(roof, BLACK.stroke_width(2)))?
            .label(format!("array {array:.0} a ns, memory {bandwidth:.1} GB/s"))
            .legend(|(x, y)| PathElement::new([(x, y), (x + 12, y)], BLACK.stroke_width(2)));
        // A colour a variant, rings where references are from afar.
        let same = |a: &Outcome, b: &Outcome| a.scenario == b.scenario;
        for (i, (o, at)) in found.outcomes.iter().zip(&points).enumerate() {
            let number = found.outcomes[..i].iter().filter(|b| same(o, b)).count();
            let colour = COLOURS[number % COLOURS.len()];
            let style = match o.scenario {
                Scenario::Local => colour.filled(),
                Scenario::Remote => colour.stroke_width(3),
            };
            if at.0 > 0.0 && at.1 > 0.0 {
                chart
                    .draw_series([Circle::new(*at, 6, style)])?
                    .label(label(o))
                    .legend(move |(x, y)| Circle::new((x + 6, y), 5, style));
            }
        }
        legend(&mut chart, SeriesLabelPosition::LowerRight)
    })
}

/// Labels of a logarithmic axis: 1, 2 and 5 of each decade.
fn one_two_five(v: &f64) -> String {
    let first = v / 10f64.powf(v.log10().floor());
    match [1.0, 2.0, 5.0].iter().any(|d| (first - d).abs() < 1e-6) {
        // The axis finds them by multiplying.
        true => format!("{}", (v * 1e6).round() / 1e6),
        false => String::new(),
    }
}

fn label(of: &Outcome) -> String {
    match of.scenario {
        Scenario::Local => of.variant.name.to_owned(),
        Scenario::Remote => format!("{} remote", of.variant.name),
    }
}
