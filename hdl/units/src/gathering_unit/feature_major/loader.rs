//! Loader: moves groups of M entries from the RIT buffer into the lanes.

use potamoi_formats::config::Config;
use potamoi_netlist::{Instance, ModuleBuilder, Signal, Ty};

use super::shape::Shape;
use crate::circuits::{bits_for, is, plus_one};
use crate::gathering_unit::shared::rit_shape::of_half;

/// The lanes' double buffer; a half holds R entries of one MVoxel and segment.
pub(super) struct Loader {
    /// The half being filled.
    pub(super) half: Signal,
    pub(super) vertex: Signal,
    /// A vertex of M entries is taken from the RIT buffer.
    pub(super) take: Signal,
    /// For each group of M lanes, a bit that its entries get a vertex.
    pub(super) writes: Signal,
    /// For each group, a bit that its entries are complete, or void.
    pub(super) entries: Signal,
    pub(super) full: [Signal; 2],
    ends: [Signal; 2],
    closes: Signal,
}

impl Loader {
    /// `rit` is the RIT buffer.
    pub(super) fn build(m: &mut ModuleBuilder, config: &Config, rit: Instance) -> Self {
        let shape = Shape::of(config);
        let groups = shape.lanes / config.gu.ports;
        let bit = Ty::bit();
        let full = [0, 1].map(|h| m.reg(&format!("lanes_full_{h}"), bit, 0));
        m.note(full[0], "a half holds all entries that it will");
        let ends = [0, 1].map(|h| m.data_reg(&format!("lanes_end_{h}"), bit));
        m.note(ends[0], "its entries are the last of their pass");
        let half = m.reg("fill_half", bit, 0);
        let vertex = m.reg("fill_vertex", Ty::u(3), 0);
        let [p_valid, p_last, p_end] = ["p_valid", "p_last", "p_end"].map(|name| m.out(rit, name));
        let is_full = of_half(m, half, full);
        let room = m.not(is_full);
        let take = m.and(p_valid, room);
        let take = m.name(take, "take");
        m.note(take, "a vertex of M entries goes to its lanes");
        let take_last = m.and(take, p_last);
        let take_last = m.name(take_last, "take_last");
        let next_vertex = plus_one(m, vertex);
        let zero = m.lit(0, vertex.ty());
        let vertex_after = m.mux(p_last, zero, next_vertex);
        m.set_next_if(vertex, take, vertex_after);

        let (writes, entries, closes) = if groups == 1 {
            (take, take_last, take_last)
        } else {
            let group = m.reg("fill_group", Ty::u(bits_for(groups - 1)), 0);
            m.note(group, "group of M lanes that is being filled");
            let first = m.lit(1, Ty::u(groups));
            let here = m.shl(first, group);
            let here = m.name(here, "groups_here");
            let takes = m.repeat(take, groups);
            let writes = m.and(takes, here);
            let writes = m.name(writes, "fill_groups");
            // With the first group the others are void until filled.
            let is_first = m.bit(here, 0);
            let all = m.repeat(is_first, groups);
            let counts = m.or(here, all);
            let takes_last = m.repeat(take_last, groups);
            let entries = m.and(takes_last, counts);
            let entries = m.name(entries, "settle_groups");
            let top = is(m, group, groups - 1);
            let over = m.or(p_end, top);
            let over = m.name(over, "lanes_are_full");
            let closes = m.and(take_last, over);
            let next = plus_one(m, group);
            let zero = m.lit(0, group.ty());
            let after = m.mux(over, zero, next);
            m.set_next_if(group, take_last, after);
            (writes, entries, closes)
        };
        let closes = m.name(closes, "lanes_close");
        let other = m.not(half);
        m.set_next_if(half, closes, other);
        for (h, mine) in [(0, other), (1, half)] {
            let closes = m.and(closes, mine);
            m.set_next_if(ends[h], closes, p_end);
        }
        Self {
            half,
            vertex,
            take,
            writes,
            entries,
            full,
            ends,
            closes,
        }
    }

    /// Whether a half is ready to be gathered, and whether it ends its pass.
    pub(super) fn half(&self, m: &mut ModuleBuilder, half: Signal) -> (Signal, Signal) {
        (of_half(m, half, self.full), of_half(m, half, self.ends))
    }

    /// `frees`: the last step of the half was read.
    pub(super) fn release(&self, m: &mut ModuleBuilder, half: Signal, frees: Signal) {
        let (fills_lower, reads_lower) = (m.not(self.half), m.not(half));
        for (h, fills, reads) in [(0, fills_lower, reads_lower), (1, self.half, half)] {
            let closes = m.and(self.closes, fills);
            let freed = m.and(frees, reads);
            let stays = m.not(freed);
            let kept = m.and(self.full[h], stays);
            let next = m.or(closes, kept);
            m.set_next(self.full[h], next);
        }
    }
}
