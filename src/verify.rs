//! `potamoi verify`: the Verilog against the golden models.

use std::path::PathBuf;
use std::time::Instant;

use clap::{Args, ValueEnum};
use comfy_table::{CellAlignment, Table, presets};
use indicatif::HumanCount;
use potamoi_formats::config::Config;
use potamoi_golden::scene::{FrameCounts, Scene};
use potamoi_golden::units::Twins;
use potamoi_sim::rtl::EngineKind;
use potamoi_sim::verify::{
    Failure as Found, GatherReport, Injection, Settings, VectorReport, Verifier,
};
use serde::Serialize;

use crate::cli::Common;
use crate::failure::Failure;
use crate::files;
use crate::progress;
use crate::scene::SceneArgs;

#[derive(Debug, Args)]
pub(crate) struct VerifyArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// What runs the hardware
    #[arg(long, value_enum, default_value_t = Engine::Verilator)]
    engine: Engine,
    /// How much of the frame is verified
    #[arg(long, value_enum, default_value_t = Level::Quick)]
    level: Level,
    /// Build a fault into the gathering unit, which has to be found
    #[arg(long, value_enum)]
    inject: Option<Inject>,
    /// Seed of the random stalls
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Where the dump of the cycles around a mismatch goes
    #[arg(long, value_name = "FILE", default_value = "potamoi-mismatch.vcd")]
    vcd: PathBuf,
    /// Report as JSON
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Engine {
    /// The Verilog, compiled by Verilator
    Verilator,
    /// The netlist, without any tool
    Interpreter,
    /// The Verilog, under Icarus Verilog: a cross-check on some thousand cycles
    Icarus,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum, Serialize)]
#[serde(rename_all = "kebab-case")]
enum Level {
    /// A share, spread evenly over the frame
    Quick,
    /// Every gather and every vector operation of the frame
    Full,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Inject {
    /// One bit of the reducers' accumulators is inverted
    Bit,
    /// Values stay right, cycles are lost
    Bubble,
    /// The lowest bit of port 0's weights is inverted
    Weight,
}

impl Engine {
    const fn kind(self) -> EngineKind {
        match self {
            Self::Verilator => EngineKind::Verilator,
            Self::Interpreter => EngineKind::Interpreter,
            Self::Icarus => EngineKind::Icarus,
        }
    }

    /// Feature vectors and elements that a quick verification aims at: a few
    /// seconds of each engine.
    const fn budget(self) -> [u64; 2] {
        match self {
            Self::Verilator => [100_000, 1_000_000],
            Self::Interpreter => [2_000, 5_000],
            Self::Icarus => [300, 1_000],
        }
    }
}

impl Inject {
    const fn injection(self) -> Injection {
        match self {
            Self::Bit => Injection::Bit,
            Self::Bubble => Injection::Bubble,
            Self::Weight => Injection::Weight,
        }
    }
}

/// Version of the JSON report.
const FORMAT_VERSION: u32 = 1;

#[derive(Serialize)]
struct Report<'a> {
    format_version: u32,
    command: &'static str,
    scene: &'a str,
    width: u32,
    height: u32,
    /// 12 hexadecimal digits.
    configuration: String,
    engine: EngineKind,
    level: Level,
    seed: u64,
    inject: Option<Injection>,
    /// Differences; the work ends at the first.
    mismatches: u64,
    /// Feature vectors that were compared.
    samples: u64,
    /// Vectors of the vector unit that were compared.
    vectors: u64,
    /// Of the gathering unit, from first to last issue (measured RTL).
    cycles: u64,
    /// The same (cycle model, closed form).
    cycles_predicted: u64,
    busy: u64,
    stall_fifo: u64,
    stall_mft: u64,
    stall_rit: u64,
    gathering_unit: &'a GatherReport,
    vector_unit: &'a VectorReport,
    failure: Option<&'a Found>,
    seconds: f64,
}

pub(crate) fn run(common: &Common, args: &VerifyArgs) -> Result<(), Failure> {
    let config = common.read_config()?;
    let scene = args.scene.open()?;
    let start = Instant::now();
    let spinner = progress::spinner("rendering by the golden models");
    // What the frame holds, so that shares and progress are of a known whole.
    let frame = scene
        .render_fixed(&config, &mut Twins::new(&config))?
        .counts;
    spinner.finish_and_clear();
    let settings = settings(args, &frame);
    let elements: u64 = frame.elements.values().sum();
    let bar = progress::bar(frame.feature_vectors + elements, "verifying");
    let mut show = |p: potamoi_sim::verify::Progress| {
        bar.set_position(p.done);
        bar.set_message(format!("{} cycles compared", HumanCount(p.cycles)));
    };
    let mut verifier = Verifier::new(&config, settings, &mut show);
    let done = scene.render_fixed(&config, &mut verifier);
    let (gather, vector) = (
        verifier.gather_report().clone(),
        verifier.vector_report().clone(),
    );
    let failure = verifier.failure().cloned();
    bar.finish_and_clear();
    if let (Err(error), None) = (done, &failure) {
        return Err(error.into());
    }
    let report = Report {
        format_version: FORMAT_VERSION,
        command: "verify",
        scene: scene.name(),
        width: scene.camera().width,
        height: scene.camera().height,
        configuration: config.hash(),
        engine: args.engine.kind(),
        level: args.level,
        seed: args.seed,
        inject: args.inject.map(Inject::injection),
        mismatches: u64::from(failure.is_some()),
        samples: gather.samples,
        vectors: vector.vectors,
        cycles: gather.cycles,
        cycles_predicted: gather.cycles_predicted,
        busy: gather.busy,
        stall_fifo: gather.stall_fifo,
        stall_mft: gather.stall_mft,
        stall_rit: gather.stall_rit,
        gathering_unit: &gather,
        vector_unit: &vector,
        failure: failure.as_ref(),
        seconds: start.elapsed().as_secs_f64(),
    };
    print(&report, &config, &scene);
    if let Some(path) = &args.json {
        files::write_json(path, &report)?;
    }
    verdict(common, args, failure.as_ref())
}

