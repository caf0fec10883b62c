//! Ways to find an exponential side by side: error over all inputs against clocks a result.

use std::fmt::Write as _;
use std::path::Path;

use plotters::prelude::*;
use potamoi_formats::config::{Config, ExpBase, ExpConfig, ExpForm};
use potamoi_formats::units::OpCode;
use potamoi_golden::units::exp::ExpTwin;
use potamoi_golden::units::reference::Reference;
use potamoi_golden::units::widths::budget;
use potamoi_sim::synth::fit::{Fit, ScaledEstimate, Work};
use potamoi_sim::synth::{SynthError, UnitKind, scaling};
use serde::Serialize;

use super::front::{Place, front};
use super::{CostArgs, FORMAT_VERSION};
use crate::charts::{COLOURS, LETTERS, TITLE, legend, picture};
use crate::failure::Failure;
use crate::files;
use crate::say::say;
use crate::tables;

const SIZE: (u32, u32) = (1100, 620);
/// Inputs of U3.13: `u` is a code over 2^13, `exp(-u)` in units of 2^-16 the result.
const INPUT_UNIT: f64 = 1.0 / 8192.0;
const OUTPUT_UNIT: f64 = 65536.0;
/// Units of the last place below which a result is faithful.
const FAITHFUL: f64 = 1.0;
/// Nanometres at which area and energy are stated.
const NODE_NM: u32 = 12;

#[derive(Serialize)]
struct Report {
    format_version: u32,
    command: &'static str,
    unit: &'static str,
    methods: Vec<Method>,
    peers: Vec<Peer>,
    /// Faithful with the fewest clocks; of those with the least energy.
    cheapest_faithful: Option<String>,
    /// Faithful on the least area.
    smallest_faithful: Option<String>,
    /// Faithful with the least energy.
    thriftiest_faithful: Option<String>,
}

/// A form of the engine.
#[derive(Serialize)]
struct Method {
    name: String,
    family: &'static str,
    /// From one vector to the next; with an early out on average over all inputs, each lane
    /// by itself.
    clocks: f64,
    max_ulp: f64,
    mean_ulp: f64,
    bound_ulp: f64,
    monotone: bool,
    /// Square millimetres of the paper's vector unit with it at 12 nm; none where it was neither
    /// synthesised nor formulas are of it.
    area_mm2: Option<f64>,
    /// Picojoules of the unit, at work all the time, for each; likewise.
    energy_pj: Option<f64>,
}

/// What others use: measured on the same inputs, rounded to the same output.
#[derive(Serialize)]
struct Peer {
    name: &'static str,
    max_ulp: f64,
}

/// The vector unit at work all the time, at 12 nm.
fn hardware(fit: &Fit, config: &Config) -> Result<Option<ScaledEstimate>, Failure> {
    let node = fit.grid().library.node_nm;
    let factors = node.and_then(|nm| scaling::logic(nm, NODE_NM));
    let work = Work {
        busy: 1.0,
        channels: 0,
    };
    match (fit.estimate(config, UnitKind::Vector, work), factors) {
        (Ok(unit), Some(factors)) => Ok(Some(unit.scaled(&factors))),
        (Err(SynthError::NotFitted { .. }), _) | (_, None) => Ok(None),
        (Err(error), _) => Err(error.into()),
    }
}

fn method(
    fit: &Fit,
    family: &'static str,
    name: String,
    exp: ExpConfig,
) -> Result<Method, Failure> {
    let fail = |e: &dyn std::fmt::Display| Failure::Inconclusive(e.to_string());
    let reference = Reference::in_base(exp.input, exp.base).map_err(|e| fail(&e))?;
    let twin = ExpTwin::new(&exp);
    let error = reference.measure(exp.output_bits, |u| twin.exp(u));
    let clocks = match (exp.pipelined, exp.early_out) {
        (true, _) => 1.0,
        (_, true) => {
            let (mut sum, mut count) = (0.0, 0.0);
            for u in reference.codes() {
                sum += f64::from(exp.clocks_of(twin.exponent(OpCode::Exp, u)));
                count += 1.0;
            }
            sum / count
        }
        _ => f64::from(exp.engine().interval),
    };
    let mut config = Config::paper();
    config.vu.exp = exp.clone();
    let hardware = hardware(fit, &config)?;
    Ok(Method {
        name,
        family,
        clocks,
        max_ulp: error.max_ulp,
        mean_ulp: error.mean,
        bound_ulp: budget(&exp),
        monotone: error.monotone,
        area_mm2: hardware.as_ref().map(|unit| unit.area_um2 * 1e-6),
        energy_pj: (hardware.as_ref())
            .map(|unit| unit.with_glitches_pj * clocks / f64::from(config.vu.lanes)),
    })
}

