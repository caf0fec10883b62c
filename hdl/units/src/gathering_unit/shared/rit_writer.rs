//! The write side of the RIT buffer.

use std::collections::BTreeMap;

use potamoi_formats::rit::Vertices;
use potamoi_netlist::{ModuleBuilder, Signal, Ty};

use super::rit_shape::{Halves, Shape, of_half};
use crate::circuits::{bits_for, is, ones, plus_one, popcount, wrapping};

/// The stream.
pub(crate) struct Writer {
    pub(crate) valid: Signal,
    pub(crate) data: Signal,
    pub(crate) keep: Signal,
    pub(crate) last: Signal,
    pub(crate) user: Signal,
}

/// What the banks and the top need of it.
pub(crate) struct Written {
    pub(crate) ready: Signal,
    /// Write enable of the banks of each phase.
    pub(crate) enables: Vec<Signal>,
    pub(crate) address: Signal,
    /// Ragged entries, gap in a beat, too large to keep.
    pub(crate) errors: Signal,
}

/// Where an MVoxel ends with a last beat.
struct End {
    groups: Signal,
    /// Entries of the last group.
    keep: Signal,
}

impl End {
    /// A last beat with bytes ends its MVoxel with the last group that it begins or
    /// completes. The groups before one without may be read already: it ends the
    /// MVoxel with a group that is only begun, or else with one that has no entry.
    fn of(
        m: &mut ModuleBuilder,
        shape: &Shape,
        some: Signal,
        [full, all, keep]: [Signal; 3],
    ) -> Self {
        let one_more = plus_one(m, full);
        let groups = m.mux(some, all, one_more);
        let groups = m.name(groups, "groups_at_end");
        let keep = if shape.ports == 1 {
            some
        } else {
            let is_full = m.bit(keep, shape.ports - 1);
            let begun = m.not(is_full);
            let counts = m.or(some, begun);
            let mask = m.repeat(counts, shape.ports);
            m.and(keep, mask)
        };
        Self { groups, keep }
    }
}

/// What a beat completes, for one entry size.
struct Progress {
    full_groups: Signal,
    all_groups: Signal,
    last_keep: Signal,
    whole: Signal,
}

/// Where entries end in the row, this beat included. Kept bytes are contiguous from
/// byte 0, so that one bit of `keep` tells whether a halfword of the beat is there:
/// no sum is needed. Entries of several sizes end in the same places.
struct Position {
    phase: Signal,
    lanes: u32,
    /// Of each halfword of the beat, that it holds entries.
    kept: Vec<Signal>,
    phases: u32,
    at_least: BTreeMap<u32, Signal>,
    exactly: BTreeMap<u32, Signal>,
}

impl Position {
    /// Whether the row holds so many halfwords, 1 and up.
    fn reached(&self, m: &mut ModuleBuilder, halfwords: u32) -> Signal {
        let last = halfwords - 1;
        let options: Vec<_> = (0..self.phases)
            .map(|phase| match last.checked_sub(phase * self.lanes) {
                None => m.lit(1, Ty::bit()),
                Some(lane) if lane < self.lanes => self.kept[lane as usize],
                Some(_) => m.lit(0, Ty::bit()),
            })
            .collect();
        m.select(self.phase, &options)
    }

    fn at_least(&mut self, m: &mut ModuleBuilder, halfwords: u32) -> Signal {
        if let Some(known) = self.at_least.get(&halfwords) {
            return *known;
        }
        let reached = self.reached(m, halfwords);
        let reached = m.name(reached, &format!("at_least_{halfwords}"));
        self.at_least.insert(halfwords, reached);
        reached
    }

    fn exactly(&mut self, m: &mut ModuleBuilder, halfwords: u32) -> Signal {
        if let Some(known) = self.exactly.get(&halfwords) {
            return *known;
        }
        let reached = self.at_least(m, halfwords);
        let here = if halfwords == self.phases * self.lanes {
            reached
        } else {
            let next = self.at_least(m, halfwords + 1);
            let ends = m.not(next);
            let here = m.and(reached, ends);
            m.name(here, &format!("exactly_{halfwords}"))
        };
        self.exactly.insert(halfwords, here);
        here
    }
}

