//! Closed-form cycles for each MVoxel, with sources and sink always ready.
//!
//! With a ready sink the FIFO never causes back-pressure, so the times of a gathering unit obey
//! recurrences of maxima and sums. The entries of one RIT half are summed at once: the groups of a
//! stream that keeps up wait at most for the first of them, and those of a slower stream for the
//! last. [`gather_cycles`] is therefore *exact*: it equals the stepwise model, stall by stall.
//! [`overlapped_cycles`] is the plain formula of double buffering; its error is stated there.

use potamoi_formats::config::Config;
use potamoi_formats::rit::Vertices;
use potamoi_formats::units::OpCode;

use super::bank_rounds::Rounds;
use super::exponential::Exponents;
use super::split_banks::{SplitRun, check_no_turns};
use super::vector_unit::VectorTiming;
use super::work::{GatherRun, Mvoxel, WorkError, check_channel_major};

/// Cycles of a run of the gathering unit, with sources and sink ready from cycle 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct GatherCycles {
    /// Cycles from the first accepted RIT beat to the first issue.
    pub fill: u64,
    /// Busy cycles, in which a vertex is issued.
    pub busy: u64,
    /// Stall cycles with the MFT half not loaded.
    pub stall_mft: u64,
    /// Stall cycles without an entry read.
    pub stall_rit: u64,
    /// Cycles in which lanes wait for a bank (feature-major organisation), or ports for their turn.
    pub stall_bank: u64,
    /// Cycles from the first accepted beat to the last accepted feature, inclusive: fill, issue and
    /// latency.
    pub elapsed: u64,
}

impl GatherCycles {
    /// Cycles from the first to the last issue, inclusive.
    #[must_use]
    pub const fn issue_span(&self) -> u64 {
        self.busy + self.stall_mft + self.stall_rit + self.stall_bank
    }
}

/// Entries of an MVoxel in one RIT half, and the cycle of their write.
#[derive(Debug, Clone, Copy)]
pub(super) struct Part {
    bytes: u64,
    pub(super) groups: u64,
    /// Cycle in which its first beat is accepted.
    written: u64,
}

/// Vertices whose times are kept: the largest number of stages of any reader.
const KEPT: usize = 8;

/// Reader and issue, group by group.
///
/// Vertex `j` is issued in `x(j) = max(readable + d, x(j-1) + 1, loaded)`, where `d` is the number
/// of stages from the buffer to the issue: only earlier issues delay it on the way. It is read in
/// `r(j) = max(readable, r(j-1) + 1, x(j-d))`: the stages hold `d` vertices.
pub(super) struct Chain {
    /// Cycles in which a group is issued.
    issues: u64,
    /// Pipeline stages from the buffer to the issue.
    stages: usize,
    beat: u64,
    group_bytes: u64,
    /// Cycles of the latest issues, newest first.
    issued: [u64; KEPT],
    /// Whether anything was issued.
    begun: bool,
    /// Cycle in which the latest vertex was read.
    pub(super) read: u64,
    out: GatherCycles,
}

impl Chain {
    pub(super) fn new(config: &Config, vertices: Vertices) -> Self {
        Self {
            issues: u64::from(config.issue_cycles(vertices)),
            stages: config.rit_pipeline().cycles() as usize,
            beat: u64::from(config.rit_stream_bits() / 8),
            group_bytes: u64::from(config.gu.ports) * config.entry_bytes(vertices) as u64,
            issued: [0; KEPT],
            begun: false,
            read: 0,
            out: GatherCycles::default(),
        }
    }

    /// Writes so many entries into the next half of the RIT buffer.
    pub(super) fn write(&self, rit: &mut Halves, entries: u64, ports: u64) -> Part {
        let bytes = self.group_bytes / ports * entries;
        Part {
            bytes,
            groups: entries.div_ceil(ports),
            written: rit.write(bytes.div_ceil(self.beat)),
        }
    }

    /// First cycle in which group `index` of a part can be read.
    pub(super) const fn readable(&self, part: &Part, index: u64) -> u64 {
        let end = (index + 1) * self.group_bytes;
        let end = if end < part.bytes { end } else { part.bytes };
        part.written + end.div_ceil(self.beat)
    }

    /// Advances one vertex that is readable from `readable`.
    fn vertex(&mut self, readable: u64, issue: u64) {
        let behind = self.issued[self.stages - 1];
        let next = if self.begun { self.read + 1 } else { 0 };
        self.read = readable.max(next).max(behind);
        self.issued.rotate_right(1);
        self.issued[0] = issue;
        self.begun = true;
    }

    /// Advances one group that is readable from `readable` and may be issued from `loaded`.
    pub(super) fn group(&mut self, readable: u64, loaded: u64) {
        let x = self.begin(readable, loaded);
        for i in 0..self.issues {
            self.vertex(readable, x + i);
        }
    }

    /// Advances one group whose vertices take so many turns each.
    fn group_in_turns(&mut self, readable: u64, loaded: u64, turns: &[u16]) {
        let mut next = self.begin(readable, loaded);
        for &turns in turns {
            let turns = u64::from(turns);
            self.out.stall_bank += turns - 1;
            self.vertex(readable, next + turns - 1);
            next += turns;
        }
    }

