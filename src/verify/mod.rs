//! `potamoi verify`: compares the Verilog with the golden models.

mod report;

use std::path::PathBuf;
use std::time::Instant;

use clap::{Args, ValueEnum};
use indicatif::HumanCount;
use potamoi_explore::verification::{Extent, Work};
use potamoi_formats::config::{Config, NO_SPLAT_UNIT, Organisation};
use potamoi_rtl::verify::{Failure as Found, Injection, Settings, Verifier};
use potamoi_rtl::{EngineKind, ForeignRtl};
use potamoi_scene::trace::Trace;
use schemars::JsonSchema;
use serde::Serialize;

use crate::args::{Common, quoted};
use crate::failure::Failure;
use crate::progress;
use crate::published::{Published, shape};
use crate::report_files::ReportFiles;
use crate::scene::{SceneArgs, say_not_checked};
use crate::stdout::{prose, say};
use report::{FORMAT_VERSION, Report, print};

/// The report of `--json`.
pub(crate) const REPORT: Published = Published {
    command: "verify",
    version: FORMAT_VERSION,
    shape: shape::<Report<'_>>,
};

#[derive(Debug, Args)]
pub(crate) struct VerifyArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// Trace to verify, as written by `potamoi trace` [default: recorded from the scene]
    #[arg(long, value_name = "FILE", conflicts_with_all = ["scene", "camera", "width", "height"])]
    trace: Option<PathBuf>,
    /// Folder of Verilog to verify, edited or synthesised again, with the ports of the units [default:
    /// that of the configuration]
    #[arg(long, value_name = "DIR", conflicts_with = "inject")]
    rtl: Option<PathBuf>,
    /// Begin of the names of the units in the folder of --rtl [default: none; a module of another
    /// name is found by its ports]
    #[arg(long, value_name = "NAME", requires = "rtl")]
    rtl_prefix: Option<String>,
    /// Engine that does the work: a simulator of the hardware, or what the points of a sweep are
    /// spread over
    #[arg(long, value_enum, default_value_t = Engine::Verilator)]
    engine: Engine,
    /// Extent of the verification
    #[arg(long, value_enum, default_value_t = Level::Quick)]
    level: Level,
    /// Fault injected into the hardware, which verification has to detect [default: none]
    #[arg(long, value_enum)]
    inject: Option<Inject>,
    /// Seed of the pseudo-random numbers; equal seeds give equal results
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// File for the waveform around a mismatch
    #[arg(long, value_name = "FILE", default_value = "potamoi-mismatch.vcd")]
    vcd: PathBuf,
    #[command(flatten)]
    files: ReportFiles,
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

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
enum Level {
    /// A share of the work, spread evenly over the frame
    Quick,
    /// Every gather and every vector operation of the frame
    Full,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Inject {
    /// One bit of the reducers' accumulators is inverted
    Bit,
    /// Cycles are lost; values stay correct
    Bubble,
    /// The lowest bit of port 0's weights is inverted
    Weight,
    /// Lanes (feature-major) or port 0 (split banks) drop a pending bank request
    Grant,
    /// Lanes (feature-major) receive the word of the neighbouring bank, port 1 (split banks) that
    /// of the other read
    Crossbar,
    /// One bit of a constant of the exponential engines is inverted
    Exp,
    /// The lowest bit of the splat unit's alphas is inverted
    Alpha,
}

impl Engine {
    const fn kind(self) -> EngineKind {
        match self {
            Self::Verilator => EngineKind::Verilator,
            Self::Interpreter => EngineKind::Interpreter,
            Self::Icarus => EngineKind::Icarus,
        }
    }

