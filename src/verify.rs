//! `potamoi verify`: the Verilog against the golden models.

use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::{Args, ValueEnum};
use comfy_table::{CellAlignment, Table, presets};
use indicatif::HumanCount;
use potamoi_formats::config::Config;
use potamoi_golden::scene::Scene;
use potamoi_golden::trace::Trace;
use potamoi_golden::units::{Twins, Units};
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
    /// Trace that `potamoi trace` wrote, instead of a scene
    #[arg(long, value_name = "FILE", conflicts_with_all = ["scene", "camera", "width", "height"])]
    trace: Option<PathBuf>,
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
            Self::Interpreter => [4_000, 20_000],
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
    trace: Option<&'a PathBuf>,
    width: Option<u32>,
    height: Option<u32>,
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
    let start = Instant::now();
    let spinner = progress::spinner("reading the work");
    let work = Work::open(args, &config)?;
    // What there is to do, so that shares and progress are of a known whole.
    let frame = work.counts(&config)?;
    spinner.finish_and_clear();
    let settings = settings(args, frame);
    let bar = progress::bar(frame.iter().sum(), "verifying");
    let mut show = |p: potamoi_sim::verify::Progress| {
        bar.set_position(p.done);
        bar.set_message(format!("{} cycles compared", HumanCount(p.cycles)));
    };
    let mut verifier = Verifier::new(&config, settings, &mut show);
    let done = work.run(&config, &mut verifier);
    let (gather, vector) = (
        verifier.gather_report().clone(),
        verifier.vector_report().clone(),
    );
    let failure = verifier.failure().cloned();
    bar.finish_and_clear();
    if let (Err(error), None) = (done, &failure) {
        return Err(error);
    }
    let report = Report {
        format_version: FORMAT_VERSION,
        command: "verify",
        scene: work.scene(),
        trace: args.trace.as_ref(),
        width: work.size().map(|s| s[0]),
        height: work.size().map(|s| s[1]),
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
    print(&report, &config);
    if let Some(path) = &args.json {
        files::write_json(path, &report)?;
    }
    verdict(common, args, failure.as_ref())
}

/// What is verified: a frame, or a trace of one.
enum Work {
    Scene(Box<Scene>),
    Trace(PathBuf, Box<Trace>),
}

impl Work {
    fn open(args: &VerifyArgs, config: &Config) -> Result<Self, Failure> {
        Ok(match &args.trace {
            Some(path) => Self::Trace(path.clone(), Box::new(Trace::read(path, config)?)),
            None => Self::Scene(Box::new(args.scene.open()?)),
        })
    }

    fn scene(&self) -> &str {
        match self {
            Self::Scene(scene) => scene.name(),
            Self::Trace(_, trace) => &trace.scene,
        }
    }

    fn size(&self) -> Option<[u32; 2]> {
        match self {
            Self::Scene(scene) => Some([scene.camera().width, scene.camera().height]),
            Self::Trace(..) => None,
        }
    }

    /// Feature vectors and elements.
    fn counts(&self, config: &Config) -> Result<[u64; 2], Failure> {
        match self {
            Self::Scene(scene) => {
                let frame = scene.render_fixed(config, &mut Twins::new(config))?.counts;
                Ok([frame.feature_vectors, frame.elements.values().sum()])
            }
            Self::Trace(_, trace) => {
                let entries = trace.gathered.iter().map(|g| g.task.entries.len() as u64);
                let elements = trace.computed.iter().map(|c| c.a.len() as u64);
                Ok([entries.sum(), elements.sum()])
            }
        }
    }

    fn run(&self, config: &Config, verifier: &mut Verifier<'_>) -> Result<(), Failure> {
        match self {
            Self::Scene(scene) => {
                scene.render_fixed(config, verifier)?;
                Ok(())
            }
            Self::Trace(path, trace) => replay(path, trace, verifier),
        }
    }
}

/// Sends a trace through units that also compute the golden values: those must
/// be the trace's.
fn replay(path: &Path, trace: &Trace, units: &mut dyn Units) -> Result<(), Failure> {
    let differs = |what: &str| {
        Failure::Check(format!(
            "trace {}: its {what} differ from the golden model's: it was written by another \
             version of potamoi; write it again",
            path.display()
        ))
    };
    let tasks: Vec<_> = trace.gathered.iter().map(|g| g.task.clone()).collect();
    let mut features = vec![];
    units.gather(&tasks, &mut features).map_err(Failure::Unit)?;
    let expected = trace.gathered.iter().flat_map(|g| &g.features);
    if !features.iter().eq(expected) {
        return Err(differs("features"));
    }
    for computed in &trace.computed {
        let mut out = vec![0; computed.a.len()];
        units
            .vector(computed.op, &computed.a, &computed.b, &mut out)
            .map_err(Failure::Unit)?;
        if out != computed.out {
            return Err(differs("results"));
        }
    }
    Ok(())
}

/// Which share of the work is verified: of so many feature vectors and elements.
fn settings(args: &VerifyArgs, [vectors, operations]: [u64; 2]) -> Settings {
    let every = |total: u64, budget: u64| match args.level {
        Level::Full => 1,
        Level::Quick => total.div_ceil(budget).max(1),
    };
    let [samples, elements] = args.engine.budget();
    Settings {
        engine: args.engine.kind(),
        seed: args.seed,
        gather_every: every(vectors, samples),
        vector_every: every(operations, elements),
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
    let work = match &args.trace {
        Some(path) => format!(" --trace {}", path.display()),
        None => args.scene.arguments(),
    };
    let mut again = format!("potamoi verify{work}");
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

fn print(report: &Report<'_>, config: &Config) {
    let of = match (report.trace, report.width.zip(report.height)) {
        (Some(trace), _) => format!("{} (trace of {})", trace.display(), report.scene),
        (None, Some((width, height))) => format!("{} at {width} x {height}", report.scene),
        (None, None) => report.scene.to_owned(),
    };
    println!(
        "{of}, configuration {}, engine {}, seed {}",
        report.configuration, report.engine, report.seed
    );
    if report.failure.is_some() {
        return;
    }
    let measured = match report.engine {
        EngineKind::Verilator | EngineKind::Icarus => "RTL",
        EngineKind::Interpreter => "netlist",
    };
    let (g, v) = (report.gathering_unit, report.vector_unit);
    let count = |n: u64| HumanCount(n).to_string();
    let share = |part: u64, whole: u64| {
        let percent = 100.0 * part as f64 / whole.max(1) as f64;
        if part == whole {
            return format!("all {}", count(whole));
        }
        format!("{} of {} ({percent:.2} %)", count(part), count(whole))
    };
    let mut table = Table::new();
    table.load_preset(presets::ASCII_BORDERS_ONLY_CONDENSED);
    table.set_header(["", "gathering unit", "vector unit", "unit", "origin"]);
    let rows = [
        [
            "compared, every bit".to_owned(),
            share(g.samples, g.samples_total),
            share(v.elements, v.elements_total),
            "vectors, elements".to_owned(),
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
            measured.to_owned(),
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
            measured.to_owned(),
        ],
        [
            "stalls: FIFO, MFT, RIT".to_owned(),
            [g.stall_fifo, g.stall_mft, g.stall_rit]
                .map(count)
                .join(", "),
            count(v.stall_out),
            "cycles".to_owned(),
            measured.to_owned(),
        ],
        [
            "first fill, all runs".to_owned(),
            format!("{} = {}", count(g.fill), count(g.fill_predicted)),
            String::new(),
            "cycles".to_owned(),
            format!("{measured}, model"),
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
