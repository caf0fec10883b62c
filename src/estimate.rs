//! `potamoi estimate`: what synthesis would find, without it.

use std::path::PathBuf;

use clap::Args;
use comfy_table::{CellAlignment, Table, presets};
use potamoi_formats::config::Config;
use potamoi_sim::synth::fit::{Estimate, Fit, Formula, LeftOut, Spread, Work};
use potamoi_sim::synth::grid::{Family, Grid};
use potamoi_sim::synth::{LibraryOrigin, SynthError, UnitKind, scaling};
use serde::Serialize;

use crate::common::Common;
use crate::failure::Failure;
use crate::files;
use crate::say::say;
use crate::synth::Units;

#[derive(Debug, Args)]
pub(crate) struct EstimateArgs {
    /// Which unit
    #[arg(long, value_enum, default_value_t = Units::All)]
    unit: Units,
    /// Share of the cycles in which the units issue, 0 to 1; unless given, that of the
    /// work that the netlists were run with
    #[arg(long, value_name = "SHARE")]
    busy: Option<f64>,
    /// Channels of a sample; unless given, of the same work
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=4096))]
    channels: Option<u64>,
    /// Fit to this file, of `potamoi synth --grid`, in place of the one that comes with the
    /// program: ASAP7, 7 nm
    #[arg(long, value_name = "FILE")]
    grid: Option<PathBuf>,
    /// The node that figures are scaled to, in nanometres
    #[arg(long, value_name = "NM", default_value_t = 12)]
    scale_to: u32,
    /// Estimates as JSON, with errors and origins
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

/// What `--json` writes.
#[derive(Debug, Serialize)]
struct Report<'a> {
    command: &'static str,
    configuration: String,
    library: &'a LibraryOrigin,
    scaled_by: Option<&'a scaling::Factors>,
    units: Vec<UnitEstimate>,
}

#[derive(Debug, Serialize)]
struct UnitEstimate {
    unit: &'static str,
    family: Family,
    /// Relative, at points that were left out.
    errors: LeftOut,
    #[serde(flatten)]
    estimate: Estimate,
    formulas: Vec<Formula>,
}

pub(crate) fn run(common: &Common, args: &EstimateArgs) -> Result<(), Failure> {
    if let Some(busy) = args.busy.filter(|b| !(0.0..=1.0).contains(b)) {
        let expected = "expected a share, 0 to 1";
        return Err(Failure::Usage(format!("--busy {busy}: {expected}")));
    }
    files::prepare([args.json.as_ref()])?;
    let config = common.read_config()?;
    let fit = match &args.grid {
        Some(path) => Fit::new(Grid::read(path)?)?,
        None => Fit::checked_in()?,
    };
    let library = &fit.grid().library;
    let scaled_by = library
        .node_nm
        .and_then(|node| scaling::logic(node, args.scale_to));
    if let (Some(node), None) = (library.node_nm, &scaled_by) {
        return Err(Failure::Usage(format!(
            "--scale-to {}: no factors from {node} nm; known are {} nm",
            args.scale_to,
            scaling::known()
        )));
    }
    let mut units = vec![];
    for unit in args.unit.kinds() {
        let own = estimate(&fit, &config, *unit, args)?;
        print(&own, &fit, scaled_by.as_ref());
        units.push(own);
    }
    if let Some(path) = &args.json {
        let report = Report {
            command: "estimate",
            configuration: config.hash(),
            library,
            scaled_by: scaled_by.as_ref(),
            units,
        };
        files::write_json(path, &report)?;
    }
    Ok(())
}

fn estimate(
    fit: &Fit,
    config: &Config,
    unit: UnitKind,
    args: &EstimateArgs,
) -> Result<UnitEstimate, SynthError> {
    let family = fit.family(config, unit)?;
    let usual = fit.usual_work(family, config);
    let work = Work {
        busy: args.busy.unwrap_or(usual.busy),
        channels: args.channels.unwrap_or(usual.channels),
    };
    Ok(UnitEstimate {
        unit: unit.top(),
        family,
        errors: fit.left_out(family)?,
        estimate: fit.estimate(config, unit, work)?,
        formulas: fit.formulas(family),
    })
}

