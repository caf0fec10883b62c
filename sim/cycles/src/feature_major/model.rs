//! The feature-major unit, one clock cycle a call.
//!
//! Positions, occupancy and rounds are kept, no data. Every field of
//! [`FeatureMajorModel`] is a register (rules of `docs/explanation/organisations.md`).

use std::collections::VecDeque;

use potamoi_formats::config::Config;
use potamoi_formats::rit::Vertices;

use super::{LaneRun, channels_of, latency};
use crate::bank_rounds::Rounds;
use crate::gathering_unit::{Cause, Counters, Feature, GatherInputs, GatherOutputs, Issue};
use crate::rit_buffer::RitBuffer;
use crate::work::WorkError;

/// Half of the lanes' entries.
#[derive(Debug, Clone, Copy, Default)]
struct Half {
    full: bool,
    kept: u32,
    /// Its entries are the last of their pass.
    ends: bool,
}

/// One vertex and channel of R entries, as the lanes hold it.
#[derive(Debug, Clone, Copy)]
struct Step {
    vertex: u32,
    left: u16,
    new: bool,
    kept: u32,
    first_of_pass: bool,
    ends_entries: bool,
    ends_pass: bool,
}

/// Position of the next step: half of the lanes, vertex and channel.
#[derive(Debug, Clone, Copy, Default)]
struct ReadPosition {
    half: usize,
    vertex: u32,
    channel: u64,
    mvoxel: usize,
    segment: u32,
    group: usize,
}

#[derive(Debug, Clone, Copy)]
struct Beat {
    due: u64,
    feature: Feature,
}

/// The feature-major unit between two clock edges.
#[derive(Debug, Clone)]
pub struct FeatureMajorModel {
    /// Groups of M lanes.
    groups: u32,
    banks: u32,
    fifo_depth: u64,
    counter_max: u64,
    vertices: Vertices,
    segments: u32,
    channels: usize,
    rounds: Vec<Vec<Rounds>>,
    cycle: u64,
    buffer: RitBuffer,
    lanes: [Half; 2],
    fill_half: usize,
    fill_group: u32,
    place: ReadPosition,
    step: Option<Step>,
    mft_loaded: [bool; 2],
    mft_begun: bool,
    mft_writer: usize,
    mft_reader: usize,
    in_flight: u64,
    output: VecDeque<Beat>,
    counting: bool,
    running: Counters,
    shown: Counters,
}

impl FeatureMajorModel {
    /// The unit after reset, set to the work that it is going to get.
    ///
    /// # Errors
    /// Work that the unit cannot do.
    pub fn new(config: &Config, work: &LaneRun<'_>) -> Result<Self, WorkError> {
        work.check(config)?;
        let (vertices, segments) = (work.run.vertices, work.run.segments);
        Ok(Self {
            groups: config.gu.lanes / config.gu.ports,
            banks: config.gu.banks,
            fifo_depth: u64::from(config.feature_fifo_depth()),
            counter_max: u64::MAX >> (64 - config.gu.counter_bits),
            vertices,
            segments,
            channels: work.channels,
            rounds: work.rounds.to_vec(),
            cycle: 0,
            buffer: RitBuffer::new(config, vertices, segments),
            lanes: [Half::default(); 2],
            fill_half: 0,
            fill_group: 0,
            place: ReadPosition::default(),
            step: None,
            mft_loaded: [false; 2],
            mft_begun: false,
            mft_writer: 0,
            mft_reader: 0,
            in_flight: 0,
            output: VecDeque::new(),
            counting: false,
            running: Counters::default(),
            shown: Counters::default(),
        })
    }

    /// Whether nothing is held anywhere.
    #[must_use]
    pub fn is_idle(&self) -> bool {
        self.buffer.is_idle()
            && !self.lanes.iter().any(|h| h.full)
            && self.fill_group == 0
            && self.step.is_none()
            && self.in_flight == 0
            && self.mft_loaded == [false; 2]
            && !self.mft_begun
    }