impl Writer {
    pub(crate) fn build(
        &self,
        m: &mut ModuleBuilder,
        shape: &Shape,
        halves: &Halves,
        vertices: Signal,
        segments: Signal,
        release: [Signal; 2],
    ) -> Written {
        let bit = Ty::bit();
        let half = m.reg("write_half", bit, 0);
        let row = m.reg("write_row", Ty::u(shape.row_index_bits()), 0);
        let phase = m.reg("write_phase", Ty::u(bits_for(shape.phases.max(2) - 1)), 0);
        let second = m.reg("write_second", bit, 0);
        m.note(second, "the MVoxel has filled a half already");

        let half_closed = of_half(m, half, halves.closed);
        let ready = m.not(half_closed);
        let ready = m.name(ready, "write_ready");
        let accept = m.and(self.valid, ready);
        // A beat without bytes is none, but for the end that it may mark.
        let some = m.any(self.keep);
        let some = m.name(some, "some_bytes");
        let counts = m.or(some, self.last);
        let accept = m.and(accept, counts);
        let accept = m.name(accept, "write_accept");

        let (kept, keep_is_right) = self.kept(m, shape);
        let mut position = Position {
            phase,
            lanes: shape.lanes,
            kept,
            phases: shape.phases,
            at_least: BTreeMap::new(),
            exactly: BTreeMap::new(),
        };
        let built: Vec<(Vertices, Progress)> = shape
            .vertices
            .iter()
            .map(|v| (*v, progress(m, shape, *v, &mut position)))
            .collect();
        let pick = |m: &mut ModuleBuilder, name: &str, what: fn(&Progress) -> Signal| {
            let s = shape.by_vertices(m, vertices, |_, v| {
                built
                    .iter()
                    .find(|(b, _)| *b == v)
                    .map_or(what(&built[0].1), |(_, p)| what(p))
            });
            m.name(s, name)
        };
        let full_groups = pick(m, "full_groups", |p| p.full_groups);
        // A group of one port is never partly filled.
        let (all_groups, last_keep) = if shape.ports == 1 {
            (full_groups, m.lit(1, Ty::bit()))
        } else {
            (
                pick(m, "all_groups", |p| p.all_groups),
                pick(m, "keep_of_last_group", |p| p.last_keep),
            )
        };
        let whole = pick(m, "whole_entries", |p| p.whole);
        let begins_row = is(m, phase, 0);
        let later_row = m.any(row);
        let earlier = m.or(later_row, second);
        let within_row = m.not(begins_row);
        let goes_on = m.or(earlier, within_row);
        let goes_on = m.name(goes_on, "follows_beats");
        m.note(goes_on, "the MVoxel has brought entries already");
        let end = End::of(m, shape, some, [full_groups, all_groups, last_keep]);
        // Rows hold whole entries.
        let ends_row = m.and(begins_row, earlier);

        let last_beat = m.param("LAST_BEAT_OF_ROW", shape.phases - 1, phase.ty(), "");
        let row_done = m.eq(phase, last_beat);
        let row_done = m.name(row_done, "row_done");
        let last_row = m.param("LAST_ROW", shape.rows - 1, row.ty(), "of a half");
        let last_row = m.eq(row, last_row);
        let half_full = m.and(row_done, last_row);
        let closes = m.or(self.last, half_full);
        let closes = m.name(closes, "ends_half");
        let close = m.and(accept, closes);
        let close = m.name(close, "write_close");

        // The end of what can be read: a full row counts as the start of the next.
        let row_wide = m.extend(row, shape.row_ty().width);
        let row_wide = m.name(row_wide, "write_row_now");
        let next_row = plus_one(m, row_wide);
        let no_group = m.lit(0, shape.group_ty());
        let middle_group = m.mux(row_done, no_group, full_groups);
        let middle_row = m.mux(row_done, next_row, row_wide);
        let end_group = m.mux(self.last, end.groups, middle_group);
        let end_group = m.name(end_group, "new_end_group");
        let end_row = m.mux(self.last, row_wide, middle_row);
        let end_row = m.name(end_row, "new_end_row");
        let all_ports = m.lit(ones(shape.ports), Ty::u(shape.ports));
        let keep = m.mux(self.last, end.keep, all_ports);
        let keep = m.name(keep, "new_last_keep");

        let upper = half;
        let lower = m.not(half);
        let lower = m.name(lower, "in_lower");
        for (h, mine) in [(0, lower), (1, upper)] {
            let here = m.and(accept, mine);
            let here = m.name(here, &format!("write_half_{h}"));
            let closes_here = m.and(close, mine);
            // Released halves start empty.
            let zero_row = m.lit(0, shape.row_ty());
            let zero_group = m.lit(0, shape.group_ty());
            let touched = m.or(here, release[h]);
            let touched = m.name(touched, &format!("touch_half_{h}"));
            let to_row = m.mux(here, end_row, zero_row);
            m.set_next_if(halves.end_row[h], touched, to_row);
            let to_group = m.mux(here, end_group, zero_group);
            m.set_next_if(halves.end_group[h], touched, to_group);
            m.set_next_if(halves.closed[h], touched, closes_here);
            m.set_next_if(halves.ends_mvoxel[h], here, self.last);
            m.set_next_if(halves.streamed[h], here, self.user);
            m.set_next_if(halves.last_keep[h], here, keep);
        }

        m.set_next_if(half, close, lower);
        let next_phase = wrapping(m, phase, last_beat);
        let zero_phase = m.lit(0, phase.ty());
        let phase_after = m.mux(closes, zero_phase, next_phase);
        m.set_next_if(phase, accept, phase_after);
        let row_step = m.or(row_done, closes);
        let row_step = m.name(row_step, "row_is_over");
        let row_steps = m.and(accept, row_step);
        let row_plus_one = plus_one(m, row);
        let zero = m.lit(0, row.ty());
        let row_after = m.mux(closes, zero, row_plus_one);
        m.set_next_if(row, row_steps, row_after);
        let not_last = m.not(self.last);
        let not_last = m.name(not_last, "not_last");
        m.set_next_if(second, close, not_last);

        let enables = (0..shape.phases)
            .map(|p| {
                let here = is(m, phase, p);
                let en = m.and(accept, here);
                m.name(en, &format!("write_phase_{p}"))
            })
            .collect();
        let address = m.cat(&[half, row]);
        let address = m.name(address, "write_address");

        let no_bytes = m.not(some);
        let ends_before = m.and(no_bytes, ends_row);
        let whole = m.or(whole, ends_before);
        let not_whole = m.not(whole);
        let ragged = m.and(self.last, not_whole);
        let gap = m.not(keep_is_right);
        let user = m.reg("write_user", bit, 0);
        m.set_next_if(user, accept, self.user);
        let other_user = m.xor(user, self.user);
        let user_turns = m.and(goes_on, other_user);
        let gap = m.or(gap, user_turns);
        let one = m.lit(1, segments.ty());
        let several = m.gt(segments, one);
        let kept = m.not(self.user);
        let too_large = m.all_of(&[closes, not_last, second, kept, several]);
        let errors: Vec<_> = [too_large, gap, ragged]
            .into_iter()
            .map(|e| m.and(accept, e))
            .collect();
        let errors = m.cat(&errors);
        Written {
            ready,
            enables,
            address,
            errors,
        }
    }