fn print(own: &UnitEstimate, fit: &Fit, scaled_by: Option<&scaling::Factors>) {
    let estimate = &own.estimate;
    let library = &fit.grid().library;
    let node = library
        .node_nm
        .map_or_else(String::new, |nm| format!(", {nm} nm"));
    say!(
        "\n{}, by formulas fitted to {} syntheses in {}{node}:",
        own.unit,
        own.errors.area.points,
        library.name
    );
    let mut table = Table::new();
    table.load_preset(presets::NOTHING);
    table.set_header([
        "module",
        "count",
        "um^2 of one",
        "pJ a cycle: clock",
        "all, without delays",
        "all, with glitches",
    ]);
    for module in &estimate.modules {
        table.add_row([
            module.module.clone(),
            module.count.to_string(),
            format!("{:.1}", module.area_um2),
            format!("{:.3}", module.clock_pj),
            format!("{:.3}", module.zero_delay_pj),
            format!("{:.3}", module.with_glitches_pj),
        ]);
    }
    table
        .column_iter_mut()
        .skip(1)
        .for_each(|c| c.set_cell_alignment(CellAlignment::Right));
    say!("{table}");
    totals(own, scaled_by);
    for number in &estimate.beyond {
        say!("beyond the grid, so that the errors above do not hold: {number}");
    }
}

/// Sums, each with its error at points that were left out.
fn totals(own: &UnitEstimate, scaled_by: Option<&scaling::Factors>) {
    let (estimate, errors) = (&own.estimate, &own.errors);
    let mut table = Table::new();
    table.load_preset(presets::NOTHING);
    let to = scaled_by.map(|f| format!("at {} nm", f.to_nm));
    let to = to.unwrap_or_default();
    table.set_header(["the unit", "", &to, "rms error at points left out", "worst"]);
    let work = match own.family.unit() {
        UnitKind::Gathering => format!(
            "issuing {:.1} % of cycles, {} channels",
            100.0 * estimate.work.busy,
            estimate.work.channels
        ),
        UnitKind::Vector => format!("busy {:.1} % of cycles", 100.0 * estimate.work.busy),
    };
    let energy: Factor = Some(|f| f.energy);
    let rows = [
        Row {
            what: "area of cells".to_owned(),
            value: estimate.area_um2 * 1e-6,
            unit: "mm^2",
            factor: Some(|f| f.area),
            error: Some(errors.area),
        },
        Row {
            what: format!("period before wires, of paths to {}", estimate.end),
            value: estimate.period_ps,
            unit: "ps",
            factor: Some(|f| f.delay),
            error: Some(errors.period),
        },
        Row {
            what: format!("a cycle without delays, {work}"),
            value: estimate.zero_delay_pj,
            unit: "pJ",
            factor: energy,
            error: Some(errors.zero_delay),
        },
        Row {
            what: "a cycle with glitches".to_owned(),
            value: estimate.with_glitches_pj,
            unit: "pJ",
            factor: energy,
            error: Some(errors.with_glitches),
        },
        Row {
            what: "a cycle at rest".to_owned(),
            value: estimate.clock_pj,
            unit: "pJ",
            factor: energy,
            error: None,
        },
        Row {
            what: "leakage".to_owned(),
            value: estimate.leakage_nw * 1e-6,
            unit: "mW",
            factor: None,
            error: Some(errors.leakage),
        },
    ];
    for row in rows {
        let Row { value, unit, .. } = row;
        let scaled = scaled_by.zip(row.factor);
        let digits = match unit {
            "ps" => 0,
            "pJ" => 2,
            _ => 4,
        };
        let scaled = scaled.map(|(f, of)| format!("{:.digits$} {unit}", value * of(f)));
        let percent = |v: f64| format!("{:.1} %", 100.0 * v);
        let error = |of: fn(&Spread) -> f64| {
            let error = row.error.as_ref();
            error.map_or_else(String::new, |e| percent(of(e)))
        };
        table.add_row([
            row.what.clone(),
            format!("{value:.digits$} {unit}"),
            scaled.unwrap_or_default(),
            error(|e| e.rms),
            error(|e| e.worst),
        ]);
    }
    table
        .column_iter_mut()
        .skip(1)
        .for_each(|c| c.set_cell_alignment(CellAlignment::Right));
    say!("{table}");
}

type Factor = Option<fn(&scaling::Factors) -> f64>;

/// A line of what the unit comes to.
struct Row {
    what: String,
    value: f64,
    unit: &'static str,
    factor: Factor,
    error: Option<Spread>,
}
