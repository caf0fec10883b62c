//! Self-checking testbenches of the units with golden vectors, for simulators that this crate does
//! not drive.
//!
//! A bench runs jobs one after the other, changes the settings between them while the unit is idle,
//! and compares every beat in every bit, the counters, the flags and, without gaps, the cycles. Its
//! ports and widths are those of the netlist; its expected values are the reference units' and the
//! cycle models'.

mod beat;
mod common;
mod exponential;
mod exponential_sums;
mod exponential_twins;
mod garbage;
mod gather;
mod gather_edges;
mod gather_flags;
mod gather_setting_flags;
mod gather_tasks;
mod job;
mod makefile;
mod memory;
mod npu;
mod npu_bus;
mod npu_parts;
mod parts;
mod ports;
mod script;
mod splat_jobs;
mod splats;
mod suite;
mod text;
mod vector;
mod vector_flags;
mod vector_operands;

use std::collections::BTreeMap;
use std::sync::Arc;

use potamoi_cycles::runs;
use potamoi_cycles::vector_unit::VectorTiming;
use potamoi_formats::config::{Config, Sums};
use potamoi_formats::units::{GATHERING_UNIT, NPU_EXT, SPLAT_UNIT, VECTOR_UNIT};
use potamoi_netlist::Module;
use potamoi_reference::GatherTask;
use potamoi_reference::gathering_unit::ReferenceGatheringUnit;
use potamoi_reference::splat_unit::TILE_PIXELS;
use potamoi_reference::trace_recorder::{Computed, Gathered};
use potamoi_reference::vector_unit::ReferenceVectorUnit;
use potamoi_units::gathering_unit::gathering_unit;
use potamoi_units::splat_unit::splat_unit;
use potamoi_units::vector_unit::vector_unit;

use super::model::RtlError;
use super::vector_drive::VectorBatch;
use garbage::Garbage;
use gather_edges::Edge;
use ports::UnitPorts;
use suite::{Memories, Owes, Suite};
use vector_operands::Batch;

pub use exponential::exponential;
pub use makefile::RUNS;
pub use memory::MemoryFile;
pub use suite::BenchFiles;

/// Seed of the jobs of [`standalone`].
const SEED: u64 = 1;
/// Clocks without a beat after which a unit counts as hanging.
const PATIENCE: u32 = 5000;

/// Cycles of a job of [`standalone`].
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct JobCycles {
    /// Unit that does it.
    pub unit: &'static str,
    /// Its content in words.
    pub title: String,
    /// Cycles from the first offered beat to the last taken one, both included, without pauses.
    pub cycles: u64,
}

/// Cycles of all jobs of [`standalone`] for both units. The bench of a unit compares them with those of
/// the Verilog.
///
/// # Errors
/// As [`standalone`].
pub fn job_cycles(config: &Config) -> Result<Vec<JobCycles>, RtlError> {
    let mut suites = vec![
        (GATHERING_UNIT, edges_of_gathers(config)?),
        (VECTOR_UNIT, edges_of_vectors(config)?),
    ];
    if config.su.is_some() {
        suites.push((SPLAT_UNIT, edges_of_splats(config)?));
    }
    let jobs = suites.into_iter().flat_map(|(unit, suite)| {
        suite.jobs.into_iter().map(move |job| JobCycles {
            unit,
            title: job.title,
            cycles: job.cycles,
        })
    });
    Ok(jobs.collect())
}

/// The folder `sim`: a Makefile, and for each of these units of the configuration a bench with
/// small jobs at the units' edges. The units lie in `../gathering_unit` and `../vector_unit`. The
/// bench of their top, in `../potamoi_npu_ext`, reads the memories of both.
/// `prefix` stands before the name of every module of theirs.
///
/// # Errors
/// A unit of another name, or with a port that the benches do not know.
pub fn standalone(
    config: &Config,
    units: &[&str],
    prefix: &str,
) -> Result<BTreeMap<String, String>, RtlError> {
    let mut files = BTreeMap::from([("Makefile".to_owned(), makefile::text(units))]);
    for unit in units {
        let top = format!("{prefix}{unit}");
        let mut suite = match *unit {
            GATHERING_UNIT => edges_of_gathers(config)?,
            VECTOR_UNIT => edges_of_vectors(config)?,
            SPLAT_UNIT => edges_of_splats(config)?,
            NPU_EXT => {
                let suites = [edges_of_gathers(config)?, edges_of_vectors(config)?];
                let bench = npu::bench(config, &top, &makefile::commands(unit), suites)?;
                files.insert(format!("{unit}_tb.v"), bench);
                continue;
            }
            other => {
                let expected =
                    format!("expected {GATHERING_UNIT}, {VECTOR_UNIT} or, with both, {NPU_EXT}");
                return Err(RtlError::Usage(format!("no bench for {other}: {expected}")));
            }
        };
        suite.ports.module = top;
        files.extend(files_of(&suite, unit, &makefile::commands(unit))?.texts);
    }
    Ok(files)
}