/// Which share of the frame is verified.
fn settings(args: &VerifyArgs, frame: &FrameCounts) -> Settings {
    let every = |total: u64, budget: u64| match args.level {
        Level::Full => 1,
        Level::Quick => total.div_ceil(budget).max(1),
    };
    let [samples, elements] = args.engine.budget();
    Settings {
        engine: args.engine.kind(),
        seed: args.seed,
        gather_every: every(frame.feature_vectors, samples),
        vector_every: every(frame.elements.values().sum(), elements),
        inject: args.inject.map(Inject::injection),
        excerpt: Some(args.vcd.clone()),
    }
}

fn verdict(common: &Common, args: &VerifyArgs, failure: Option<&Found>) -> Result<(), Failure> {
    let Some(failure) = failure else {
        if let Some(inject) = args.inject {
            return Err(Failure::Inconclusive(format!(
                "the injected fault `{}` was not found in the share that was verified; \
                 try --level full",
                inject.injection()
            )));
        }
        println!("no mismatch in any bit or cycle");
        return Ok(());
    };
    let m = &failure.mismatch;
    println!("MISMATCH in {}, cycle {}: {}", m.module, m.cycle, m.signal);
    println!("  expected {}, found {}", m.expected, m.found);
    let stalls = if failure.stalled {
        "under random stalls"
    } else {
        "without stalls"
    };
    println!("  {}; {stalls}, seed {}", m.place, failure.run_seed);
    match (&failure.excerpt, &failure.excerpt_error) {
        (Some(excerpt), _) => println!(
            "  waveform around it: {}, time {}",
            excerpt.path.display(),
            excerpt.time
        ),
        (None, Some(error)) => println!("  no waveform: {error}"),
        (None, None) => {}
    }
    let mut again = format!("potamoi verify{}", args.scene.arguments());
    again.push_str(&common.arguments());
    for (name, value) in [
        ("engine", args.engine.to_possible_value()),
        ("level", args.level.to_possible_value()),
        ("inject", args.inject.and_then(|i| i.to_possible_value())),
    ] {
        if let Some(value) = value {
            again.push_str(&format!(" --{name} {}", value.get_name()));
        }
    }
    println!("  again: {again} --seed {}", args.seed);
    Err(Failure::Check(match args.inject {
        Some(inject) => format!("the injected fault `{}` was found", inject.injection()),
        None => "hardware and golden models differ".to_owned(),
    }))
}

fn print(report: &Report<'_>, config: &Config, scene: &Scene) {
    println!(
        "{} at {} x {}, configuration {}, engine {}, seed {}",
        scene.name(),
        report.width,
        report.height,
        report.configuration,
        report.engine,
        report.seed
    );
    let (g, v) = (report.gathering_unit, report.vector_unit);
    let count = |n: u64| HumanCount(n).to_string();
    let share = |part: u64, whole: u64| {
        let percent = 100.0 * part as f64 / whole.max(1) as f64;
        format!("{} of {} ({percent:.1} %)", count(part), count(whole))
    };
    let mut table = Table::new();
    table.load_preset(presets::ASCII_BORDERS_ONLY_CONDENSED);
    table.set_header(["", "gathering unit", "vector unit", "unit", "origin"]);
    let rows = [
        [
            "compared, every bit".to_owned(),
            share(g.samples, g.samples_total),
            share(v.elements, v.elements_total),
            "feature vectors, elements".to_owned(),
            "golden model".to_owned(),
        ],
        [
            "in".to_owned(),
            share(g.mvoxels, g.mvoxels_total),
            count(v.vectors),
            format!("MVoxels, vectors of {}", config.vu.lanes),
            "golden model".to_owned(),
        ],
        [
            "cycles, streams ready".to_owned(),
            count(g.cycles),
            count(v.cycles),
            "cycles".to_owned(),
            "measured RTL".to_owned(),
        ],
        [
            "predicted".to_owned(),
            count(g.cycles_predicted),
            count(v.cycles_predicted),
            "cycles".to_owned(),
            "cycle model".to_owned(),
        ],
        [
            "busy".to_owned(),
            count(g.busy),
            count(v.busy),
            "cycles".to_owned(),
            "measured RTL".to_owned(),
        ],
        [
            "stalls: FIFO, MFT, RIT".to_owned(),
            [g.stall_fifo, g.stall_mft, g.stall_rit]
                .map(count)
                .join(", "),
            count(v.stall_out),
            "cycles".to_owned(),
            "measured RTL".to_owned(),
        ],
        [
            "first fill, all runs".to_owned(),
            format!("{} = {}", count(g.fill), count(g.fill_predicted)),
            String::new(),
            "cycles".to_owned(),
            "RTL = cycle model".to_owned(),
        ],
        [
            "compared, every cycle".to_owned(),
            count(g.cycles_compared),
            count(v.cycles_compared),
            "cycles".to_owned(),
            "cycle model".to_owned(),
        ],
        [
            "  under random stalls".to_owned(),
            count(g.cycles_stalled),
            count(v.cycles_stalled),
            "cycles".to_owned(),
            "cycle model".to_owned(),
        ],
    ];
    table.add_rows(rows);
    for column in 1..3 {
        if let Some(column) = table.column_mut(column) {
            column.set_cell_alignment(CellAlignment::Right);
        }
    }
    println!("{table}");
}
