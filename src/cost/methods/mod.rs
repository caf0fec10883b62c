//! `potamoi cost --study methods`: exponential methods compared by error over all inputs and clocks
//! per result.

mod plot;

use std::fmt::Write as _;

use potamoi_base::outputs as files;
use potamoi_explore::exponential::{Method, Methods, Peer};
use schemars::JsonSchema;
use serde::Serialize;

use super::{CostArgs, FORMAT_VERSION};
use crate::charts;
use crate::exponential_price;
use crate::failure::Failure;
use crate::stdout::say;
use crate::tables;

/// The paper's unit.
const PAPER: &str = "restoring, n = 16 (the paper's)";

#[derive(Serialize, JsonSchema)]
pub(super) struct Report<'a> {
    format_version: u32,
    command: &'static str,
    unit: &'static str,
    #[serde(flatten)]
    found: &'a Methods,
}

pub(super) fn run(args: &CostArgs) -> Result<(), Failure> {
    let found = Methods::compare()?;
    print(&found);
    if let Some(path) = &args.csv {
        files::write(path, &csv(&found.methods, &found.peers))?;
    }
    if let Some(path) = &args.prices {
        files::write(path, &exponential_price::csv(&found.prices))?;
    }
    if let Some(path) = &args.plot {
        charts::write(path, &plot::spec(&found.methods, &found.peers))?;
    }
    if args.files.are_asked() {
        let report = Report {
            format_version: FORMAT_VERSION,
            command: "cost",
            unit: "methods",
            found: &found,
        };
        args.files.write(&report)?;
    }
    Ok(())
}

fn print(found: &Methods) {
    let mut rows = tables::plain([
        "exponential",
        "clocks per result",
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
    for own in &found.methods {
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
    for peer in &found.peers {
        rows.add_row([
            peer.name.to_owned(),
            "-".to_owned(),
            format!("{:.4}", peer.max_ulp),
        ]);
    }
    say!(
        "all 65,536 inputs of U3.13, forms that are built by their reference units, against \
         exact values of 120 bits\n{rows}"
    );
    for (what, name) in [
        ("with the fewest clocks", &found.cheapest_faithful),
        ("on the least area", &found.smallest_faithful),
        ("with the least energy", &found.thriftiest_faithful),
    ] {
        let own = |name: &String| found.methods.iter().find(|m| m.name == *name);
        if let Some(own) = name.as_ref().and_then(own) {
            say!(
                "faithful form {what}, of those synthesised: {}, {:.4} ulp",
                own.name,
                own.max_ulp
            );
        }
    }
    say!("\nforms as blocks by themselves (potamoi emit --unit exp):");
    exponential_price::print(&found.prices);
}

/// One line a form and a peer; names, which contain commas, are quoted; unknown values are empty.
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