    /// Cycle in which a group is first issued.
    fn begin(&mut self, readable: u64, loaded: u64) -> u64 {
        let arrives = readable + self.stages as u64;
        if self.begun {
            let next = self.issued[0] + 1;
            let x = arrives.max(next).max(loaded);
            let mft = loaded.clamp(next, x) - next;
            self.out.stall_mft += mft;
            self.out.stall_rit += x - next - mft;
            x
        } else {
            let x = arrives.max(loaded);
            self.out.fill = x;
            x
        }
    }

    /// Advances every group of a part; the first may be issued from `loaded`.
    fn part(&mut self, part: &Part, loaded: u64, turns: Option<&[Rounds]>) {
        if let Some(turns) = turns {
            for (index, turns) in (0..part.groups).zip(turns) {
                let loaded = if index == 0 { loaded } else { 0 };
                let turns = &turns[..self.issues as usize];
                self.group_in_turns(self.readable(part, index), loaded, turns);
            }
            return;
        }
        self.group(self.readable(part, 0), loaded);
        // The last ones one by one: the release of the half looks back over
        // as many vertices as there are stages.
        let last = (self.stages as u64 + 1).min(part.groups - 1);
        let between = part.groups - 1 - last;
        if between > 0 {
            // Groups 1 to n, all full. Completion times are concave against
            // issue after issue or convex, never both: an end decides.
            let n = between;
            let stages = self.stages as u64;
            let next = self.issued[0] + 1;
            let at = (self.readable(part, 1) + stages + (n - 1) * self.issues)
                .max(self.readable(part, n) + stages);
            let free = next + (n - 1) * self.issues;
            let x = at.max(free);
            self.out.stall_rit += x - free;
            for i in 0..self.issues {
                self.vertex(self.readable(part, n), x + i);
            }
        }
        for index in part.groups - last..part.groups {
            self.group(self.readable(part, index), 0);
        }
    }

    /// Cycle in which the latest vertex is issued.
    pub(super) fn last_issue(&self) -> u64 {
        self.issued[0]
    }
}

/// Two halves of a double buffer.
#[derive(Default)]
pub(super) struct Halves {
    /// First cycle in which the writer is free.
    writer: u64,
    /// First free cycle of the next half, and of the one after.
    free: [u64; 2],
}

impl Halves {
    /// Starts a write of `beats`. Returns its first cycle.
    pub(super) fn write(&mut self, beats: u64) -> u64 {
        let start = self.writer.max(self.free[0]);
        self.writer = start + beats;
        // Known to the caller before the half is written again.
        self.free = [self.free[1], u64::MAX];
        start
    }

    /// Frees the half written longest ago from `cycle` on.
    pub(super) fn release(&mut self, cycle: u64) {
        let oldest = usize::from(self.free[0] != u64::MAX);
        self.free[oldest] = cycle;
    }
}

/// Exact cycles of a run of the gathering unit with sources and sink always ready.
///
/// Takes time in proportion to the RIT halves read, not to the entries.
///
/// # Errors
/// Work that the unit cannot do.
pub fn gather_cycles(config: &Config, run: &GatherRun<'_>) -> Result<GatherCycles, WorkError> {
    run.check(config)?;
    check_channel_major(config)?;
    check_no_turns(config)?;
    Ok(cycles(config, run, None))
}

/// Exact cycles of a run of a unit whose ports take turns, with sources and sink always ready.
///
/// Takes time in proportion to the entries.
///
/// # Errors
/// Work that the unit cannot do.
pub fn split_cycles(config: &Config, work: &SplitRun<'_>) -> Result<GatherCycles, WorkError> {
    work.check(config)?;
    check_channel_major(config)?;
    Ok(cycles(config, &work.run, Some(work.turns)))
}

/// Cycles of checked work.
fn cycles(config: &Config, run: &GatherRun<'_>, turns: Option<&[Vec<Rounds>]>) -> GatherCycles {
    if run.mvoxels.is_empty() {
        return GatherCycles::default();
    }
    let ports = u64::from(config.gu.ports);
    let half = u64::from(config.rit_entries(run.vertices));
    let mut chain = Chain::new(config, run.vertices);
    chain.out.busy = run.busy(config);
    let (mut rit, mut mft) = (Halves::default(), Halves::default());
    for (at, &mvoxel) in run.mvoxels.iter().enumerate() {
        let again = run.streamed_again(config, mvoxel);
        let parts = u64::from(mvoxel.entries).div_ceil(half);
        let mut kept: [Option<Part>; 2] = [None; 2];
        for segment in 0..run.segments {
            let mut loaded = mft.write(u64::from(mvoxel.rows)) + u64::from(mvoxel.rows);
            for index in 0..parts {
                let part = match kept[(index & 1) as usize].filter(|_| !again) {
                    Some(part) => part,
                    None => {
                        let entries = (u64::from(mvoxel.entries) - index * half).min(half);
                        chain.write(&mut rit, entries, ports)
                    }
                };
                if run.segments > 1 && !again {
                    kept[(index & 1) as usize] = Some(part);
                }
                // A half holds whole groups.
                let turns = turns.map(|turns| &turns[at][(index * half / ports) as usize..]);
                chain.part(&part, std::mem::take(&mut loaded), turns);
                if again || segment + 1 == run.segments {
                    rit.release(chain.read + 1);
                }
            }
            mft.release(chain.last_issue() + 1);
        }
    }
    chain.out.elapsed = chain.last_issue() + u64::from(config.gather_pipeline().cycles()) + 1;
    chain.out
}