/// Forms of the paper's engine and the alternatives, widths as they follow.
fn methods() -> Result<Vec<Method>, Failure> {
    let fit = Fit::checked_in()?;
    let paper = Config::paper().vu.exp;
    let mut all = vec![];
    for n in [8, 10, 12, 14, 16, 20, 24, 27] {
        let exp = ExpConfig {
            iterations: n,
            ..paper.clone()
        };
        let name = format!(
            "restoring, n = {n}{}",
            if n == 16 { " (the paper's)" } else { "" }
        );
        all.push(method(&fit, "restoring", name, exp)?);
    }
    for n in [4, 6, 8, 9, 14] {
        let exp = ExpConfig {
            iterations: n,
            tail: true,
            ..paper.clone()
        };
        all.push(method(
            &fit,
            "with a tail",
            format!("restoring, n = {n}, tail"),
            exp,
        )?);
    }
    let early = ExpConfig {
        early_out: true,
        ..paper.clone()
    };
    all.push(method(
        &fit,
        "early out",
        "restoring, n = 16, early out".to_owned(),
        early,
    )?);
    for n in [3, 4, 5] {
        let exp = ExpConfig {
            form: ExpForm::Radix4,
            iterations: n,
            tail: true,
            ..paper.clone()
        };
        all.push(method(
            &fit,
            "radix 4 with a tail",
            format!("radix 4, J = {n}, tail"),
            exp,
        )?);
    }
    for base in [ExpBase::E, ExpBase::Two] {
        for pieces in [64, 128, 256] {
            let exp = ExpConfig {
                form: ExpForm::Piecewise,
                base,
                pieces,
                pipelined: true,
                ..paper.clone()
            };
            let (family, power) = match base {
                ExpBase::E => ("straight pieces", ""),
                ExpBase::Two => ("straight pieces of 2^-u", " of 2^-u"),
            };
            all.push(method(
                &fit,
                family,
                format!("{pieces} pieces{power}"),
                exp,
            )?);
        }
    }
    Ok(all)
}

/// The nearest code, 1 held at the largest.
fn code(value: f64) -> i32 {
    (value * OUTPUT_UNIT).round().min(OUTPUT_UNIT - 1.0) as i32
}

/// A table of so many entries over 0..8, each of its middle.
fn table(entries: i32, u: i32) -> i32 {
    let step = 65536 / entries;
    let middle = f64::from(u / step * step) + f64::from(step) / 2.0;
    code((-middle * INPUT_UNIT).exp())
}

/// N. Schraudolph, "A Fast, Compact Approximation of the Exponential Function", Neural
/// Computation 11, 1999: the power written into a float's exponent, without his correction.
fn schraudolph(u: i32) -> i32 {
    let x = -f64::from(u) * INPUT_UNIT;
    let bits = (x / std::f64::consts::LN_2 + 127.0) * f64::from(1 << 23);
    code(f64::from(f32::from_bits(bits as u32)))
}

/// A result in 32-bit floating point that is so many units of its last place too large.
fn off_by(ulps: impl Fn(f32) -> f64, u: i32) -> i32 {
    let x = -(u as f32) * INPUT_UNIT as f32;
    let y = f64::from(x).exp();
    let last = 2f64.powi(y.log2().floor() as i32 - 23);
    code(y + ulps(x) * last)
}

fn peers() -> Result<Vec<Peer>, Failure> {
    let paper = Config::paper().vu.exp;
    let fail = |e: &dyn std::fmt::Display| Failure::Inconclusive(e.to_string());
    let reference = Reference::of(paper.input).map_err(|e| fail(&e))?;
    let peer = |name, of: &dyn Fn(i32) -> i32| Peer {
        name,
        max_ulp: reference.measure(paper.output_bits, of).max_ulp,
    };
    Ok(vec![
        peer("the C library's 32-bit exp", &|u| {
            code(f64::from((-(u as f32) * INPUT_UNIT as f32).exp()))
        }),
        peer(
            "CUDA's ex2.approx at its published 2 ulp of 32 bits",
            &|u| off_by(|_| 2.0, u),
        ),
        peer("CUDA's __expf at its published 2 + |1.173 x| ulp", &|u| {
            off_by(|x| 2.0 + f64::from((1.173 * x).abs()).floor(), u)
        }),
        peer("a table of 2048 entries", &|u| table(2048, u)),
        peer("a table of 1024 entries", &|u| table(1024, u)),
        peer("Schraudolph's", &schraudolph),
    ])
}