    /// Target size of a quick verification, in feature vectors, elements, and pixels of the splat unit:
    /// a few seconds on each engine. A job of the splat unit is verified whole.
    const fn budget(self) -> [u64; 3] {
        match self {
            Self::Verilator => [100_000, 1_000_000, 40_000],
            Self::Interpreter => [4_000, 20_000, 1],
            Self::Icarus => [300, 1_000, 1],
        }
    }
}

impl Inject {
    const fn injection(self) -> Injection {
        match self {
            Self::Bit => Injection::Bit,
            Self::Bubble => Injection::Bubble,
            Self::Weight => Injection::Weight,
            Self::Grant => Injection::Grant,
            Self::Crossbar => Injection::Crossbar,
            Self::Exp => Injection::Exp,
            Self::Alpha => Injection::Alpha,
        }
    }
}

pub(crate) fn run(common: &Common, args: &VerifyArgs) -> Result<(), Failure> {
    args.files.prepare([Some(&args.vcd)])?;
    let config = common.read_config()?;
    let rtl = args.rtl.as_deref();
    let rtl = rtl.map(|folder| ForeignRtl::read(folder, args.rtl_prefix.as_deref()));
    let rtl = rtl.transpose()?;
    if let Some(rtl) = &rtl {
        rtl.check_units(&config)?;
    }
    if rtl.is_some() && args.engine == Engine::Interpreter {
        let text = "--engine interpreter runs no Verilog: use verilator or icarus with --rtl";
        return Err(Failure::Usage(text.to_owned()));
    }
    if args.inject == Some(Inject::Alpha) && config.su.is_none() {
        return Err(Failure::Usage(format!("--inject alpha: {NO_SPLAT_UNIT}")));
    }
    let start = Instant::now();
    let spinner = progress::spinner("reading the work");
    let work = open(common, args, &config)?;
    // What there is to do, so that shares and progress are of a known whole.
    let frame = work.counts(&config)?;
    spinner.finish_and_clear();
    let settings = settings(args, frame, rtl);
    let bar = progress::bar(frame.iter().sum(), "verifying");
    let mut show = |p: potamoi_rtl::verify::Progress| {
        bar.set_position(p.done);
        bar.set_message(format!("{} cycles compared", HumanCount(p.cycles)));
    };
    let mut verifier = Verifier::new(&config, settings, &mut show);
    let done = work.run(&config, &mut verifier);
    let (gather, vector) = (
        verifier.gather_report().clone(),
        verifier.vector_report().clone(),
    );
    let splat = verifier.splat_report().clone();
    let failure = verifier.failure().cloned();
    bar.finish_and_clear();
    if let (Err(error), None) = (done, &failure) {
        return Err(with_interpreter(error.into(), args));
    }
    let report = Report {
        format_version: FORMAT_VERSION,
        command: "verify",
        scene: work.scene(),
        trace: args.trace.as_ref(),
        rtl: args.rtl.as_ref(),
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
        stall_bank: gather.stall_bank,
        gathering_unit: &gather,
        vector_unit: &vector,
        splat_unit: config.su.as_ref().map(|_| &splat),
        failure: failure.as_ref(),
        not_checked: work.not_checked(&config),
        seconds: start.elapsed().as_secs_f64(),
    };
    print(&report, &config);
    args.files.write(&report)?;
    match &failure {
        None => agreement(&report, &config),
        Some(failure) => difference(common, args, failure),
    }
}

/// Names the engine that needs no tool, where one cannot be used.
fn with_interpreter(failure: Failure, args: &VerifyArgs) -> Failure {
    if !failure.is_of_a_tool() || args.rtl.is_some() {
        return failure;
    }
    Failure::Tools(format!(
        "{failure}\n--engine interpreter needs no tool: it runs the netlists themselves, more slowly"
    ))
}

/// Opens the work: a trace, or a scene's frame.
fn open(common: &Common, args: &VerifyArgs, config: &Config) -> Result<Work, Failure> {
    Ok(match &args.trace {
        Some(path) => Work::Trace(path.clone(), Box::new(Trace::read(path, config)?)),
        None => Work::Scene(Box::new(args.scene.open(common)?)),
    })
}

/// Extent of the verification, for these total feature vectors, elements and pixels.
fn settings(args: &VerifyArgs, total: [u64; 3], rtl: Option<ForeignRtl>) -> Settings {
    let extent = match args.level {
        Level::Full => Extent::Full,
        Level::Quick => Extent::Share(args.engine.budget()),
    };
    let [gather_every, vector_every, splat_every] = extent.every(total);
    Settings {
        engine: args.engine.kind(),
        seed: args.seed,
        gather_every,
        vector_every,
        splat_every,
        inject: args.inject.map(Inject::injection),
        rtl,
        excerpt: Some(args.vcd.clone()),
    }
}

/// Checks that agreement means something: an error if nothing was compared.
fn agreement(report: &Report<'_>, config: &Config) -> Result<(), Failure> {
    if let Some(inject) = report.inject {
        return Err(Failure::inconclusive(format!(
            "the injected fault `{inject}` was not found in the share that was verified; \
             try --level full"
        )));
    }
    let mut units = vec![
        ("gathering unit", report.gathering_unit.samples),
        ("vector unit", report.vector_unit.elements),
    ];
    units.extend(report.splat_unit.map(|own| ("splat unit", own.pixels)));
    if units.iter().all(|(_, compared)| *compared == 0) {
        return Err(Failure::inconclusive(format!(
            "nothing was compared: {} has no work for any unit; choose a scene, a camera or a \
             trace with something in view",
            report.scene
        )));
    }
    say!("no mismatch in any bit or cycle");
    for (unit, _) in units.iter().filter(|(_, compared)| *compared == 0) {
        say!("  the {unit} had no work and was not compared");
    }
    say_not_exercised(report, config);
    say_not_checked(&report.not_checked);
    Ok(())
}

/// Names what no run has moved or had work for: a fault there would not have been found.
fn say_not_exercised(report: &Report<'_>, config: &Config) {
    let [gather, vector] = [report.gathering_unit.samples, report.vector_unit.elements];
    let mut missing = Vec::new();
    if gather > 0 {
        say_at_rest(report, config);
        missing.extend(report.gathering_unit.reach.missing(config));
        missing.push("cfg_clear".to_owned());
    }
    if vector > 0 {
        let built = config.vu.ops.iter().map(|op| op.name());
        let idle: Vec<_> = built
            .filter(|op| !report.vector_unit.operations.contains(op))
            .collect();
        if !idle.is_empty() {
            missing.push(format!("operations {}", idle.join(", ")));
        }
    }
    if !missing.is_empty() {
        prose!(2, "had no work: {}", missing.join("; "));
        prose!(
            2,
            "the bench that emit writes moves all of these (make -C DIR/sim)"
        );
    }
}

/// Names the outputs of the gathering unit that no run has moved.
fn say_at_rest(report: &Report<'_>, config: &Config) {
    let counters = [
        "stat_stall_fifo",
        "stat_stall_mft",
        "stat_stall_rit",
        "stat_stall_bank",
    ];
    let built = match config.organisation().0 {
        Organisation::FeatureMajor => 4,
        _ => 3,
    };
    let seen = counters.iter().zip(report.gathering_unit.stalls_compared);
    let mut at_rest: Vec<_> = seen
        .take(built)
        .filter(|(_, cycles)| *cycles == 0)
        .map(|(name, _)| *name)
        .collect();
    // Frames keep every promise of the streams.
    at_rest.push("the error flags");
    prose!(2, "stayed 0 in every run: {}", at_rest.join(", "));
}

fn difference(common: &Common, args: &VerifyArgs, failure: &Found) -> Result<(), Failure> {
    let m = &failure.mismatch;
    say!("MISMATCH in {}, cycle {}: {}", m.module, m.cycle, m.signal);
    say!("  expected {}, found {}", m.expected, m.found);
    let stalls = if failure.stalled {
        "under random stalls"
    } else {
        "without stalls"
    };
    say!("  {}; {stalls}, seed {}", m.place, failure.run_seed);
    match (&failure.excerpt, &failure.excerpt_error) {
        (Some(excerpt), _) => say!(
            "  waveform around it: {}, time {}",
            excerpt.path.display(),
            excerpt.time
        ),
        (None, Some(error)) => say!("  no waveform: {error}"),
        (None, None) => {}
    }
    let work = match &args.trace {
        Some(path) => format!(" --trace {}", quoted(path)),
        None => args.scene.arguments(),
    };
    let mut again = format!("potamoi verify{work}");
    again.push_str(&common.arguments());
    if let Some(folder) = &args.rtl {
        again.push_str(&format!(" --rtl {}", quoted(folder)));
    }
    if let Some(prefix) = &args.rtl_prefix {
        again.push_str(&format!(" --rtl-prefix {prefix}"));
    }
    for (name, value) in [
        ("engine", args.engine.to_possible_value()),
        ("level", args.level.to_possible_value()),
        ("inject", args.inject.and_then(|i| i.to_possible_value())),
    ] {
        if let Some(value) = value {
            again.push_str(&format!(" --{name} {}", value.get_name()));
        }
    }
    say!("  to reproduce: {again} --seed {}", args.seed);
    Err(Failure::check(match args.inject {
        Some(inject) => format!("the injected fault `{}` was found", inject.injection()),
        None => "hardware and golden models differ".to_owned(),
    }))
}
