//! Read side of the RIT buffer: read control, and the pipeline stages from Q (the banks' output) to
//! P (the issue). Their data is in `rit_buffer/reader_data.rs`.

use potamoi_formats::rit::Vertices;
use potamoi_formats::timing::RitStage;
use potamoi_netlist::{ModuleBuilder, Signal, Ty};

use super::rit_shape::{Halves, Shape, of_half};
use crate::circuits::{is, ones, plus_one};

/// Prefix of a stage's signals.
pub(crate) fn prefix(stage: RitStage) -> char {
    stage.letter().to_ascii_lowercase()
}

/// Registers of the reader.
pub(crate) struct Reader {
    half: Signal,
    row: Signal,
    group: Signal,
    /// `None` where a group takes one cycle.
    vertex: Option<Signal>,
    segment: Signal,
    start_half: Signal,
    /// Q.
    pub(crate) banks: Stage,
    /// Stages between Q and P.
    between: Vec<(RitStage, Stage)>,
    /// P.
    pub(crate) issue: Stage,
}

/// Control signals of a vertex in a stage.
#[derive(Clone, Copy)]
pub(crate) struct Stage {
    pub(crate) valid: Signal,
    /// `None` where a group takes one cycle.
    pub(crate) step: Option<Step>,
    pub(crate) group: Signal,
    /// Whether the group is the last of its MVoxel and segment.
    pub(crate) end: Signal,
    pub(crate) keep: Signal,
}

/// A vertex of a group.
#[derive(Clone, Copy)]
pub(crate) struct Step {
    pub(crate) vertex: Signal,
    /// Whether it is vertex 0, and whether it is V-1.
    pub(crate) first: Signal,
    pub(crate) last: Signal,
}

/// A stage in which a value is registered: prefix of its signals, and its enable.
pub(crate) type Filled = (char, Signal);

/// Signals of a read for the rest of the buffer.
pub(crate) struct Read {
    pub(crate) row_enable: Signal,
    pub(crate) address: Signal,
    pub(crate) release: [Signal; 2],
    /// P takes the content of the stage before it.
    pub(crate) fill_issue: Signal,
    /// For each stage between Q and P, whether it takes the content of the stage before.
    fills: Vec<(RitStage, Signal)>,
}

impl Read {
    /// The built ones of these stages, with their enables.
    pub(crate) fn stages<const N: usize>(&self, stages: [RitStage; N]) -> Vec<Filled> {
        let filled = stages.map(|stage| self.fill(stage).map(|fill| (prefix(stage), fill)));
        filled.into_iter().flatten().collect()
    }

    /// Enable of a stage; `None` where it is not built.
    pub(crate) fn fill(&self, stage: RitStage) -> Option<Signal> {
        let mut all = self.fills.iter();
        all.find(|(own, _)| *own == stage).map(|(_, fill)| *fill)
    }
}

impl Stage {
    fn declare(m: &mut ModuleBuilder, shape: &Shape, stage: RitStage) -> Self {
        let name = prefix(stage);
        let valid = m.reg(&format!("{name}_valid"), Ty::bit(), 0);
        let mut reg = |what: &str, ty: Ty| m.data_reg(&format!("{name}_{what}"), ty);
        Self {
            valid,
            step: (!shape.whole_cells).then(|| Step {
                vertex: reg("vertex", Ty::u(3)),
                first: reg("first", Ty::bit()),
                last: reg("last", Ty::bit()),
            }),
            group: reg("group", shape.group_ty()),
            end: reg("end", Ty::bit()),
            keep: reg("keep", Ty::u(shape.ports)),
        }
    }

    fn fields(self) -> impl Iterator<Item = Signal> {
        let step = self.step.map(|s| [s.vertex, s.first, s.last]);
        let step = step.into_iter().flatten();
        step.chain([self.group, self.end, self.keep])
    }
}