/// Cycles from the first to the last issue by the plain formula of double buffering: each pass over
/// an MVoxel takes the longer of its own issue and the load of the next pass's rows.
///
/// Exact if the RIT stream keeps up ([`rit_keeps_up`]) and the first MVoxel's rows take at least
/// the RIT's first fill: 2 cycles and the beats of its first group. With fewer rows it is too high
/// by at most the difference. With a slower stream it is a lower bound less that difference.
#[must_use]
pub fn overlapped_cycles(config: &Config, run: &GatherRun<'_>) -> u64 {
    let passes = |m: &Mvoxel| {
        let pass = (run.issue_cycles(config, *m), u64::from(m.rows));
        std::iter::repeat_n(pass, run.segments as usize)
    };
    let mut cycles = 0;
    let mut issue = 0;
    for (own, rows) in run.mvoxels.iter().flat_map(passes) {
        if issue > 0 {
            cycles += issue.max(rows);
        }
        issue = own;
    }
    cycles + issue
}

/// Whether the RIT stream delivers a group in no more cycles than its issue takes, so that it never
/// stalls a unit whose sources are ready.
#[must_use]
pub fn rit_keeps_up(config: &Config, run: &GatherRun<'_>) -> bool {
    let group = u64::from(config.gu.ports) * config.entry_bytes(run.vertices) as u64;
    let beat = u64::from(config.rit_stream_bits() / 8);
    group <= u64::from(config.issue_cycles(run.vertices)) * beat
}

/// Cycles of a list of operations on the vector unit, with sources and sink always ready.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct VectorCycles {
    /// Vectors of L elements; the last of each operation may be partly filled.
    pub vectors: u64,
    /// Cycles in which a vector is accepted or stepped (`stat_busy`).
    pub busy: u64,
    /// Cycles from the first accepted vector to the last result, inclusive.
    pub elapsed: u64,
}

/// Closed-form model of the vector unit; values derived from the configuration are computed once.
#[derive(Debug, Clone)]
pub struct ClosedVector {
    timing: VectorTiming,
    exponents: Exponents,
    lanes: usize,
}

impl ClosedVector {
    /// The model of a configuration.
    ///
    /// # Errors
    /// A configuration that breaks its rules.
    pub fn new(config: &Config) -> Result<Self, WorkError> {
        Ok(Self {
            timing: VectorTiming::new(config)?,
            exponents: Exponents::of(config),
            lanes: config.vu.lanes as usize,
        })
    }

    /// Exact cycles of operations in sequence, each with its first operands. Operand values matter
    /// only with early termination.
    #[must_use]
    pub fn cycles(&self, work: &[(OpCode, &[i32])]) -> VectorCycles {
        let timing = &self.timing;
        let mut out = VectorCycles::default();
        let mut occupied = 0;
        for &(op, a) in work {
            for vector in a.chunks(self.lanes) {
                let (code, exponent) = (op.code(), self.exponents.least(op, vector));
                out.vectors += 1;
                out.elapsed = occupied + timing.latency(code, exponent) + 1;
                occupied += timing.occupancy(code, exponent);
            }
        }
        if out.vectors > 0 {
            let drained = if timing.pipelined {
                timing.interval - 1
            } else {
                0
            };
            out.busy = occupied + drained;
        }
        out
    }

    /// [`ClosedVector::cycles`] of one operation on so many elements, where no length depends on
    /// values: without early termination.
    #[must_use]
    pub fn cycles_of_any(&self, op: OpCode, elements: u64) -> VectorCycles {
        let timing = &self.timing;
        let vectors = elements.div_ceil(self.lanes as u64);
        if vectors == 0 {
            return VectorCycles::default();
        }
        let (code, exponent) = (op.code(), 0);
        let occupied = timing.occupancy(code, exponent) * vectors;
        let drained = if timing.pipelined {
            timing.interval - 1
        } else {
            0
        };
        VectorCycles {
            vectors,
            busy: occupied + drained,
            elapsed: occupied - timing.occupancy(code, exponent)
                + timing.latency(code, exponent)
                + 1,
        }
    }
}

/// [`ClosedVector::cycles`] for one list of operations.
///
/// # Errors
/// A configuration that breaks its rules.
pub fn vector_cycles(
    config: &Config,
    work: &[(OpCode, &[i32])],
) -> Result<VectorCycles, WorkError> {
    Ok(ClosedVector::new(config)?.cycles(work))
}
