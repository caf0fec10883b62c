//! Jobs of the vector unit as beats.

use potamoi_cycles::{Exponents, VectorInputs, VectorModel};
use potamoi_formats::config::Config;

use super::beat::Beat;
use super::garbage::Garbage;
use super::job::Job;
use super::ports::UnitPorts;
use crate::RtlError;
use crate::vector_drive::{VectorBatch, Vectors};

/// The job of batches. `results` are those of all elements, and `flags` what they raise. The elements of a vector lie in its
/// first lanes, or scattered.
///
/// # Errors
/// Operands of different lengths.
pub(super) fn job(
    config: &Config,
    ports: &UnitPorts,
    batches: &[VectorBatch<'_>],
    (results, flags): (&[i32], u64),
    garbage: &mut Garbage,
    scattered: bool,
) -> Result<Job, RtlError> {
    let lanes = config.vu.lanes as usize;
    let vectors = Vectors::new(batches, lanes, &Exponents::of(config))?;
    let (cycles, counters) = run(config, &vectors, 0)?;
    let input = ports.input("vec");
    let [given_bits, wanted_bits] =
        [input, Some(&ports.output)].map(|s| s.map_or(0, |s| s.width("tkeep")) as usize / lanes);
    let (mut given, mut wanted) = (vec![], vec![]);
    for v in &vectors.list {
        let chosen = match scattered {
            true => garbage.lanes(v.a.len(), lanes),
            false => (0..v.a.len()).collect(),
        };
        let keep = |bits: usize| {
            let mut keep = vec![0u32; (lanes * bits).div_ceil(32)];
            for bit in chosen
                .iter()
                .flat_map(|lane| lane * bits..(lane + 1) * bits)
            {
                keep[bit / 32] |= 1 << (bit % 32);
            }
            keep
        };
        let mut data = vec![0u32; 2 * lanes];
        for (lane, (a, b)) in chosen.iter().zip(v.a.iter().zip(v.b)) {
            data[2 * lane] = *a as u32;
            data[2 * lane + 1] = *b as u32;
        }
        let kept = keep(given_bits);
        garbage.fill(&mut data, &kept, 64 / given_bits.max(1));
        let last = vec![u32::from(v.last)];
        given.push(Beat::from([
            ("tuser", vec![u32::from(v.op.field())]),
            ("tlast", last.clone()),
            ("tkeep", kept),
            ("tdata", data),
        ]));
        let mut out = vec![0; lanes];
        for (lane, result) in chosen.iter().zip(results.iter().skip(v.ordinal)) {
            out[*lane] = *result as u32;
        }
        wanted.push(Beat::from([
            ("tlast", last),
            ("tkeep", keep(wanted_bits)),
            ("tdata", out),
        ]));
    }
    let [vectors_in, busy, stall_out] = counters;
    Ok(Job {
        title: title(batches, vectors.list.len()),
        settings: vec![],
        inputs: vec![given],
        output: wanted,
        closed: 0,
        cycles,
        stats: [
            ("stat_vectors", vectors_in),
            ("stat_busy", busy),
            ("stat_stall_out", stall_out),
            ("stat_errors", flags),
        ]
        .into(),
    })
}

fn title(batches: &[VectorBatch<'_>], vectors: usize) -> String {
    let mut names: Vec<_> = batches.iter().map(|b| b.op.code.name()).collect();
    names.dedup();
    names.truncate(9);
    format!("{vectors} vectors: {}", names.join(", "))
}

/// Counters that gaps do not change. In a pipeline, vectors that follow closely share busy cycles.
pub(super) fn steady(config: &Config) -> Vec<&'static str> {
    let all = ["stat_vectors", "stat_errors", "stat_busy"];
    all[..if config.vu.exp.pipelined { 2 } else { 3 }].to_vec()
}

/// The same job, with a sink that takes nothing for some cycles: more than fill the unit.
///
/// # Errors
/// A configuration that breaks its rules.
pub(super) fn close(
    job: &mut Job,
    config: &Config,
    batches: &[VectorBatch<'_>],
) -> Result<(), RtlError> {
    let vectors = Vectors::new(batches, config.vu.lanes as usize, &Exponents::of(config))?;
    job.closed = 3 * vectors.list.len() as u32;
    let (cycles, [accepted, busy, stall_out]) = run(config, &vectors, job.closed)?;
    job.cycles = cycles;
    job.stats.insert("stat_vectors", accepted);
    job.stats.insert("stat_busy", busy);
    job.stats.insert("stat_stall_out", stall_out);
    job.title += ", and a sink that is closed for long";
    Ok(())
}

/// Cycles and counters by the stepwise model, with a source that is always ready, and a sink that is so
/// after some cycles.
pub(super) fn run(
    config: &Config,
    vectors: &Vectors<'_>,
    closed: u32,
) -> Result<(u64, [u64; 3]), RtlError> {
    let mut model = VectorModel::new(config)?;
    let mut next = vectors.list.iter().peekable();
    let (mut taken, mut cycles) = (0, 0);
    while taken < vectors.list.len() {
        let offered = next.peek();
        let outputs = model.step(&VectorInputs {
            op: offered.map(|v| v.op.code.code()),
            exponent: offered.map_or(0, |v| v.exponent),
            ready: cycles >= u64::from(closed),
        });
        if outputs.ready {
            next.next();
        }
        taken += usize::from(outputs.valid && cycles >= u64::from(closed));
        cycles += 1;
    }
    let last = model.step(&VectorInputs::default());
    Ok((
        cycles,
        [last.vectors, last.busy, last.stall_out].map(u64::from),
    ))
}