impl Reader {
    pub(crate) fn declare(m: &mut ModuleBuilder, shape: &Shape) -> Self {
        let half = m.reg("read_half", Ty::bit(), 0);
        let row = m.reg("read_row", Ty::u(shape.row_index_bits()), 0);
        let group = m.reg("read_group", shape.group_ty(), 0);
        let vertex = (!shape.whole_cells).then(|| m.reg("read_vertex", Ty::u(3), 0));
        let segment = m.reg("read_segment", Ty::u(7), 0);
        let start_half = m.reg("read_start_half", Ty::bit(), 0);
        m.note(start_half, "half in which the MVoxel begins");
        let banks = Stage::declare(m, shape, RitStage::Banks);
        let inner = shape.pipeline.stages();
        let inner = inner.filter(|stage| !matches!(stage, RitStage::Banks | RitStage::Issue));
        let between = inner
            .map(|stage| (stage, Stage::declare(m, shape, stage)))
            .collect();
        let issue = Stage::declare(m, shape, RitStage::Issue);
        Self {
            half,
            row,
            group,
            vertex,
            segment,
            start_half,
            banks,
            between,
            issue,
        }
    }

    /// The stages, from Q to P.
    pub(crate) fn stages(&self) -> Vec<(RitStage, Stage)> {
        let mut all = vec![(RitStage::Banks, self.banks)];
        all.extend(&self.between);
        all.push((RitStage::Issue, self.issue));
        all
    }

    /// Content of a stage; `None` where it is not built.
    pub(crate) fn at(&self, stage: RitStage) -> Option<Stage> {
        let mut all = self.stages().into_iter();
        all.find(|(own, _)| *own == stage).map(|(_, held)| held)
    }

    /// The vertex in the first built one of these stages; `None` where whole cells are read.
    pub(crate) fn step_at<const N: usize>(&self, stages: [RitStage; N]) -> Option<Step> {
        stages.into_iter().find_map(|stage| self.at(stage))?.step
    }

    /// Content of the stage before P.
    pub(crate) fn before_issue(&self) -> Stage {
        self.between.last().map_or(self.banks, |(_, held)| *held)
    }

    /// Advances the stages after Q as far as there is room. Returns the enable of each, P first,
    /// and whether Q is free.
    fn follow(&self, m: &mut ModuleBuilder, take: Signal) -> (Vec<(RitStage, Signal)>, Signal) {
        let mut moves_on = take;
        let mut fills = vec![];
        for pair in self.stages().windows(2).rev() {
            let ((_, before), (which, stage)) = (pair[0], pair[1]);
            let name = prefix(which);
            let empty = m.not(stage.valid);
            let free = m.or(empty, moves_on);
            let free = m.name(free, &format!("{name}_free"));
            let fill = m.and(free, before.valid);
            let fill = m.name(fill, &format!("{name}_fill"));
            let idle = m.not(moves_on);
            let stays = m.and(stage.valid, idle);
            let valid = m.or(fill, stays);
            m.set_next(stage.valid, valid);
            for (reg, value) in stage.fields().zip(before.fields()) {
                m.set_next_if(reg, fill, value);
            }
            fills.push((which, fill));
            moves_on = free;
        }
        (fills, moves_on)
    }

    /// Advances the reader and stage Q.
    pub(crate) fn advance(
        &self,
        m: &mut ModuleBuilder,
        shape: &Shape,
        halves: &Halves,
        vertices: Signal,
        segments: Signal,
        take: Signal,
    ) -> Read {
        let q = self.banks;
        let (fills, q_moves) = self.follow(m, take);
        let q_empty = m.not(q.valid);
        let q_free = m.or(q_empty, q_moves);
        let q_free = m.name(q_free, "q_free");

        let next = self.next_group(m, shape, halves, vertices);
        let fire = m.and(next.readable, q_free);
        let fire = m.name(fire, "read_fire");
        let at = self.step(m, shape, vertices);
        let ends = self.ends(m, halves, segments, next.more);
        let step = match &at {
            None => fire,
            Some(at) => {
                let step = m.and(fire, at.last);
                m.name(step, "read_step")
            }
        };
        let leaves = self.leaves(m, &ends, step);
        self.move_on(m, &at, [fire, step], &next, &ends, &leaves);

        // An MVoxel's last group may be partly filled; every other one is full.
        let all_ports = m.lit(ones(shape.ports), Ty::u(shape.ports));
        let last_keep = of_half(m, self.half, halves.last_keep);
        let keep = m.mux(ends.half, last_keep, all_ports);

        let still = m.not(q_free);
        let q_stays = m.and(q.valid, still);
        let q_valid = m.or(fire, q_stays);
        m.set_next(q.valid, q_valid);
        let read = Stage {
            step: at,
            group: self.group,
            end: ends.pass,
            keep,
            ..q
        };
        for (reg, value) in q.fields().zip(read.fields()) {
            m.set_next_if(reg, fire, value);
        }

        let row_enable = match &at {
            None => fire,
            Some(at) => {
                let enable = m.and(fire, at.first);
                m.name(enable, "read_row_enable")
            }
        };
        let address = m.cat(&[self.half, self.row]);
        let address = m.name(address, "read_address");
        Read {
            row_enable,
            address,
            release: leaves.release,
            fill_issue: fills[0].1,
            fills,
        }
    }

