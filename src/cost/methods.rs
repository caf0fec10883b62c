//! Ways to find an exponential side by side: error over all inputs against clocks a result.

mod forms;
mod others;
mod peers;
mod plot;

use std::fmt::Write as _;

use serde::Serialize;

use super::{CostArgs, FORMAT_VERSION};
use crate::failure::Failure;
use crate::files;
use crate::stdout::say;
use crate::tables;

/// Inputs of U3.13: `u` is a code over 2^13, `exp(-u)` in units of 2^-16 the result.
const INPUT_UNIT: f64 = 1.0 / 8192.0;
const OUTPUT_UNIT: f64 = 65536.0;
/// Units of the last place below which a result is faithful.
const FAITHFUL: f64 = 1.0;
/// The paper's unit.
const PAPER: &str = "restoring, n = 16 (the paper's)";

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

/// A form of the engine, or of what could stand in its place.
#[derive(Serialize)]
struct Method {
    name: String,
    family: &'static str,
    /// From one vector to the next; with an early out on average over all inputs, each lane
    /// by itself.
    clocks: f64,
    max_ulp: f64,
    mean_ulp: f64,
    /// By formula; none of what is not built.
    bound_ulp: Option<f64>,
    /// By analysis of the netlist.
    netlist_ulp: Option<f64>,
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

pub(super) fn run(args: &CostArgs) -> Result<(), Failure> {
    let (methods, peers) = (
        forms::forms()?.into_iter().chain(others::others()?),
        peers::peers()?,
    );
    let methods: Vec<Method> = methods.collect();
    let mut rows = tables::plain([
        "exponential",
        "clocks a result",
        "largest error, ulp of U0.16",
        "bound, formula",
        "bound, netlist",
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
            figure(own.bound_ulp, 3),
            figure(own.netlist_ulp, 3),
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
    say!("all 65,536 inputs of U3.13, of what is built through the twin, against 120 bits\n{rows}");
    let known = |of: Option<f64>| of.unwrap_or(f64::INFINITY);
    let least = |what: &str, of: &dyn Fn(&Method) -> f64, then: &dyn Fn(&Method) -> f64| {
        let synthesised = methods.iter().filter(|m| m.energy_pj.is_some());
        let faithful = synthesised.filter(|m| m.max_ulp < FAITHFUL);
        let own =
            faithful.min_by(|a, b| of(a).total_cmp(&of(b)).then(then(a).total_cmp(&then(b))))?;
        say!(
            "of those synthesised, faithful {what}: {}, {:.4} ulp",
            own.name,
            own.max_ulp
        );
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
        plot::plot(path, &methods, &peers)?;
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
    let mut text = String::from(
        "form,family,clocks,max_ulp,bound_ulp,netlist_ulp,mean_ulp,monotone,area_mm2,energy_pj\n",
    );
    let known = |of: Option<f64>| of.map_or_else(String::new, |v| v.to_string());
    for own in methods {
        let (area, energy) = (known(own.area_mm2), known(own.energy_pj));
        // Writing to a string does not fail.
        let _ = writeln!(
            text,
            "\"{}\",{},{},{},{},{},{},{},{area},{energy}",
            own.name,
            own.family,
            own.clocks,
            own.max_ulp,
            known(own.bound_ulp),
            known(own.netlist_ulp),
            own.mean_ulp,
            own.monotone
        );
    }
    for peer in peers {
        let _ = writeln!(text, "\"{}\",others,,{},,,,,,", peer.name, peer.max_ulp);
    }
    text
}
