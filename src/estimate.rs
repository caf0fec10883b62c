//! `potamoi estimate`: synthesis results estimated by fitted formulas.

use std::path::PathBuf;

use clap::Args;
use potamoi_explore::synthesis::{EstimateOf, UnitEstimate};
use potamoi_synth::fit::{EnergiesOf, Fit, ScaledEstimate, Spread};
use potamoi_synth::grid::Grid;
use potamoi_synth::{LibraryOrigin, SynthReport, ToolsOrigin, UnitKind, scaling};
use schemars::JsonSchema;
use serde::Serialize;

use crate::args::Common;
use crate::failure::Failure;
use crate::published::{Published, shape};
use crate::report_files::ReportFiles;
use crate::stdout::{prose, say};
use crate::synth::Units;
use crate::tables;

/// Version of the file that `--json` writes.
const FORMAT_VERSION: u32 = 1;

/// The report of `--json`.
pub(crate) const REPORT: Published = Published {
    command: "estimate",
    version: FORMAT_VERSION,
    shape: shape::<Report<'_>>,
};

#[derive(Debug, Args)]
pub(crate) struct EstimateArgs {
    /// Hardware unit
    #[arg(long, value_enum, default_value_t = Units::All)]
    unit: Units,
    /// Utilisation: share of cycles in which the units issue [default: that
    /// of the workload that was simulated for the syntheses]
    #[arg(long, value_name = "SHARE")]
    busy: Option<f64>,
    /// Channels of a sample [default: those of the workload that was simulated for the syntheses]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=4096))]
    channels: Option<u64>,
    /// Grid of syntheses that the formulas are fitted to, as written by `potamoi synth --grid`
    /// [default: the built-in grid, ASAP7 at 7 nm]
    #[arg(long, value_name = "FILE")]
    fit_to: Option<PathBuf>,
    /// Technology node that figures are scaled to
    #[arg(long, value_name = "NM", default_value_t = 12)]
    scale_to: u32,
    #[command(flatten)]
    files: ReportFiles,
}

/// The JSON report.
#[derive(Debug, Serialize, JsonSchema)]
struct Report<'a> {
    format_version: u32,
    command: &'static str,
    configuration: String,
    library: &'a LibraryOrigin,
    /// Tools that made the grid.
    tools: &'a ToolsOrigin,
    scaled_by: Option<&'a scaling::Factors>,
    units: Vec<UnitEstimate>,
}