pub(super) fn run(args: &CostArgs) -> Result<(), Failure> {
    let (methods, peers) = (methods()?, peers()?);
    let mut rows = tables::plain([
        "exponential",
        "clocks a result",
        "largest error, ulp of U0.16",
        "bound",
        "mean",
        "monotone",
        "mm^2 of the unit, 12 nm",
        "pJ each",
    ]);
    let figure = |of: Option<f64>, digits: usize| {
        of.map_or_else(|| "-".to_owned(), |v| format!("{v:.digits$}"))
    };
    for own in &methods {
        rows.add_row([
            own.name.clone(),
            format!("{:.2}", own.clocks),
            format!("{:.4}", own.max_ulp),
            format!("{:.3}", own.bound_ulp),
            format!("{:.4}", own.mean_ulp),
            if own.monotone { "yes" } else { "no" }.to_owned(),
            figure(own.area_mm2, 4),
            figure(own.energy_pj, 1),
        ]);
    }
    for peer in &peers {
        rows.add_row([
            peer.name.to_owned(),
            "-".to_owned(),
            format!("{:.4}", peer.max_ulp),
        ]);
    }
    say!("all 65,536 inputs of U3.13 through the twin, against 120 bits\n{rows}");
    let known = |of: Option<f64>| of.unwrap_or(f64::INFINITY);
    let least = |what: &str, of: &dyn Fn(&Method) -> f64, then: &dyn Fn(&Method) -> f64| {
        let faithful = methods.iter().filter(|m| m.max_ulp < FAITHFUL);
        let own =
            faithful.min_by(|a, b| of(a).total_cmp(&of(b)).then(then(a).total_cmp(&then(b))))?;
        say!("faithful {what}: {}, {:.4} ulp", own.name, own.max_ulp);
        Some(own.name.clone())
    };
    let (area, energy) = (
        |m: &Method| known(m.area_mm2),
        |m: &Method| known(m.energy_pj),
    );
    let cheapest_faithful = least("with the fewest clocks", &|m| m.clocks, &energy);
    let smallest_faithful = least("on the least area", &area, &|m| m.clocks);
    let thriftiest_faithful = least("with the least energy", &energy, &|m| m.clocks);
    if let Some(path) = &args.csv {
        files::write(path, &csv(&methods, &peers))?;
    }
    if let Some(path) = &args.plot {
        plot(path, &methods, &peers)?;
    }
    if let Some(path) = &args.json {
        let report = Report {
            format_version: FORMAT_VERSION,
            command: "cost",
            unit: "methods",
            methods,
            peers,
            cheapest_faithful,
            smallest_faithful,
            thriftiest_faithful,
        };
        files::write_json(path, &report)?;
    }
    Ok(())
}

/// A line a form and a peer; names, which hold commas, in quotes; what is not known is empty.
fn csv(methods: &[Method], peers: &[Peer]) -> String {
    let mut text =
        String::from("form,family,clocks,max_ulp,bound_ulp,mean_ulp,monotone,area_mm2,energy_pj\n");
    let known = |of: Option<f64>| of.map_or_else(String::new, |v| v.to_string());
    for own in methods {
        let (area, energy) = (known(own.area_mm2), known(own.energy_pj));
        // Writing to a string does not fail.
        let _ = writeln!(
            text,
            "\"{}\",{},{},{},{},{},{},{area},{energy}",
            own.name,
            own.family,
            own.clocks,
            own.max_ulp,
            own.bound_ulp,
            own.mean_ulp,
            own.monotone
        );
    }
    for peer in peers {
        let _ = writeln!(text, "\"{}\",others,,{},,,,,", peer.name, peer.max_ulp);
    }
    text
}

/// Where the peers' names stand on the logarithmic axis: at their errors, from below, or so far
/// above the one before that they can be read.
fn labels(peers: &[Peer]) -> Vec<(&'static str, f64)> {
    const APART: f64 = 1.5;
    let mut all: Vec<(&str, f64)> = peers.iter().map(|p| (p.name, p.max_ulp)).collect();
    all.sort_by(|a, b| a.1.total_cmp(&b.1));
    let mut least = 0.0;
    for (_, at) in &mut all {
        *at = at.max(least);
        least = *at * APART;
    }
    all
}

fn plot(path: &Path, methods: &[Method], peers: &[Peer]) -> Result<(), Failure> {
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
            .build_cartesian_2d(0.0..slow * 1.75, (low / 1.5..high * 2.0).log_scale())?;
        chart
            .configure_mesh()
            .x_desc("clocks from one result of a lane to its next")
            .y_desc("units of the last place of U0.16")
            .label_style(LETTERS)
            .max_light_lines(1)
            .draw()?;
        let places: Vec<Place> = (methods.iter())
            .map(|m| Place {
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
        for (family, colour) in families.iter().zip(COLOURS) {
            let own = methods.iter().filter(|m| m.family == *family);
            chart
                .draw_series(own.map(|m| Circle::new((m.clocks, m.max_ulp), 5, colour.filled())))?
                .label(*family)
                .legend(move |(x, y)| Circle::new((x + 6, y), 5, colour.filled()));
        }
        for peer in peers {
            let level = [(0.0, peer.max_ulp), (slow, peer.max_ulp)];
            chart.draw_series(LineSeries::new(level, BLACK.mix(0.25)))?;
        }
        for (name, at) in labels(peers) {
            chart.draw_series([Text::new(name, (slow * 1.01, at * 1.15), LETTERS)])?;
        }
        legend(&mut chart, SeriesLabelPosition::MiddleRight)
    })
}