/// Streams of a trace and expected outputs, with testbenches. `emit` is the command that writes the
/// units, without the folder.
///
/// # Errors
/// Tasks that the units cannot take.
pub fn readmemh(
    config: &Config,
    traced: &[Gathered],
    computed: &[Computed],
    emit: &str,
) -> Result<BenchFiles, RtlError> {
    let mut files = BenchFiles::default();
    let mut add = |unit: &str, suite: &Suite| -> Result<(), RtlError> {
        let made = files_of(suite, unit, &makefile::of_trace(emit, unit))?;
        files.texts.extend(made.texts);
        files.memories.extend(made.memories);
        Ok(())
    };
    if !traced.is_empty() {
        let tasks: Vec<_> = traced.iter().map(|g| g.task.clone()).collect();
        let mut suite = gather_suite(config)?;
        let mut from = 0;
        for tasks in runs(&tasks) {
            let own = &traced[from..from + tasks.len()];
            let features: Vec<i32> = own.iter().flat_map(|g| &g.features).copied().collect();
            let (_, flags) = gathered(config, tasks)?;
            let garbage = &mut Garbage::new(SEED);
            suite
                .jobs
                .push(gather::job(config, tasks, &features, flags, garbage)?);
            from += tasks.len();
        }
        add(GATHERING_UNIT, &suite)?;
    }
    if !computed.is_empty() {
        let mut batches = vec![];
        for Computed { op, a, b, .. } in computed {
            batches.push(VectorBatch { op: *op, a, b });
        }
        let results: Vec<i32> = computed.iter().flat_map(|c| c.out.clone()).collect();
        let mut suite = vector_suite(config)?;
        let garbage = &mut Garbage::new(SEED);
        // Renderers send nothing that raises a flag.
        let expected = (&*results, 0);
        let job = vector::job(config, &suite.ports, &batches, expected, garbage, false)?;
        suite.jobs.push(job);
        add(VECTOR_UNIT, &suite)?;
    }
    Ok(files)
}

/// A bench and its memories. `commands` are the command lines that run it.
fn files_of(suite: &Suite, unit: &str, commands: &[String]) -> Result<BenchFiles, RtlError> {
    let memories = suite.memories()?;
    let mut files = BenchFiles::default();
    let bench = text::Bench::new(unit, suite, &memories, commands).text();
    files.texts.insert(format!("{unit}_tb.v"), bench);
    let Memories {
        inputs,
        output,
        jobs,
        script,
        ..
    } = memories;
    let all = inputs.into_iter().chain([output, jobs]).chain(script);
    for (name, memory) in all {
        files.memories.insert(name.clone(), memory.description());
        files.texts.insert(name, memory.text);
    }
    Ok(files)
}

fn gather_suite(config: &Config) -> Result<Suite, RtlError> {
    suite(
        &gathering_unit(config)?,
        "gather",
        gather::steady(config),
        Owes::Packets,
    )
}

fn vector_suite(config: &Config) -> Result<Suite, RtlError> {
    suite(
        &vector_unit(config)?,
        "vector",
        vector::steady(config),
        Owes::Beats,
    )
}

fn suite(
    module: &Arc<Module>,
    prefix: &'static str,
    steady: Vec<&'static str>,
    owes: Owes,
) -> Result<Suite, RtlError> {
    Ok(Suite {
        ports: UnitPorts::of(module)?,
        prefix,
        jobs: vec![],
        steady,
        owes,
        patience: PATIENCE,
        script: None,
        broken: vec![],
    })
}

