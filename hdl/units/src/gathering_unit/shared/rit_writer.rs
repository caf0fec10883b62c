//! Write side of the RIT buffer.

use potamoi_formats::rit::Vertices;
use potamoi_netlist::{ModuleBuilder, Signal, Ty};

use super::rit_progress::{Position, Progress, progress};
use super::rit_shape::{Halves, Shape, of_half};
use crate::circuits::{bits_for, is, ones, plus_one, wrapping};

/// The stream.
pub(crate) struct Writer {
    pub(crate) valid: Signal,
    pub(crate) data: Signal,
    pub(crate) keep: Signal,
    pub(crate) last: Signal,
    pub(crate) user: Signal,
}

/// Signals of a write for the banks and the top module.
pub(crate) struct Written {
    pub(crate) ready: Signal,
    /// Write enables of the banks, a bit a phase.
    pub(crate) enables: Signal,
    pub(crate) address: Signal,
    /// An MVoxel's stream has begun and not ended.
    pub(crate) amid: Signal,
    /// Error flags: ragged entries, gap in a beat, too large to keep.
    pub(crate) errors: Signal,
}

/// End of an MVoxel at its last beat.
struct End {
    groups: Signal,
    /// Valid entries of the last group.
    keep: Signal,
}

impl End {
    /// A last beat with bytes ends its MVoxel with the last group that it begins or completes. For
    /// a last beat without bytes, the groups before may already have been read: it ends the MVoxel
    /// with a group that is only begun, or else with an empty one.
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

/// Write position of the next beat.
struct At {
    half: Signal,
    row: Signal,
    phase: Signal,
    /// Whether the MVoxel has already filled a half.
    second: Signal,
}

impl At {
    fn declare(m: &mut ModuleBuilder, shape: &Shape) -> Self {
        let half = m.reg("write_half", Ty::bit(), 0);
        let row = m.reg("write_row", Ty::u(shape.row_index_bits()), 0);
        let phase = m.reg("write_phase", Ty::u(bits_for(shape.phases.max(2) - 1)), 0);
        let second = m.reg("write_second", Ty::bit(), 0);
        m.note(second, "the MVoxel has filled a half already");
        Self {
            half,
            row,
            phase,
            second,
        }
    }
}

/// Classification of a beat.
struct Beat {
    accept: Signal,
    /// Whether it has bytes.
    some: Signal,
    /// Whether it completes a row, and whether it completes the half.
    row_done: Signal,
    closes: Signal,
    close: Signal,
    last_phase: Signal,
}

/// Entries completed by a beat for the current entry size, and its position in its MVoxel.
struct Completed {
    full_groups: Signal,
    /// Whether it ends with a whole entry.
    whole: Signal,
    /// Whether the MVoxel already has entries.
    goes_on: Signal,
    /// Whether the beat begins a row and is not the MVoxel's first.
    ends_row: Signal,
    end: End,
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
        let at = At::declare(m, shape);
        let half_closed = of_half(m, at.half, halves.closed);
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
        let completed = completed(m, shape, vertices, &at, kept, some);
        let beat = self.beat(m, shape, &at, accept, some);
        let to_half_0 = self.fill(m, shape, halves, &at, (&beat, &completed), release);
        let not_last = self.move_on(m, &at, &beat, to_half_0);
        let first = m.lit(1, Ty::u(shape.phases));
        let here = m.shl(first, at.phase);
        let accepts = m.repeat(accept, shape.phases);
        let enables = m.and(accepts, here);
        let enables = m.name(enables, "write_beat");
        let address = m.cat(&[at.half, at.row]);
        let address = m.name(address, "write_address");
        let wrong = FlagInputs {
            keep_is_right,
            not_last,
            segments,
        };
        let errors = self.errors(m, &at, &beat, &completed, &wrong);
        Written {
            ready,
            enables,
            address,
            amid: completed.goes_on,
            errors,
        }
    }