    /// Whether the reader's current group is readable, and its successor.
    fn next_group(
        &self,
        m: &mut ModuleBuilder,
        shape: &Shape,
        halves: &Halves,
        vertices: Signal,
    ) -> NextGroup {
        let end_row = of_half(m, self.half, halves.end_row);
        let end_row = m.name(end_row, "end_row");
        let end_group = of_half(m, self.half, halves.end_group);
        let end_group = m.name(end_group, "end_group");
        let row = m.extend(self.row, end_row.width());
        let row = m.name(row, "read_row_now");
        let next_row = plus_one(m, row);
        let next_group = plus_one(m, self.group);
        let groups = shape.by_vertices(m, vertices, |m, v| {
            m.lit(shape.groups(v) - 1, shape.group_ty())
        });
        let groups = m.name(groups, "last_group_of_row");
        let row_ends = m.eq(self.group, groups);
        let row_ends = m.name(row_ends, "read_ends_row");
        let readable = before(m, (row, self.group), (end_row, end_group));
        let readable = m.name(readable, "readable");
        let zero_group = m.lit(0, shape.group_ty());
        let then_row = m.mux(row_ends, next_row, row);
        let then_row = m.name(then_row, "row_of_next_group");
        let then_group = m.mux(row_ends, zero_group, next_group);
        let then_group = m.name(then_group, "next_group");
        let more = before(m, (then_row, then_group), (end_row, end_group));
        let more = m.name(more, "more_groups");
        NextGroup {
            readable,
            row: then_row,
            group: then_group,
            more,
        }
    }

    /// The reader's current vertex.
    fn step(&self, m: &mut ModuleBuilder, shape: &Shape, vertices: Signal) -> Option<Step> {
        self.vertex.map(|vertex| {
            let first = is(m, vertex, 0);
            let first = m.name(first, "read_first");
            let top = last_vertex(m, shape, vertices);
            let top = m.name(top, "last_vertex_of_entry");
            let last = m.eq(vertex, top);
            let last = m.name(last, "read_last");
            Step {
                vertex,
                first,
                last,
            }
        })
    }

    /// Ends reached with this group, if there are no `more`.
    fn ends(&self, m: &mut ModuleBuilder, halves: &Halves, segments: Signal, more: Signal) -> Ends {
        let closed = of_half(m, self.half, halves.closed);
        let no_more = m.not(more);
        let half_ends = m.and(closed, no_more);
        let half_ends = m.name(half_ends, "read_ends_half");
        let ends_mvoxel = of_half(m, self.half, halves.ends_mvoxel);
        let ends_mvoxel = m.name(ends_mvoxel, "half_ends_mvoxel");
        let pass_ends = m.and(half_ends, ends_mvoxel);
        let pass_ends = m.name(pass_ends, "read_ends_pass");
        let streamed = of_half(m, self.half, halves.streamed);
        let kept = m.not(streamed);
        let later = plus_one(m, self.segment);
        let later = m.name(later, "next_segment");
        let again = m.lt(later, segments);
        let retain = m.and(kept, again);
        let retain = m.name(retain, "retain");
        m.note(retain, "another segment reads this half from the buffer");
        Ends {
            half: half_ends,
            ends_mvoxel,
            pass: pass_ends,
            retain,
            next_segment: later,
        }
    }

