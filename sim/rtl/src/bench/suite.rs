//! Jobs of a unit, and the files that hold them.

use std::collections::BTreeMap;
use std::ops::Range;

use super::beat::{Beat, unknown};
use super::job::Job;
use super::memory::{Memory, MemoryFile};
use super::ports::{Stream, UnitPorts};
use super::script::{Broken, Script};
use crate::RtlError;

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
    /// Clocks without a beat after which a unit counts as hanging.
    pub(super) patience: u32,
    /// Clocks after the last job, in which promises are broken.
    pub(super) script: Option<Script>,
    /// Beats of the script that raise one flag each, for the bench of the SoC top.
    pub(super) broken: Vec<Broken>,
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
    pub(super) script: Option<(String, Memory)>,
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
const CLOSED_BITS: u32 = 16;

impl Suite {
    pub(super) fn memories(&self) -> Result<Memories, RtlError> {
        let name = |short: &str| format!("{}_{short}.hex", self.prefix);
        let ports = &self.ports;
        let single = ports.inputs.len() == 1;
        let mut streams: Vec<_> = ports.inputs.iter().chain([&ports.output]).collect();
        let mut memories: Vec<_> = streams
            .iter()
            .map(|stream| Memory::new(stream.fields.clone()))
            .collect();
        let mut places = vec![];
        for job in self.all() {
            let mut own = vec![];
            let beats = job.inputs.iter().chain([&job.output]);
            for ((stream, memory), beats) in streams.iter().zip(&mut memories).zip(beats) {
                let mut words = Memory::new(stream.fields.clone());
                for beat in beats {
                    words.push(fields_of(&stream.fields, beat)?);
                }
                own.push(memory.place(&words));
            }
            places.push(own);
        }
        let output = memories.pop().zip(streams.pop());
        let output = output.ok_or_else(|| unknown("m_axis_*"))?.0;
        let short = |stream: &Stream| name(if single { "in" } else { stream.short() });
        let names = streams.into_iter().map(short);
        let short = if single { "out" } else { ports.output.short() };
        let script = self.script.as_ref();
        let script = script.map(|script| script.memory(ports)).transpose()?;
        Ok(Memories {
            inputs: names.zip(memories).collect(),
            output: (name(short), output),
            jobs: (name("jobs"), self.job_memory(&places)?),
            script: script.map(|memory| (name("flags"), memory)),
        })
    }

    /// The jobs, and then those that break promises.
    fn all(&self) -> impl Iterator<Item = &Job> {
        let broken = self.broken.iter().map(|broken| &broken.job);
        self.jobs.iter().chain(broken)
    }

    /// `places` are those of the beats of every job.
    fn job_memory(&self, places: &[Vec<Range<usize>>]) -> Result<Memory, RtlError> {
        let ports = &self.ports;
        let mut fields: Vec<_> = ports.settings.clone();
        for stream in ports.inputs.iter().chain([&ports.output]) {
            let ends = ["from", "end"].map(|end| (format!("{}_{end}", stream.name), END_BITS));
            fields.extend(ends);
        }
        fields.push(("closed".to_owned(), CLOSED_BITS));
        fields.push(("cycles".to_owned(), END_BITS));
        fields.extend(ports.stats.clone());
        let mut memory = Memory::new(fields);
        for (job, places) in self.all().zip(places) {
            let mut values = vec![];
            for (name, _) in &ports.settings {
                let own = job.settings.iter().find(|(own, _)| own == name);
                values.push(own.ok_or_else(|| unknown(name))?.1);
            }
            let ends = places.iter().flat_map(|place| [place.start, place.end]);
            values.extend(ends.map(|end| end as u64));
            values.push(u64::from(job.closed));
            values.push(job.cycles);
            for (name, _) in &ports.stats {
                let value = job.stats.get(&**name).copied();
                let none = job.stats.is_empty().then_some(0);
                values.push(value.or(none).ok_or_else(|| unknown(name))?);
            }
            memory.push_values(&values);
        }
        Ok(memory)
    }
}

fn fields_of<'a>(fields: &[(String, u32)], beat: &'a Beat) -> Result<Vec<&'a [u32]>, RtlError> {
    let value = |(name, _): &(String, u32)| {
        beat.get(&**name)
            .map(Vec::as_slice)
            .ok_or_else(|| unknown(name))
    };
    fields.iter().map(value).collect()
}
