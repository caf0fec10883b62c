//! `potamoi mutate`: how many small faults in the Verilog the tests find.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use clap::{Args, ValueEnum};
use potamoi_base::content_hash;
use potamoi_explore::verification::{Extent, Work};
use potamoi_formats::config::Config;
use potamoi_formats::units::NPU_EXT;
use potamoi_mutate::{
    Draw, Fate, Judge, Judged, Kept, MutateError, Options, Score, Tools, chosen_modules, score,
};
use potamoi_netlist::{Header, verilog};
use potamoi_prove::{Unit, top_as_built, units_as_built};
use potamoi_rtl::verify::{Settings, Verifier};
use potamoi_rtl::{EngineKind, ForeignRtl};
use schemars::JsonSchema;
use serde::Serialize;

use crate::args::Common;
use crate::failure::Failure;
use crate::progress;
use crate::published::{Published, shape};
use crate::report_files::ReportFiles;
use crate::scene::SceneArgs;
use crate::stdout::say;
use crate::suggest;
use crate::tables;

#[derive(Debug, Args)]
pub(crate) struct MutateArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// Hardware unit [default: all]
    #[arg(long, value_enum)]
    unit: Option<MutatedUnit>,
    /// Modules of the units, by name; the others get no fault [default: all]
    #[arg(long, value_delimiter = ',', value_name = "NAME,...")]
    module: Vec<String>,
    /// Faults in every module; fewer where it has fewer
    #[arg(long, value_name = "N", default_value_t = 300,
        value_parser = clap::value_parser!(u32).range(1..=100_000))]
    mutants: u32,
    /// Judges, of which each gets what is left by those before it
    #[arg(long, value_enum, value_delimiter = ',', value_name = "JUDGE,...",
        default_values_t = [JudgeArg::Bench, JudgeArg::Miter, JudgeArg::UnitMiter, JudgeArg::Proofs,
            JudgeArg::MiterFromZero, JudgeArg::Operands, JudgeArg::Verify])]
    judges: Vec<JudgeArg>,
    /// Seed of the pseudo-random numbers; equal seeds give equal results
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    #[command(flatten)]
    files: ReportFiles,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum MutatedUnit {
    /// The gathering unit
    Gu,
    /// The vector unit
    Vu,
    /// The SoC top around both, without what is in them
    Npu,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum JudgeArg {
    /// The standalone bench, under Verilator
    Bench,
    /// A miter of the module with and without the fault, from any state, which finds it equivalent
    Miter,
    /// A miter of the unit with and without the fault, from the states that the proofs allow
    UnitMiter,
    /// The proofs of the checks in the Verilog
    Proofs,
    /// The miter of the module from the state with all registers at 0, which takes minutes
    MiterFromZero,
    /// All operands of a pipelined exponential, in lanes with and without the fault, under Verilator
    Operands,
    /// The verification of a scene's work against the golden models, under Icarus Verilog
    Verify,
}

impl From<JudgeArg> for Judge {
    fn from(judge: JudgeArg) -> Self {
        match judge {
            JudgeArg::Bench => Self::Bench,
            JudgeArg::Miter => Self::Miter,
            JudgeArg::UnitMiter => Self::UnitMiter,
            JudgeArg::MiterFromZero => Self::MiterFromZero,
            JudgeArg::Operands => Self::Operands,
            JudgeArg::Verify => Self::Verify,
            JudgeArg::Proofs => Self::Proofs,
        }
    }
}

/// Version of the JSON report.
const FORMAT_VERSION: u32 = 1;

/// The report of `--json`.
pub(crate) const REPORT: Published = Published {
    command: "mutate",
    version: FORMAT_VERSION,
    shape: shape::<Report>,
};
/// Cycles of the runs in which the proofs look for a counterexample.
const CYCLES: u32 = 4;
/// Feature vectors and elements that the verification compares of a mutant.
const WORK: [u64; 3] = [300, 1_000, 1];

#[derive(Serialize, JsonSchema)]
struct Report {
    format_version: u32,
    command: &'static str,
    /// Hash of the configuration, 12 hexadecimal digits.
    configuration: String,
    yosys: String,
    yices: Option<String>,
    seed: u64,
    judges: BTreeSet<Judge>,
    units: Vec<UnitReport>,
}

#[derive(Serialize, JsonSchema)]
struct UnitReport {
    unit: String,
    /// Digests of the modules' netlists, 16 hexadecimal digits. The page of the scores has them.
    netlists: BTreeMap<String, String>,
    modules: BTreeMap<String, Score>,
    all: Score,
    mutants: Vec<Judged>,
}

pub(crate) fn run(common: &Common, args: &MutateArgs) -> Result<(), Failure> {
    args.files.prepare([])?;
    let config = common.read_config()?;
    let judges: BTreeSet<Judge> = args.judges.iter().map(|&judge| judge.into()).collect();
    let tools = Tools::find(&judges)?;
    let options = Options {
        judges,
        draw: Draw {
            mutants: args.mutants,
            modules: args.module.iter().cloned().collect(),
            seed: args.seed,
        },
        cycles: CYCLES,
        kept: Some(kept()?),
    };
    let work = Work::Scene(Box::new(args.scene.open(common)?));
    let every = Extent::Share(WORK).every(work.counts(&config)?);
    let mut all = units_as_built(&config)?;
    let whole: BTreeMap<String, String> = all
        .iter()
        .flat_map(|unit| verilog(&unit.module, &Header::default()))
        .collect();
    all.push(top_as_built(&config)?);
    let mut units = vec![];
    let chosen = match args.unit {
        Some(MutatedUnit::Gu) => &all[..1],
        Some(MutatedUnit::Vu) => &all[1..2],
        Some(MutatedUnit::Npu) => &all[2..],
        None => &all[..],
    };
    refuse_unknown(&options.draw.modules, chosen)?;
    let of_unit = |unit: &&Unit| !chosen_modules(unit, &options.draw.modules).is_empty();
    for unit in chosen.iter().filter(of_unit) {
        let bar = progress::bar(1, &format!("mutants of {}", unit.name));
        let show = |by: &str, done: usize, of: usize| {
            bar.set_length(of as u64);
            bar.set_position(done as u64);
            bar.set_message(by.to_owned());
        };
        let verify = |faulty: &BTreeMap<String, String>| {
            // No scene runs through the SoC top.
            if unit.name == NPU_EXT {
                return Ok(None);
            }
            // The other unit is there without a fault.
            let mut files = whole.clone();
            for module in unit_modules(unit) {
                files.remove(&module);
            }
            files.extend(faulty.clone());
            verified(&config, &work, every, args.seed, &files)
        };
        let mutants = score(&tools, &config, unit, &options, &verify, &show)?;
        bar.finish_and_clear();
        let netlists = unit.module.digests().into_iter();
        let netlists = netlists.filter(|(name, _)| of_modules(&mutants, name));
        units.push(UnitReport {
            unit: unit.name.clone(),
            netlists: netlists.map(|(name, d)| (name, d.to_string())).collect(),
            modules: Score::of(&mutants),
            all: Score::sum(&mutants),
            mutants,
        });
    }
    let report = Report {
        format_version: FORMAT_VERSION,
        command: "mutate",
        configuration: config.hash(),
        yosys: tools.yosys,
        yices: tools.proofs.map(|tools| tools.yices),
        seed: args.seed,
        judges: options.judges,
        units,
    };
    print(&report);
    args.files.write(&report)?;
    Ok(())
}

/// Whether there are mutants of this module.
fn of_modules(mutants: &[Judged], name: &str) -> bool {
    mutants.iter().any(|judged| judged.mutant.module == name)
}

/// Refuses names of modules that these units do not have.
fn refuse_unknown(modules: &BTreeSet<String>, units: &[Unit]) -> Result<(), Failure> {
    let all = BTreeSet::new();
    let own: BTreeSet<String> = units.iter().flat_map(|u| chosen_modules(u, &all)).collect();
    let Some(unknown) = modules.difference(&own).next() else {
        return Ok(());
    };
    let names: Vec<&str> = own.iter().map(String::as_str).collect();
    let expected = format!("--module is {unknown}: expected {}", names.join(", "));
    let message = suggest::with_nearest(expected, unknown, names);
    Err(Failure::Usage(message))
}

/// Where verdicts are kept, with the hash of this program.
fn kept() -> Result<Kept, Failure> {
    let folder =
        potamoi_verilated::cache::folder("mutants").map_err(potamoi_synth::SynthError::from)?;
    let file = |path: &Path| {
        let path = path.to_owned();
        move |error| MutateError::File { path, error }
    };
    let own = std::env::current_exe().map_err(file(Path::new("potamoi")))?;
    let program = std::fs::read(&own).map_err(file(&own))?;
    let program = content_hash::hash_of(&program).to_hex().to_string();
    Ok(Kept { folder, program })
}

/// Files of a unit's modules.
fn unit_modules(unit: &Unit) -> Vec<String> {
    verilog(&unit.module, &Header::default())
        .into_keys()
        .collect()
}

/// Runs a scene's work through Verilog, under Icarus Verilog: the difference from the golden models.
fn verified(
    config: &Config,
    work: &Work,
    every: [u64; 3],
    seed: u64,
    files: &BTreeMap<String, String>,
) -> Result<Option<String>, MutateError> {
    let file = |path: &Path| {
        let path = path.to_owned();
        move |error| MutateError::File { path, error }
    };
    let folder = tempfile::tempdir().map_err(file(&std::env::temp_dir()))?;
    for (name, text) in files {
        let path = folder.path().join(name);
        std::fs::write(&path, text).map_err(file(&path))?;
    }
    let settings = Settings {
        engine: EngineKind::Icarus,
        seed,
        gather_every: every[0],
        vector_every: every[1],
        splat_every: every[2],
        inject: None,
        rtl: Some(ForeignRtl::read(folder.path(), None)?),
        excerpt: None,
    };
    let quiet = &mut |_| {};
    let mut verifier = Verifier::new(config, settings, quiet);
    // The unit runs without a fault, so that an error is one of the fault: of a unit that hangs, or
    // of a bit that is unknown.
    let done = work.run(config, &mut verifier);
    let difference = verifier.failure().map(|found| {
        let m = &found.mismatch;
        format!(
            "cycle {}: {}: {} not {}",
            m.cycle, m.signal, m.found, m.expected
        )
    });
    Ok(difference.or_else(|| done.err().map(|error| error.to_string())))
}

fn print(report: &Report) {
    for unit in &report.units {
        let header = [
            "module",
            "mutants",
            "bench",
            "verify",
            "proofs",
            "equivalent",
            "alive",
            "bench %",
            "all %",
        ];
        let mut table = tables::lined(1, header);
        for (module, score) in unit.modules.iter().chain([(&"all".to_owned(), &unit.all)]) {
            let counts = [
                score.mutants,
                score.bench,
                score.verify,
                score.proofs,
                score.equivalent,
                score.alive,
            ];
            let percent = score.percent();
            let percent = |i: usize| {
                // Rounded down: 100 is all of them.
                let tenths = percent.map(|p| (10.0 * p[i]).floor() / 10.0);
                tenths.map_or("-".to_owned(), |p| format!("{p:.1}"))
            };
            let mut row = vec![module.clone()];
            row.extend(counts.iter().map(usize::to_string));
            row.extend([percent(0), percent(1)]);
            table.add_row(row);
        }
        say!("{}:", unit.unit);
        say!("{}", tables::fitted(&table, &[]));
        let alive = unit.mutants.iter().filter(|m| m.fate == Fate::Alive);
        for Judged { mutant, .. } in alive {
            say!("  alive: {}", mutant.what());
        }
    }
}