pub(crate) fn run(common: &Common, args: &EstimateArgs) -> Result<(), Failure> {
    if let Some(busy) = args.busy.filter(|b| !(0.0..=1.0).contains(b)) {
        let expected = "expected a share, 0 to 1";
        return Err(Failure::Usage(format!("--busy {busy}: {expected}")));
    }
    args.files.prepare([])?;
    let config = common.read_config()?;
    let fit = match &args.fit_to {
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
    let of = EstimateOf {
        busy: args.busy,
        channels: args.channels,
        scaled_by: scaled_by.as_ref(),
    };
    let mut units = vec![];
    for unit in args.unit.of_configuration()? {
        let own = UnitEstimate::new(&fit, &config, *unit, &of)?;
        units.push(own);
    }
    for own in &units {
        print(own, &fit);
    }
    if args.files.are_asked() {
        let report = Report {
            format_version: FORMAT_VERSION,
            command: "estimate",
            configuration: config.hash(),
            library,
            tools: &fit.grid().tools,
            scaled_by: scaled_by.as_ref(),
            units,
        };
        args.files.write(&report)?;
    }
    Ok(())
}

fn print(own: &UnitEstimate, fit: &Fit) {
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
    let mut table = tables::plain([
        "module",
        "count",
        "um^2 each",
        "pJ per cycle: clock",
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
    say!("{}", tables::fitted(&table, &[]));
    totals(own);
    if let Some(of) = &own.energies_of {
        prose!(0, "{}", covered(of));
    }
    for memory in &own.memories {
        say!(
            "memory {}: {} of {} x {} bit, not included: potamoi synth models it",
            memory.module,
            memory.count,
            memory.words,
            memory.bits
        );
    }
    if !own.memories.is_empty() {
        prose!(0, "{}", untimed(library, own.unit));
    }
    for number in &estimate.beyond {
        prose!(
            0,
            "extrapolated beyond the grid, where the errors above do not hold: {number}"
        );
    }
}

/// Text on paths that the period leaves out, with their measured effect.
fn untimed(library: &LibraryOrigin, unit: &str) -> String {
    let paper = SynthReport::checked_in().ok();
    let paper = paper.map(|[paper, _]| paper);
    let paper = paper.filter(|paper| paper.library.sha256 == library.sha256);
    let own = paper.iter().flat_map(|paper| &paper.raw.units);
    let own = own.filter(|own| own.unit == unit);
    let measured = own.filter_map(|own| {
        let with = own.with_memories.as_ref()?;
        Some(format!(
            " (of the preset `paper` {:.0} ps with their access times and {:.0} ps without, as \
             synthesised)",
            with.period_ps, own.period_ps
        ))
    });
    let measured: String = measured.take(1).collect();
    format!(
        "the period excludes paths from and to memories{measured}: potamoi synth --node includes \
         them"
    )
}

/// Text on the workloads that the energies cover, and those that they do not.
fn covered(of: &EnergiesOf) -> String {
    match of.vertices {
        Some(vertices) => format!(
            "energies are of samples of `{}` with {vertices} vertices each; records with another \
             number of vertices differ (one vertex, as of splats: about a third): potamoi synth \
             --activity SCENE",
            of.scene
        ),
        None => format!("energies are of the workload of `{}`", of.scene),
    }
}

/// Totals, each with its error at points left out of the fit.
fn totals(own: &UnitEstimate) {
    let (estimate, errors) = (&own.estimate, &own.errors);
    let to = own.scaled.map(|s| format!("at {} nm", s.node_nm));
    let to = to.unwrap_or_default();
    let mut table = tables::plain([
        "the unit",
        "",
        &to,
        "rms error, held-out points",
        "largest error",
    ]);
    let work = match own.family.unit() {
        UnitKind::Gathering => format!(
            "issuing {:.1} % of cycles, {} channels",
            100.0 * estimate.work.busy,
            estimate.work.channels
        ),
        UnitKind::Vector | UnitKind::ArrayMac | UnitKind::Splat => {
            format!("busy {:.1} % of cycles", 100.0 * estimate.work.busy)
        }
    };
    let scaled = |of: fn(&ScaledEstimate) -> f64| own.scaled.as_ref().map(of);
    let rows = [
        Row {
            what: "area of cells".to_owned(),
            values: [Some(estimate.area_um2), scaled(|s| s.area_um2)],
            unit: Unit::SquareMillimetres,
            error: Some(errors.area),
        },
        Row {
            what: format!("period before wires, of paths to {}", estimate.end),
            values: [Some(estimate.period_ps), scaled(|s| s.period_ps)],
            unit: Unit::Picoseconds,
            error: Some(errors.period),
        },
        Row {
            what: format!("energy per cycle without delays, {work}"),
            values: [Some(estimate.zero_delay_pj), scaled(|s| s.zero_delay_pj)],
            unit: Unit::Picojoules,
            error: Some(errors.zero_delay),
        },
        Row {
            what: "energy per cycle with glitches".to_owned(),
            values: [
                Some(estimate.with_glitches_pj),
                scaled(|s| s.with_glitches_pj),
            ],
            unit: Unit::Picojoules,
            error: Some(errors.with_glitches),
        },
        Row {
            what: "energy per idle cycle".to_owned(),
            values: [Some(estimate.clock_pj), scaled(|s| s.clock_pj)],
            unit: Unit::Picojoules,
            error: None,
        },
        Row {
            what: "leakage".to_owned(),
            values: [Some(estimate.leakage_nw), None],
            unit: Unit::Milliwatts,
            error: Some(errors.leakage),
        },
    ];
    for row in rows {
        let error = |of: fn(&Spread) -> f64| {
            let error = row.error.as_ref();
            error.map_or_else(String::new, |e| format!("{:.1} %", 100.0 * of(e)))
        };
        let [value, scaled] = row
            .values
            .map(|v| v.map_or_else(String::new, |v| row.unit.of(v)));
        table.add_row([
            row.what.clone(),
            value,
            scaled,
            error(|e| e.rms),
            error(|e| e.worst),
        ]);
    }
    say!("{}", tables::fitted(&table, &[]));
}

/// One line of a unit's estimate.
struct Row {
    what: String,
    /// Values at the grid's node, and at the other.
    values: [Option<f64>; 2],
    unit: Unit,
    error: Option<Spread>,
}

/// Printed unit of a figure.
#[derive(Clone, Copy)]
enum Unit {
    /// Square millimetres, from square micrometres.
    SquareMillimetres,
    Picoseconds,
    Picojoules,
    /// Milliwatts, from nanowatts.
    Milliwatts,
}

impl Unit {
    fn of(self, value: f64) -> String {
        match self {
            Self::SquareMillimetres => format!("{:.4} mm^2", value * 1e-6),
            Self::Picoseconds => format!("{value:.0} ps"),
            Self::Picojoules => format!("{value:.2} pJ"),
            Self::Milliwatts => format!("{:.4} mW", value * 1e-6),
        }
    }
}
