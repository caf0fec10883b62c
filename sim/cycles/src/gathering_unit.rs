//! Stepwise model of the gathering unit, one clock cycle a call.
//!
//! It keeps occupancy and positions, no data. Every field of [`GatherModel`] is a register: a cycle
//! sees the state that the cycle before left (paper, Sec. "Hardware Support"; rules of
//! `docs/reference/gathering-unit.md`).

use std::collections::VecDeque;

use potamoi_formats::config::Config;
use potamoi_formats::rit::Vertices;

use super::rit_buffer::{Picked, RitBuffer};
use super::split_banks::{SplitRun, Turns, check_no_turns};
use super::work::WorkError;

pub use super::work::RitBeat;

/// Inputs of one cycle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct GatherInputs {
    /// The beat on the RIT stream, if valid.
    pub rit: Option<RitBeat>,
    /// `tlast` of the row on the MFT stream, if valid.
    pub mft: Option<bool>,
    /// Whether the sink accepts a beat of features.
    pub feat_ready: bool,
}

/// The vertex issued in a cycle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Issue {
    /// Index within the entries, 0 to V - 1.
    pub vertex: u32,
    /// First issue of an MVoxel and segment.
    pub first: bool,
    /// Last issue of an MVoxel and segment.
    pub last: bool,
}

/// Cause of a stall.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Cause {
    /// Back-pressure: too many groups in flight.
    Fifo,
    /// The MFT half is not loaded.
    Mft,
    /// No entry has been read.
    Rit,
    /// Ports wait for their turn at the table.
    Turn,
}

/// A beat offered to the sink.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Feature {
    /// Ports that hold an entry, counted from port 0.
    pub kept: u32,
    /// Last beat of an MVoxel and segment.
    pub last: bool,
}

/// The counters, as the `stat_*` ports show them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Counters {
    /// Busy cycles, in which a vertex is issued.
    pub busy: u64,
    /// Stalls up to the last issue from back-pressure: too many groups in flight.
    pub stall_fifo: u64,
    /// Stalls up to the last issue because the MFT half was not loaded.
    pub stall_mft: u64,
    /// Stalls up to the last issue because no entry had been read.
    pub stall_rit: u64,
    /// Cycles in which lanes of the feature-major organisation waited for a bank, or ports for
    /// their turn.
    pub stall_bank: u64,
    /// Entries issued, each counted with its last vertex.
    pub entries: u64,
}

impl Counters {
    /// Cycles from the first to the last issue, inclusive.
    #[must_use]
    pub const fn cycles(&self) -> u64 {
        self.busy + self.stall_fifo + self.stall_mft + self.stall_rit + self.stall_bank
    }
}

/// Outputs of one cycle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct GatherOutputs {
    /// `s_axis_rit_tready`.
    pub rit_ready: bool,
    /// `s_axis_mft_tready`.
    pub mft_ready: bool,
    /// The beat on the feature stream, if valid.
    pub feat: Option<Feature>,
    /// The vertex issued, if any.
    pub issue: Option<Issue>,
    /// Cause of the stall, if any; `None` before the first issue.
    pub stall: Option<Cause>,
    /// Counters at the end of the cycle before.
    pub counters: Counters,
}

#[derive(Debug, Clone, Copy)]
struct Group {
    due: u64,
    feature: Feature,
}

/// The gathering unit between two clock edges.
#[derive(Debug, Clone)]
pub struct GatherModel {
    fifo_depth: u64,
    counter_max: u64,
    /// Cycles in which a group is issued.
    issues: u32,
    /// Cycles from the issue of a group's last vertex to its offer.
    latency: u64,
    /// Turns of the vertices, where ports take turns.
    turns: Option<Turns>,
    cycle: u64,
    buffer: RitBuffer,
    mft_loaded: [bool; 2],
    mft_rows: u64,
    mft_writer: usize,
    mft_reader: usize,
    in_flight: u64,
    output: VecDeque<Group>,
    counting: bool,
    /// Stalls so far, including those after the last issue.
    running: Counters,
    shown: Counters,
}

impl GatherModel {
    /// The unit after reset, with `cfg_vertices` and `cfg_segments` as given.
    ///
    /// # Errors
    /// A configuration that breaks its rules, an entry size that it does not build, a number of
    /// segments that it does not allow, or ports that take turns.
    pub fn new(config: &Config, vertices: Vertices, segments: u32) -> Result<Self, WorkError> {
        super::work::check_setting(config, vertices, segments)?;
        super::work::check_channel_major(config)?;
        check_no_turns(config)?;
        Ok(Self::after_reset(config, vertices, segments, None))
    }

    /// The unit after reset, set up for this work.
    ///
    /// # Errors
    /// Work that the unit cannot do.
    pub fn of_turns(config: &Config, work: &SplitRun<'_>) -> Result<Self, WorkError> {
        work.check(config)?;
        super::work::check_channel_major(config)?;
        let run = &work.run;
        let turns = Some(Turns::new(work));
        Ok(Self::after_reset(config, run.vertices, run.segments, turns))
    }