    /// Ends reached with an accepted beat.
    fn beat(
        &self,
        m: &mut ModuleBuilder,
        shape: &Shape,
        at: &At,
        accept: Signal,
        some: Signal,
    ) -> Beat {
        let last_phase = m.param("LAST_BEAT_OF_ROW", shape.phases - 1, at.phase.ty(), "");
        let row_done = m.eq(at.phase, last_phase);
        let row_done = m.name(row_done, "row_done");
        let last_row = m.param("LAST_ROW", shape.rows - 1, at.row.ty(), "of a half");
        let last_row = m.eq(at.row, last_row);
        let half_full = m.and(row_done, last_row);
        let closes = m.or(self.last, half_full);
        let closes = m.name(closes, "ends_half");
        let close = m.and(accept, closes);
        Beat {
            accept,
            some,
            row_done,
            closes,
            close: m.name(close, "write_close"),
            last_phase,
        }
    }

    /// Updates the state of the halves. Returns whether half 0 is written.
    fn fill(
        &self,
        m: &mut ModuleBuilder,
        shape: &Shape,
        halves: &Halves,
        at: &At,
        (beat, completed): (&Beat, &Completed),
        release: [Signal; 2],
    ) -> Signal {
        // The end of what can be read: a full row counts as the start of the next.
        let row_wide = m.extend(at.row, shape.row_ty().width);
        let row_wide = m.name(row_wide, "write_row_now");
        let next_row = plus_one(m, row_wide);
        let no_group = m.lit(0, shape.group_ty());
        let middle_group = m.mux(beat.row_done, no_group, completed.full_groups);
        let middle_row = m.mux(beat.row_done, next_row, row_wide);
        let end_group = m.mux(self.last, completed.end.groups, middle_group);
        let end_group = m.name(end_group, "new_end_group");
        let end_row = m.mux(self.last, row_wide, middle_row);
        let end_row = m.name(end_row, "new_end_row");
        let all_ports = m.lit(ones(shape.ports), Ty::u(shape.ports));
        let keep = m.mux(self.last, completed.end.keep, all_ports);
        let keep = m.name(keep, "new_last_keep");

        let to_half_0 = m.not(at.half);
        let to_half_0 = m.name(to_half_0, "to_half_0");
        for (h, mine) in [(0, to_half_0), (1, at.half)] {
            let here = m.and(beat.accept, mine);
            let here = m.name(here, &format!("write_half_{h}"));
            let closes_here = m.and(beat.close, mine);
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
        to_half_0
    }

    /// Registers of the writer. Returns whether the beat is not the last one.
    fn move_on(&self, m: &mut ModuleBuilder, at: &At, beat: &Beat, other: Signal) -> Signal {
        m.set_next_if(at.half, beat.close, other);
        let next_phase = wrapping(m, at.phase, beat.last_phase);
        let zero_phase = m.lit(0, at.phase.ty());
        let phase_after = m.mux(beat.closes, zero_phase, next_phase);
        m.set_next_if(at.phase, beat.accept, phase_after);
        let row_step = m.or(beat.row_done, beat.closes);
        let row_step = m.name(row_step, "row_is_over");
        let row_steps = m.and(beat.accept, row_step);
        let row_plus_one = plus_one(m, at.row);
        let zero = m.lit(0, at.row.ty());
        let row_after = m.mux(beat.closes, zero, row_plus_one);
        m.set_next_if(at.row, row_steps, row_after);
        let not_last = m.not(self.last);
        let not_last = m.name(not_last, "not_last");
        m.set_next_if(at.second, beat.close, not_last);
        not_last
    }

    /// Error flags, highest bit first: too large to keep, gap in a beat, ragged entries.
    fn errors(
        &self,
        m: &mut ModuleBuilder,
        at: &At,
        beat: &Beat,
        completed: &Completed,
        wrong: &FlagInputs,
    ) -> Signal {
        let no_bytes = m.not(beat.some);
        let ends_before = m.and(no_bytes, completed.ends_row);
        let whole = m.or(completed.whole, ends_before);
        let not_whole = m.not(whole);
        let ragged = m.and(self.last, not_whole);
        let gap = m.not(wrong.keep_is_right);
        let user = m.data_reg("write_user", Ty::bit());
        m.set_next_if(user, beat.accept, self.user);
        let other_user = m.xor(user, self.user);
        let user_turns = m.and(completed.goes_on, other_user);
        let gap = m.or(gap, user_turns);
        let one = m.lit(1, wrong.segments.ty());
        let several = m.gt(wrong.segments, one);
        let kept = m.not(self.user);
        let too_large = m.all_of(&[beat.closes, wrong.not_last, at.second, kept, several]);
        let errors = [
            (too_large, "is_too_large"),
            (gap, "has_gap"),
            (ragged, "is_ragged"),
        ];
        let errors = errors.map(|(error, name)| {
            let raised = m.and(beat.accept, error);
            m.name(raised, name)
        });
        m.cat(&errors)
    }

    /// Whether each halfword of the beat is valid; and whether `keep` is all ones, or on the last
    /// beat contiguous whole halfwords from byte 0.
    fn kept(&self, m: &mut ModuleBuilder, shape: &Shape) -> (Signal, Signal) {
        let low = m.every("beat_kept", self.keep, 2, ("each", shape.lanes));
        let most = self.keep.width() - 1;
        let (below, above) = (m.slice(self.keep, 0, most), m.slice(self.keep, 1, most));
        let missing = m.not(below);
        let gaps = m.and(above, missing);
        let gap = m.any(gaps);
        let torn = m.parity(self.keep);
        let wrong = m.or(gap, torn);
        let contiguous = m.not(wrong);
        let full = m.all(self.keep);
        let right = m.mux(self.last, contiguous, full);
        (low, right)
    }
}

/// Inputs of the error flags.
struct FlagInputs {
    keep_is_right: Signal,
    not_last: Signal,
    segments: Signal,
}

/// Entries completed by a beat, selected by the entry size.
fn completed(
    m: &mut ModuleBuilder,
    shape: &Shape,
    vertices: Signal,
    at: &At,
    kept: Signal,
    some: Signal,
) -> Completed {
    let position = Position::new(m, shape, at.phase, kept);
    let built: Vec<(Vertices, Progress)> = shape
        .vertices
        .iter()
        .map(|v| (*v, progress(m, shape, *v, &position)))
        .collect();
    let (groups, ports) = (shape.group_ty().width, shape.ports);
    let of_size = shape.by_vertices(m, vertices, |m, v| {
        let own = built.iter().find(|(b, _)| *b == v);
        let own = own.map_or(&built[0].1, |(_, own)| own);
        m.cat(&[own.whole, own.last_keep, own.all_groups, own.full_groups])
    });
    m.name(of_size, "completed");
    let mut low = 0;
    let mut next = |m: &mut ModuleBuilder, width: u32, name: &str| {
        let field = m.slice(of_size, low, width);
        low += width;
        m.name(field, name)
    };
    let full_groups = next(m, groups, "full_groups");
    let all_groups = next(m, groups, "all_groups");
    let last_keep = next(m, ports, "keep_of_last_group");
    let whole = next(m, 1, "whole_entries");
    let begins_row = is(m, at.phase, 0);
    let later_row = m.any(at.row);
    let earlier = m.or(later_row, at.second);
    let earlier = m.name(earlier, "has_rows");
    let within_row = m.not(begins_row);
    let goes_on = m.or(earlier, within_row);
    let goes_on = m.name(goes_on, "follows_beats");
    m.note(goes_on, "the MVoxel has brought entries already");
    let end = End::of(m, shape, some, [full_groups, all_groups, last_keep]);
    // Rows hold whole entries.
    let ends_row = m.and(begins_row, earlier);
    Completed {
        full_groups,
        whole,
        goes_on,
        ends_row,
        end,
    }
}