    /// Whether the reader leaves the half, and the half that it frees.
    fn leaves(&self, m: &mut ModuleBuilder, ends: &Ends, step: Signal) -> Leaves {
        let leave = m.and(step, ends.half);
        let leave = m.name(leave, "read_leave_half");
        let let_go = m.not(ends.retain);
        let let_go = m.name(let_go, "let_go");
        let free = m.and(leave, let_go);
        let free = m.name(free, "free_half");
        let from_half_0 = m.not(self.half);
        let from_half_0 = m.name(from_half_0, "from_half_0");
        let release = [m.and(free, from_half_0), m.and(free, self.half)];
        Leaves {
            leave,
            let_go,
            other: from_half_0,
            release: [
                m.name(release[0], "release_0"),
                m.name(release[1], "release_1"),
            ],
        }
    }

    /// Registers of the reader: `fire` reads a vertex, `step` the last one of its group.
    fn move_on(
        &self,
        m: &mut ModuleBuilder,
        at: &Option<Step>,
        [fire, step]: [Signal; 2],
        next: &NextGroup,
        ends: &Ends,
        leaves: &Leaves,
    ) {
        if let Some(at) = at {
            let next = plus_one(m, at.vertex);
            let zero = m.lit(0, Ty::u(3));
            let after = m.mux(at.last, zero, next);
            m.set_next_if(at.vertex, fire, after);
        }
        let zero_group = m.lit(0, self.group.ty());
        let group_after = m.mux(ends.half, zero_group, next.group);
        m.set_next_if(self.group, step, group_after);
        let narrow = m.truncate(next.row, self.row.width());
        let zero_row = m.lit(0, self.row.ty());
        let row_after = m.mux(ends.half, zero_row, narrow);
        m.set_next_if(self.row, step, row_after);
        let repeat = m.and(ends.pass, ends.retain);
        let half_after = m.mux(repeat, self.start_half, leaves.other);
        m.set_next_if(self.half, leaves.leave, half_after);
        let zero_segment = m.lit(0, self.segment.ty());
        let segment_after = m.mux(ends.retain, ends.next_segment, zero_segment);
        let pass_done = m.and(leaves.leave, ends.ends_mvoxel);
        let pass_done = m.name(pass_done, "pass_done");
        m.set_next_if(self.segment, pass_done, segment_after);
        let mvoxel_done = m.and(pass_done, leaves.let_go);
        m.set_next_if(self.start_half, mvoxel_done, leaves.other);
    }
}

/// V - 1 of the entry size that is set.
fn last_vertex(m: &mut ModuleBuilder, shape: &Shape, vertices: Signal) -> Signal {
    if shape.vertices.len() < Vertices::ALL.len() {
        return shape.by_vertices(m, vertices, |m, v| m.lit(v.count() as u32 - 1, Ty::u(3)));
    }
    let all = m.lit(ones(3), Ty::u(3));
    let from_v = m.shl(all, vertices);
    m.not(from_v)
}

/// The reader's current group, and the position of the next one.
struct NextGroup {
    readable: Signal,
    row: Signal,
    group: Signal,
    /// Whether this half has a next group.
    more: Signal,
}

/// Ends reached with a group.
struct Ends {
    half: Signal,
    /// Whether the half holds the last entry of its MVoxel.
    ends_mvoxel: Signal,
    /// The MVoxel's segment ends.
    pass: Signal,
    /// Whether another segment reads this half again.
    retain: Signal,
    next_segment: Signal,
}

/// The reader leaves a half.
struct Leaves {
    leave: Signal,
    /// The half is freed.
    let_go: Signal,
    other: Signal,
    release: [Signal; 2],
}

/// Whether `place` is before `end`; both are (row, group).
fn before(m: &mut ModuleBuilder, place: (Signal, Signal), end: (Signal, Signal)) -> Signal {
    let row_below = m.lt(place.0, end.0);
    let row_same = m.eq(place.0, end.0);
    let group_below = m.lt(place.1, end.1);
    let within = m.and(row_same, group_below);
    m.or(row_below, within)
}
