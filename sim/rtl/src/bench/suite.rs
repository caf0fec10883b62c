//! Jobs of a unit, and the files that hold them.

use std::collections::BTreeMap;

use super::memory::{Memory, MemoryFile};
use super::ports::UnitPorts;
use crate::RtlError;

/// Payload of a beat: words, low first, by field.
pub(super) type Beat = BTreeMap<&'static str, Vec<u32>>;

/// Work between two changes of the settings, and what must come of it.
#[derive(Debug, Clone, Default)]
pub(super) struct Job {
    pub(super) title: String,
    /// Values of the settings' ports.
    pub(super) settings: Vec<(&'static str, u64)>,
    /// Beats of the inputs, in the order of the unit's streams.
    pub(super) inputs: Vec<Vec<Beat>>,
    pub(super) output: Vec<Beat>,
    /// Cycles from the first in which the sources offer a beat to that in which the sink takes the
    /// last one, both included, with sources and sink always ready.
    pub(super) cycles: u64,
    /// Counters and flags afterwards, with sources and sink always ready.
    pub(super) stats: BTreeMap<&'static str, u64>,
}

/// Jobs of a unit.
pub(super) struct Suite {
    pub(super) ports: UnitPorts,
    /// Begin of the names of the files.
    pub(super) prefix: &'static str,
    pub(super) jobs: Vec<Job>,
    /// Counters that gaps of the streams do not change.
    pub(super) steady: Vec<&'static str>,
    /// What is owed while the unit is not idle.
    pub(super) owes: Owes,
}

/// How a bench knows that a unit cannot be idle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Owes {
    /// A packet of an input is open, or a packet of the table gave none of features.
    Packets,
    /// Every beat gives one.
    Beats,
}

/// The memories of a suite.
pub(super) struct Memories {
    pub(super) inputs: Vec<(String, Memory)>,
    pub(super) output: (String, Memory),
    pub(super) jobs: (String, Memory),
}

/// Generated files.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct BenchFiles {
    /// Text of every file by name: memories and testbenches.
    pub texts: BTreeMap<String, String>,
    /// Description of every memory file by name.
    pub memories: BTreeMap<String, MemoryFile>,
}

const END_BITS: u32 = 32;

impl Suite {
    pub(super) fn memories(&self) -> Result<Memories, RtlError> {
        let name = |short: &str| format!("{}_{short}.hex", self.prefix);
        let ports = &self.ports;
        let single = ports.inputs.len() == 1;
        let mut inputs = vec![];
        for (i, stream) in ports.inputs.iter().enumerate() {
            let mut memory = Memory::new(stream.fields.clone());
            for beat in self.jobs.iter().flat_map(|job| &job.inputs[i]) {
                memory.push(fields_of(&stream.fields, beat)?);
            }
            let short = if single { "in" } else { stream.short() };
            inputs.push((name(short), memory));
        }
        let mut output = Memory::new(ports.output.fields.clone());
        for beat in self.jobs.iter().flat_map(|job| &job.output) {
            output.push(fields_of(&ports.output.fields, beat)?);
        }
        let short = if single { "out" } else { ports.output.short() };
        Ok(Memories {
            inputs,
            output: (name(short), output),
            jobs: (name("jobs"), self.job_memory()?),
        })
    }

    fn job_memory(&self) -> Result<Memory, RtlError> {
        let ports = &self.ports;
        let mut fields: Vec<_> = ports.settings.clone();
        let ends = ports.inputs.iter().chain([&ports.output]);
        fields.extend(ends.map(|s| (format!("{}_end", s.name), END_BITS)));
        fields.push(("cycles".to_owned(), END_BITS));
        fields.extend(ports.stats.clone());
        let mut memory = Memory::new(fields);
        let mut ends = vec![0; ports.inputs.len() + 1];
        for job in &self.jobs {
            let counts = job.inputs.iter().chain([&job.output]).map(Vec::len);
            ends.iter_mut().zip(counts).for_each(|(end, n)| *end += n);
            let mut values = vec![];
            for (name, _) in &ports.settings {
                let own = job.settings.iter().find(|(own, _)| own == name);
                values.push(own.ok_or_else(|| unknown(name))?.1);
            }
            values.extend(ends.iter().map(|end| *end as u64));
            values.push(job.cycles);
            for (name, _) in &ports.stats {
                values.push(*job.stats.get(&**name).ok_or_else(|| unknown(name))?);
            }
            let words: Vec<_> = values
                .iter()
                .map(|v| [*v as u32, (*v >> 32) as u32])
                .collect();
            memory.push(words.iter().map(|w| &w[..]));
        }
        Ok(memory)
    }
}

fn unknown(port: &str) -> RtlError {
    RtlError::Usage(format!("the benches know no value of the port {port}"))
}

fn fields_of<'a>(fields: &[(String, u32)], beat: &'a Beat) -> Result<Vec<&'a [u32]>, RtlError> {
    let value = |(name, _): &(String, u32)| {
        beat.get(&**name)
            .map(Vec::as_slice)
            .ok_or_else(|| unknown(name))
    };
    fields.iter().map(value).collect()
}