    fn after_reset(
        config: &Config,
        vertices: Vertices,
        segments: u32,
        turns: Option<Turns>,
    ) -> Self {
        Self {
            fifo_depth: u64::from(config.feature_fifo_depth()),
            counter_max: u64::MAX >> (64 - config.gu.counter_bits),
            issues: config.issue_cycles(vertices),
            latency: u64::from(config.gather_pipeline().cycles()),
            turns,
            cycle: 0,
            buffer: RitBuffer::new(config, vertices, segments),
            mft_loaded: [false; 2],
            mft_rows: 0,
            mft_writer: 0,
            mft_reader: 0,
            in_flight: 0,
            output: VecDeque::new(),
            counting: false,
            running: Counters::default(),
            shown: Counters::default(),
        }
    }

    /// `s_axis_rit_tready` in the next cycle.
    #[must_use]
    pub fn rit_ready(&self) -> bool {
        self.buffer.ready()
    }

    /// `s_axis_mft_tready` in the next cycle.
    #[must_use]
    pub fn mft_ready(&self) -> bool {
        !self.mft_loaded[self.mft_writer]
    }

    /// The counters in the next cycle.
    #[must_use]
    pub const fn counters(&self) -> Counters {
        self.shown
    }

    /// Whether the unit is empty, so that the settings may change.
    #[must_use]
    pub fn is_idle(&self) -> bool {
        self.buffer.is_idle()
            && self.in_flight == 0
            && self.mft_loaded == [false; 2]
            && self.mft_rows == 0
    }

    /// A cycle with `cfg_clear` high, for an idle unit: counting restarts with the next issue.
    pub fn clear(&mut self) {
        self.counting = false;
        self.running = Counters::default();
        self.shown = Counters::default();
        self.cycle += 1;
    }

    /// One clock cycle.
    pub fn step(&mut self, inputs: &GatherInputs) -> GatherOutputs {
        let room = self.in_flight < self.fifo_depth;
        let loaded = self.mft_loaded[self.mft_reader];
        let offered = self.buffer.offered();
        let last_vertex = self.issues - 1;
        let asked = offered.filter(|p| p.vertex != 0 || (room && loaded));
        let turns = &mut self.turns;
        let issued = asked.filter(|p| {
            // Without an entry there is nothing to wait for.
            let turns = turns.as_mut().filter(|_| p.kept > 0);
            turns.is_none_or(|turns| turns.turn(p.vertex, p.vertex == last_vertex))
        });
        let stall = match (issued.is_some(), asked.is_some(), self.counting) {
            (true, _, _) => None,
            (_, true, _) => Some(Cause::Turn),
            (_, _, false) => None,
            _ if !room => Some(Cause::Fifo),
            _ if !loaded => Some(Cause::Mft),
            _ => Some(Cause::Rit),
        };
        let outputs = GatherOutputs {
            rit_ready: self.rit_ready(),
            mft_ready: self.mft_ready(),
            feat: self
                .output
                .front()
                .filter(|g| g.due <= self.cycle)
                .map(|g| g.feature),
            issue: issued.map(|p| Issue {
                vertex: p.vertex,
                first: p.first_group && p.vertex == 0,
                last: p.last_group && p.vertex == last_vertex,
            }),
            stall,
            counters: self.shown,
        };

        self.buffer.step(issued.is_some(), inputs.rit);

        self.count(issued, stall, last_vertex);
        if let Some(last) = inputs.mft.filter(|_| outputs.mft_ready) {
            self.mft_rows += 1;
            if last {
                self.mft_rows = 0;
                self.mft_loaded[self.mft_writer] = true;
                self.mft_writer ^= 1;
            }
        }
        if outputs.issue.is_some_and(|i| i.last) {
            self.mft_loaded[self.mft_reader] = false;
            self.mft_reader ^= 1;
        }

        if outputs.feat.is_some() && inputs.feat_ready {
            self.output.pop_front();
            self.in_flight -= 1;
        }
        if let Some(p) = issued {
            self.in_flight += u64::from(p.vertex == 0);
            if p.vertex == last_vertex {
                self.output.push_back(Group {
                    due: self.cycle + self.latency,
                    feature: Feature {
                        kept: p.kept,
                        last: p.last_group,
                    },
                });
            }
        }
        self.cycle += 1;
        outputs
    }

    fn count(&mut self, issued: Option<Picked>, stall: Option<Cause>, last_vertex: u32) {
        let max = self.counter_max;
        let add = |counter: &mut u64, n: u64| *counter = counter.saturating_add(n).min(max);
        match stall {
            Some(Cause::Fifo) => add(&mut self.running.stall_fifo, 1),
            Some(Cause::Mft) => add(&mut self.running.stall_mft, 1),
            Some(Cause::Rit) => add(&mut self.running.stall_rit, 1),
            Some(Cause::Turn) => {
                add(&mut self.running.stall_bank, 1);
                self.counting = true;
                self.shown = self.running;
            }
            None => {}
        }
        if let Some(p) = issued {
            self.counting = true;
            add(&mut self.running.busy, 1);
            if p.vertex == last_vertex {
                add(&mut self.running.entries, u64::from(p.kept));
            }
            // The ports follow only with an issue: idling at the end stays out.
            self.shown = self.running;
        }
    }
}
