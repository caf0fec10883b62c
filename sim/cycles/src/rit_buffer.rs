//! The RIT buffer of the gathering unit, one clock cycle a call: writes, reads, and release of its
//! halves.

use potamoi_formats::config::Config;
use potamoi_formats::rit::{MAX_VERTICES, Vertices, WORD_BYTES};

use super::work::RitBeat;

/// One half of the RIT buffer; free until it is closed.
#[derive(Debug, Clone, Copy, Default)]
struct RitHalf {
    bytes: u64,
    closed: bool,
    ends_mvoxel: bool,
    again: bool,
    /// Its last beat carries no bytes and ends no open group: it is closed by a group without
    /// entries.
    bare_group: bool,
}

/// A vertex of a group between the RIT buffer and the MFT.
#[derive(Debug, Clone, Copy)]
pub(super) struct Picked {
    pub(super) vertex: u32,
    /// Entries in the group.
    pub(super) kept: u32,
    pub(super) first_group: bool,
    /// The last group of an MVoxel and segment.
    pub(super) last_group: bool,
}

/// Read position in the RIT buffer.
#[derive(Debug, Clone, Copy, Default)]
struct Reader {
    half: usize,
    group: u64,
    vertex: u32,
    /// Completed passes over the MVoxel.
    pass: u32,
    /// First half of the MVoxel, where every pass starts.
    start: usize,
    /// Whether this pass has begun.
    under_way: bool,
}

/// The RIT buffer with the pipeline stages after it.
#[derive(Debug, Clone)]
pub(super) struct RitBuffer {
    half_bytes: u64,
    ports: u64,
    /// Bytes of an entry.
    entry: u64,
    /// Cycles in which a group is issued.
    issues: u32,
    segments: u32,
    rit: [RitHalf; 2],
    rit_writer: usize,
    reader: Reader,
    /// The stages from the banks' output to the issue.
    stages: Vec<Option<Picked>>,
}

impl RitBuffer {
    pub(super) fn new(config: &Config, vertices: Vertices, segments: u32) -> Self {
        Self {
            half_bytes: u64::from(config.rit.entries) * (MAX_VERTICES * WORD_BYTES) as u64,
            ports: u64::from(config.gu.ports),
            entry: config.entry_bytes(vertices) as u64,
            issues: config.issue_cycles(vertices),
            segments,
            rit: [RitHalf::default(); 2],
            rit_writer: 0,
            reader: Reader::default(),
            stages: vec![None; config.rit_pipeline().cycles() as usize],
        }
    }

    /// `s_axis_rit_tready` in the next cycle.
    pub(super) const fn ready(&self) -> bool {
        !self.rit[self.rit_writer].closed
    }

    pub(super) fn is_idle(&self) -> bool {
        self.rit.iter().all(|h| h.bytes == 0 && !h.closed)
            && self.stages.iter().all(Option::is_none)
    }

    /// Output of the last stage.
    pub(super) fn offered(&self) -> Option<Picked> {
        self.stages.last().copied().flatten()
    }

    /// One clock cycle; `taken` tells whether the last stage's output is consumed.
    pub(super) fn step(&mut self, taken: bool, beat: Option<RitBeat>) {
        let ready = self.ready();
        // The reader looks at the halves as the cycle before left them, so it
        // goes before the writer.
        let last = self.stages.len() - 1;
        if taken {
            self.stages[last] = None;
        }
        for stage in (1..=last).rev() {
            if self.stages[stage].is_none() {
                self.stages[stage] = self.stages[stage - 1].take();
            }
        }
        if self.stages[0].is_none() {
            self.stages[0] = self.read();
        }
        if let Some(beat) = beat.filter(|_| ready) {
            self.write_rit(beat);
        }
    }

    fn write_rit(&mut self, beat: RitBeat) {
        // One that is neither last nor brings anything leaves nothing that the next does not set.
        let null = beat.halfwords == 0;
        let half = &mut self.rit[self.rit_writer];
        half.bytes += 2 * u64::from(beat.halfwords);
        half.again = beat.again;
        half.bare_group = null && half.bytes.is_multiple_of(self.ports * self.entry);
        if beat.last || half.bytes >= self.half_bytes {
            half.closed = true;
            half.ends_mvoxel = beat.last;
            self.rit_writer ^= 1;
        }
    }

    /// Reads the next vertex if its group is readable. Releases its half after the last vertex
    /// needed from it.
    fn read(&mut self) -> Option<Picked> {
        let half = self.rit[self.reader.half];
        let entries = half.bytes / self.entry;
        let groups = if half.closed {
            entries.div_ceil(self.ports) + u64::from(half.bare_group)
        } else {
            entries / self.ports
        };
        let at = &mut self.reader;
        if at.group >= groups {
            return None;
        }
        let last_of_half = half.closed && at.group + 1 == groups;
        let picked = Picked {
            vertex: at.vertex,
            kept: entries
                .saturating_sub(at.group * self.ports)
                .min(self.ports) as u32,
            first_group: !at.under_way,
            last_group: last_of_half && half.ends_mvoxel,
        };
        at.vertex += 1;
        if at.vertex < self.issues {
            return Some(picked);
        }
        at.vertex = 0;
        at.group += 1;
        at.under_way = true;
        if !last_of_half {
            return Some(picked);
        }
        at.group = 0;
        let last_pass = half.again || at.pass + 1 >= self.segments;
        if last_pass {
            self.rit[at.half] = RitHalf::default();
        }
        at.half ^= 1;
        if half.ends_mvoxel {
            at.under_way = false;
            if last_pass {
                at.pass = 0;
                at.start = at.half;
            } else {
                at.pass += 1;
                at.half = at.start;
            }
        }
        Some(picked)
    }
}