    /// Of each halfword of the beat, that it holds entries; and whether `keep` is all
    /// ones, or on the last beat contiguous whole halfwords from byte 0.
    fn kept(&self, m: &mut ModuleBuilder, shape: &Shape) -> (Vec<Signal>, Signal) {
        let low: Vec<_> = (0..shape.lanes).map(|i| m.bit(self.keep, 2 * i)).collect();
        let high: Vec<_> = (0..shape.lanes)
            .map(|i| m.bit(self.keep, 2 * i + 1))
            .collect();
        let mut right = vec![];
        for i in 0..shape.lanes as usize {
            right.push(m.eq(low[i], high[i]));
            if i > 0 {
                let gap = m.not(low[i]);
                right.push(m.or(gap, low[i - 1]));
            }
        }
        let contiguous = m.all_of(&right);
        let full = m.all(self.keep);
        let right = m.mux(self.last, contiguous, full);
        (low, right)
    }
}

/// What lies before `position` when entries have `vertices` vertices.
fn progress(
    m: &mut ModuleBuilder,
    shape: &Shape,
    vertices: Vertices,
    position: &mut Position,
) -> Progress {
    let size = shape.entry_halfwords(vertices);
    let groups = shape.groups(vertices);
    let name = |what: &str| format!("{what}_v{}", vertices.count());
    // has[e]: entry e of the row is complete.
    let has: Vec<Signal> = (1..=groups * shape.ports)
        .map(|e| position.at_least(m, size * e))
        .collect();
    let entry = |g: u32, p: u32| has[(g * shape.ports + p) as usize];
    let ends: Vec<_> = (0..groups).map(|g| entry(g, shape.ports - 1)).collect();
    let starts: Vec<_> = (0..groups).map(|g| entry(g, 0)).collect();
    let width = shape.group_ty().width;
    let full_groups = popcount(m, &ends);
    let full_groups = m.extend(full_groups, width);
    let full_groups = m.name(full_groups, &name("full_groups"));
    let all_groups = popcount(m, &starts);
    let all_groups = m.extend(all_groups, width);
    let all_groups = m.name(all_groups, &name("all_groups"));
    let mut keep = vec![];
    for p in (0..shape.ports).rev() {
        let mut any = vec![];
        for g in 0..groups {
            let mut all = vec![entry(g, p)];
            if g + 1 < groups {
                all.push(m.not(entry(g + 1, 0)));
            }
            any.push(m.all_of(&all));
        }
        keep.push(m.any_of(&any));
    }
    let last_keep = m.cat(&keep);
    let last_keep = m.name(last_keep, &name("keep"));
    let exact: Vec<_> = (1..=groups * shape.ports)
        .map(|e| position.exactly(m, size * e))
        .collect();
    let whole = m.any_of(&exact);
    let whole = m.name(whole, &name("whole"));
    Progress {
        full_groups,
        all_groups,
        last_keep,
        whole,
    }
}
