//! `potamoi layouts`: comparison of the bank organisations.

use clap::Args;
use potamoi_cycles::layouts::Layout;
use potamoi_explore::organisations::Organisations;
use potamoi_formats::config::{EntryKind, ExtraPorts, Organisation};
use schemars::JsonSchema;
use serde::Serialize;

use crate::args::Common;
use crate::failure::Failure;
use crate::model::clock;
use crate::progress;
use crate::published::{Published, shape};
use crate::report_files::ReportFiles;
use crate::scene::{SceneArgs, say_not_checked};
use crate::stdout::{prose, say};
use crate::tables;

#[derive(Debug, Args)]
pub(crate) struct LayoutsArgs {
    #[command(flatten)]
    scene: SceneArgs,
    #[command(flatten)]
    files: ReportFiles,
}

/// Version of the JSON report.
const FORMAT_VERSION: u32 = 1;

/// The report of `--json`.
pub(crate) const REPORT: Published = Published {
    command: "layouts",
    version: FORMAT_VERSION,
    shape: shape::<Report>,
};

#[derive(Serialize, JsonSchema)]
struct Report {
    format_version: u32,
    command: &'static str,
    scene: String,
    width: u32,
    height: u32,
    /// Hash of the configuration, 12 hexadecimal digits.
    configuration: String,
    #[serde(flatten)]
    found: Organisations,
    /// Items that a model's file leaves open.
    not_checked: Vec<String>,
}

pub(crate) fn run(common: &Common, args: &LayoutsArgs) -> Result<(), Failure> {
    args.files.prepare([])?;
    let config = common.read_config()?;
    let scene = args.scene.open(common)?;
    let spinner = progress::spinner("gathering a frame in every organisation");
    let found = Organisations::of(&scene, &config)?;
    spinner.finish_and_clear();
    let report = Report {
        format_version: FORMAT_VERSION,
        command: "layouts",
        scene: scene.name().to_owned(),
        width: scene.camera().width,
        height: scene.camera().height,
        configuration: config.hash(),
        found,
        not_checked: scene.not_checked(&config),
    };
    print(&report);
    say_not_checked(&report.not_checked);
    args.files.write(&report)?;
    Ok(())
}

/// A share in per cent.
fn percent(rate: f64) -> String {
    format!("{:.1} %", 100.0 * rate)
}

fn name(layout: &Layout) -> String {
    let banks = layout.banks;
    let entry = match layout.entry {
        EntryKind::Paper => "",
        EntryKind::Compact => ", compact entries",
    };
    match layout.organisation {
        Organisation::Auto | Organisation::ChannelMajor => {
            let extra = match (layout.ports, layout.extra_ports) {
                (..=2, _) => "",
                (_, ExtraPorts::Copies) => ", copied banks",
                (_, ExtraPorts::Split) => ", split banks",
            };
            format!(
                "channel-major, {banks} banks, M = {}{extra}{entry}",
                layout.ports
            )
        }
        Organisation::Parity => {
            format!("parity, {banks} banks, M = {}{entry}", layout.ports)
        }
        Organisation::FeatureMajor => {
            let lanes = layout.lanes.unwrap_or_default();
            format!("feature-major, {banks} banks, {lanes} lanes")
        }
    }
}

fn print(report: &Report) {
    prose!(
        0,
        "{} at {} x {}: {} samples gathered (cycle model, streams ready); {}",
        report.scene,
        report.width,
        report.height,
        report.found.samples,
        clock::said(&report.found.clock)
    );
    let mut table = tables::lined(
        1,
        [
            "organisation",
            "cycles",
            "samples per cycle",
            "conflict rate",
            "conflict rate without sharing",
            "cycles lost to conflicts",
            "stalls: MFT, RIT",
            "bandwidth limit, cycles",
        ],
    );
    let mut refused = vec![];
    for row in &report.found.layouts {
        let layout = &row.layout;
        let of_banks = |rate| match layout.lanes {
            Some(_) => percent(rate),
            None => "none".to_owned(),
        };
        let lost = match layout.extra_ports {
            ExtraPorts::Split => percent(row.lost),
            ExtraPorts::Copies => of_banks(row.lost),
        };
        if let Some(reason) = &layout.refused {
            refused.push(format!("{}: {reason}", name(layout)));
            continue;
        }
        table.add_row([
            name(layout),
            layout.cycles.to_string(),
            format!("{:.3}", row.samples_per_cycle),
            of_banks(row.conflict_rate),
            of_banks(row.conflict_rate_unshared),
            lost,
            format!("{}, {}", layout.stall_mft, layout.stall_rit),
            row.bandwidth_cycles.to_string(),
        ]);
    }
    say!("{}", tables::fitted(&table, &[]));
    for reason in refused {
        prose!(2, "left out: {reason}");
    }
    let paper = &report.found.paper;
    prose!(
        2,
        "conflict rate in the paper, of frames gathered in pixel order: {} on average and {} at most \
         with 16 banks and 16 rays, {} for Instant-NGP with 64 rays",
        percent(paper.rays_16_banks_16_average),
        percent(paper.rays_16_banks_16_most),
        percent(paper.rays_64_banks_16_instant_ngp)
    );
    prose!(
        2,
        "bandwidth limit: cycles to read MVoxels and ray index tables at 25.6 GB/s \
         (LPDDR3-1600, four channels; counted bytes, without writing of the tables and without features)"
    );
}
