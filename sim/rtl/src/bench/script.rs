//! Clocks in which promises are broken, and the flags that must be up, or down, after each.

use super::beat::{Beat, unknown};
use super::job::Job;
use super::memory::Memory;
use super::ports::UnitPorts;
use crate::RtlError;

/// Bits of the number of clocks that a word stands for.
const TIMES_BITS: u32 = 16;

/// Inputs of some clocks, and what must come of them.
#[derive(Debug, Clone, Default)]
pub(super) struct Clock {
    pub(super) reset: bool,
    pub(super) clear: bool,
    /// The beat of every input, without its data.
    pub(super) beats: Vec<Option<Beat>>,
    /// Values of the settings' ports.
    pub(super) settings: Vec<(&'static str, u64)>,
    /// Number of such clocks.
    pub(super) times: u32,
    /// Flags that are up after each of them.
    pub(super) up: u64,
    /// Flags that are down after each of them.
    pub(super) down: u64,
}

/// Such clocks, one after the other, with a sink that is always ready.
#[derive(Debug, Clone, Default)]
pub(super) struct Script {
    pub(super) clocks: Vec<Clock>,
}

/// Beats that raise one flag.
#[derive(Debug, Clone)]
pub(super) struct Broken {
    /// The beats, with the settings that stay. It gives no output that is compared.
    pub(super) job: Job,
    /// The flag.
    pub(super) up: u64,
    /// Flags that are down afterwards.
    pub(super) down: u64,
}

/// Fields of a beat that a script has: all but the data, which are 0.
pub(super) fn is_scripted(field: &str) -> bool {
    field != "tdata"
}

impl Script {
    /// Fields of a word of the script, highest first.
    pub(super) fn fields(ports: &UnitPorts) -> Vec<(String, u32)> {
        let mut fields = vec![("rst_n".to_owned(), 1), ("cfg_clear".to_owned(), 1)];
        fields.extend(ports.settings.clone());
        for stream in &ports.inputs {
            fields.push((format!("{}_tvalid", stream.name), 1));
            let own = stream.fields.iter().filter(|field| is_scripted(&field.0));
            fields.extend(own.map(|(field, bits)| (format!("{}_{field}", stream.name), *bits)));
        }
        fields.push(("times".to_owned(), TIMES_BITS));
        let flags = ports.stats.iter().find(|stat| stat.0 == "stat_errors");
        let flags = flags.map_or(1, |stat| stat.1);
        fields.extend(["up", "down"].map(|name| (name.to_owned(), flags)));
        fields
    }

    /// For every flag the first beats after a reset, or a clear, that raise it alone, under settings that
    /// stay.
    pub(super) fn broken(&self, ports: &UnitPorts) -> Vec<Broken> {
        let mut all: Vec<Broken> = vec![];
        for clocks in self.clocks.split(|clock| clock.reset || clock.clear) {
            let (Some(first), Some(last)) = (clocks.first(), clocks.last()) else {
                continue;
            };
            let steady = clocks.iter().all(|own| own.settings == first.settings);
            let known = all.iter().any(|own| own.up == last.up);
            if last.up.count_ones() != 1 || !steady || known {
                continue;
            }
            let of_input = |i: usize| {
                let beats = clocks.iter().flat_map(|clock| {
                    let beat = clock.beats.get(i).cloned().flatten();
                    std::iter::repeat_n(beat, clock.times.max(1) as usize)
                });
                beats.flatten().map(whole).collect()
            };
            all.push(Broken {
                job: Job {
                    settings: first.settings.clone(),
                    inputs: (0..ports.inputs.len()).map(of_input).collect(),
                    ..Job::default()
                },
                up: last.up,
                down: last.down,
            });
        }
        all
    }

    pub(super) fn memory(&self, ports: &UnitPorts) -> Result<Memory, RtlError> {
        let mut memory = Memory::new(Self::fields(ports));
        for clock in &self.clocks {
            let mut words = vec![];
            words.push(vec![u32::from(!clock.reset)]);
            words.push(vec![u32::from(clock.clear)]);
            for (name, _) in &ports.settings {
                let own = clock.settings.iter().find(|(own, _)| own == name);
                words.push(vec![own.ok_or_else(|| unknown(name))?.1 as u32]);
            }
            for (i, stream) in ports.inputs.iter().enumerate() {
                let beat = clock.beats.get(i).and_then(Option::as_ref);
                words.push(vec![u32::from(beat.is_some())]);
                let fields = stream.fields.iter().filter(|field| is_scripted(&field.0));
                for (field, _) in fields {
                    let value = beat.and_then(|beat| beat.get(&**field));
                    words.push(value.cloned().unwrap_or_default());
                }
            }
            words.push(vec![clock.times.max(1)]);
            words.extend([clock.up, clock.down].map(|flags| vec![flags as u32]));
            memory.push(words.iter().map(Vec::as_slice));
        }
        Ok(memory)
    }
}

/// A beat of a script with all fields that a stream may have.
fn whole(mut beat: Beat) -> Beat {
    for field in ["tdata", "tkeep", "tlast", "tuser"] {
        beat.entry(field).or_default();
    }
    beat
}

/// Bytes that are kept, as the words of `tkeep`.
pub(super) fn keep_of(bytes: usize, kept: impl Fn(usize) -> bool) -> Vec<u32> {
    let mut keep = vec![0u32; bytes.div_ceil(32)];
    for byte in (0..bytes).filter(|byte| kept(*byte)) {
        keep[byte / 32] |= 1 << (byte % 32);
    }
    keep
}