fn edges_of_gathers(config: &Config) -> Result<Suite, RtlError> {
    let mut suite = gather_suite(config)?;
    let mut garbage = Garbage::new(SEED);
    let of = |edge: &Edge, garbage: &mut Garbage| {
        let (features, flags) = gathered(config, &edge.tasks)?;
        gather::edge(config, edge, &features, flags, garbage)
    };
    for tasks in gather_tasks::jobs(config, SEED) {
        suite.jobs.push(of(&Edge::plain(tasks), &mut garbage)?);
    }
    // Equal beats have equal bytes that are not kept, and lie in the memories once.
    for edge in gather_edges::jobs(config, SEED) {
        suite.jobs.push(of(&edge, &mut Garbage::new(SEED))?);
    }
    let script = gather_flags::script(config);
    suite.broken = script.broken(&suite.ports);
    suite.script = Some(script);
    Ok(suite)
}

fn edges_of_vectors(config: &Config) -> Result<Suite, RtlError> {
    let mut suite = vector_suite(config)?;
    let mut garbage = Garbage::new(SEED);
    let mut of = |ports: &UnitPorts, own: &[Batch]| {
        let (results, flags) = computed_by_twin(config, own)?;
        let batches: Vec<_> = own.iter().map(Batch::borrowed).collect();
        vector::job(
            config,
            ports,
            &batches,
            (&results, flags),
            &mut garbage,
            true,
        )
    };
    for own in vector_operands::jobs(config, SEED) {
        let job = of(&suite.ports, &own)?;
        suite.jobs.push(job);
    }
    let room = VectorTiming::new(config)?.room as usize;
    let own = vector_flags::batches(config, room.clamp(9, 30));
    for break_promises in [vector_flags::tear, vector_flags::strip] {
        let mut job = of(&suite.ports, &own)?;
        break_promises(&mut job, config);
        suite.jobs.push(job);
    }
    // A vector alone, as many as have room, and more.
    for vectors in [1, room, room + 9] {
        let own = vector_flags::batches(config, vectors);
        let mut job = of(&suite.ports, &own)?;
        let batches: Vec<_> = own.iter().map(Batch::borrowed).collect();
        vector::close(&mut job, config, &batches)?;
        suite.jobs.push(job);
    }
    let script = vector_flags::script(config);
    suite.broken = script.broken(&suite.ports);
    suite.script = Some(script);
    Ok(suite)
}

fn edges_of_splats(config: &Config) -> Result<Suite, RtlError> {
    let Some(su) = &config.su else {
        let text = "no bench for the splat unit: the configuration has no table [su]";
        return Err(RtlError::Usage(text.to_owned()));
    };
    let mut suite = suite(
        &splat_unit(config, su)?,
        "splat",
        splats::STEADY.to_vec(),
        Owes::Packets,
    )?;
    let mut garbage = Garbage::new(SEED);
    suite.jobs = splats::jobs(config, su, &splat_jobs::jobs(su, SEED), &mut garbage)?;
    suite.script = Some(splats::script(su));
    // It clears its tiles after a reset.
    suite.patience += su.tiles * TILE_PIXELS as u32;
    Ok(suite)
}

/// Results of all elements, and the flags that they raise, by the reference unit.
fn computed_by_twin(config: &Config, batches: &[Batch]) -> Result<(Vec<i32>, u64), RtlError> {
    let twin = ReferenceVectorUnit::new(&config.vu);
    let (mut results, mut flags) = (vec![], 0);
    for Batch { op, a, b } in batches {
        let mut out = vec![0; a.len()];
        let computed = twin.slice(*op, a, b, &mut out);
        computed.map_err(|error| RtlError::Usage(error.to_string()))?;
        results.extend(out);
        if twin.within(op.code, a, b).is_err() {
            flags |= vector_flags::BEYOND;
        }
    }
    Ok((results, flags))
}

/// Features (or sums) and flags of tasks, by the reference unit.
fn gathered(config: &Config, tasks: &[GatherTask]) -> Result<(Vec<i32>, u64), RtlError> {
    let twin = ReferenceGatheringUnit::new(config);
    let (mut codes, mut sums, mut flags) = (vec![], vec![], 0);
    for task in tasks {
        let raised = match config.gu.sums {
            Sums::Rounded => twin.gather(task, &mut codes),
            Sums::Exact => twin.sums(task, &mut sums),
        };
        flags |= raised.map_err(|error| RtlError::Usage(error.to_string()))?;
    }
    sums.extend(codes.into_iter().map(i32::from));
    Ok((sums, u64::from(flags)))
}