    /// One clock cycle.
    pub fn step(&mut self, inputs: &GatherInputs) -> GatherOutputs {
        let room = self.in_flight < self.fifo_depth;
        let loaded = self.mft_loaded[self.mft_reader];
        let issued = self
            .step
            .filter(|s| !(s.new && s.vertex == 0) || (room && loaded));
        let stall = match (issued.is_some() || !self.counting, room, loaded) {
            (true, _, _) => None,
            (_, false, _) => Some(Cause::Fifo),
            (_, _, false) => Some(Cause::Mft),
            _ => Some(Cause::Rit),
        };
        // The last round of a step lets the next one in.
        let done = issued.filter(|s| s.left <= 1);
        let last_vertex = self.vertices.count() as u32 - 1;
        let completes = done.filter(|s| s.vertex == last_vertex);
        let outputs = GatherOutputs {
            rit_ready: self.buffer.ready(),
            mft_ready: !self.mft_loaded[self.mft_writer],
            feat: self
                .output
                .front()
                .filter(|b| b.due <= self.cycle)
                .map(|b| b.feature),
            issue: issued.map(|s| Issue {
                vertex: s.vertex,
                first: s.new && s.first_of_pass,
                last: done.is_some() && s.ends_pass,
            }),
            stall,
            counters: self.shown,
        };

        // Both look at the lanes as the cycle before left them.
        let full = self.lanes.map(|h| h.full);
        let taken = self.buffer.offered().filter(|_| !full[self.fill_half]);
        if let Some(step) = &mut self.step
            && issued.is_some()
        {
            step.left = step.left.saturating_sub(1);
            step.new = false;
        }
        if self.step.is_none() || done.is_some() {
            self.step = full[self.place.half].then(|| self.read());
        }
        if let Some(p) = taken.filter(|p| p.vertex == last_vertex) {
            self.fill(p.kept, p.last_group);
        }
        self.buffer.step(taken.is_some(), inputs.rit);

        self.count(issued, done, stall);
        if let Some(last) = inputs.mft.filter(|_| outputs.mft_ready) {
            self.mft_begun = !last;
            if last {
                self.mft_loaded[self.mft_writer] = true;
                self.mft_writer ^= 1;
            }
        }
        if done.is_some_and(|s| s.ends_pass) {
            self.mft_loaded[self.mft_reader] = false;
            self.mft_reader ^= 1;
        }
        if outputs.feat.is_some() && inputs.feat_ready {
            self.output.pop_front();
            self.in_flight -= 1;
        }
        if issued.is_some_and(|s| s.new && s.vertex == 0) {
            self.in_flight += 1;
        }
        if let Some(s) = completes {
            self.output.push_back(Beat {
                due: self.cycle + latency(),
                feature: Feature {
                    kept: s.kept,
                    last: s.ends_pass,
                },
            });
        }
        self.cycle += 1;
        outputs
    }

    /// A group of M entries is complete in the lanes.
    fn fill(&mut self, kept: u32, ends: bool) {
        let half = &mut self.lanes[self.fill_half];
        if self.fill_group == 0 {
            half.kept = 0;
        }
        half.kept += kept;
        self.fill_group += 1;
        if ends || self.fill_group == self.groups {
            half.full = true;
            half.ends = ends;
            self.fill_half ^= 1;
            self.fill_group = 0;
        }
    }

    /// Reads the next step, and releases its half with the last one.
    fn read(&mut self) -> Step {
        let at = self.place;
        let half = self.lanes[at.half];
        let group = self.rounds.get(at.mvoxel).and_then(|m| m.get(at.group));
        let last_vertex = at.vertex + 1 == self.vertices.count() as u32;
        let channels = channels_of(self.channels, self.banks, at.segment);
        let ends_entries = last_vertex && at.channel + 1 >= channels;
        let step = Step {
            vertex: at.vertex,
            left: group.map_or(1, |rounds| rounds[at.vertex as usize]),
            new: true,
            kept: half.kept,
            first_of_pass: at.group == 0 && at.channel == 0 && at.vertex == 0,
            ends_entries,
            ends_pass: ends_entries && half.ends,
        };
        let place = &mut self.place;
        place.vertex += 1;
        if last_vertex {
            place.vertex = 0;
            place.channel += 1;
        }
        if ends_entries {
            self.lanes[at.half].full = false;
            place.half ^= 1;
            place.channel = 0;
            place.group += 1;
        }
        if step.ends_pass {
            place.group = 0;
            place.segment += 1;
            if place.segment == self.segments {
                place.segment = 0;
                place.mvoxel += 1;
            }
        }
        step
    }

    fn count(&mut self, issued: Option<Step>, done: Option<Step>, stall: Option<Cause>) {
        let max = self.counter_max;
        let add = |counter: &mut u64, n: u64| *counter = counter.saturating_add(n).min(max);
        match stall {
            Some(Cause::Fifo) => add(&mut self.running.stall_fifo, 1),
            Some(Cause::Mft) => add(&mut self.running.stall_mft, 1),
            Some(Cause::Rit) => add(&mut self.running.stall_rit, 1),
            Some(Cause::Turn) | None => {}
        }
        if let Some(step) = issued {
            self.counting = true;
            add(&mut self.running.busy, u64::from(step.new));
            add(&mut self.running.stall_bank, u64::from(!step.new));
            if let Some(step) = done.filter(|s| s.ends_entries) {
                add(&mut self.running.entries, u64::from(step.kept));
            }
            self.shown = self.running;
        }
    }
}
