//! Stage 1: control of the issued vertex beside the table's words.

use potamoi_formats::config::{Config, Modes};
use potamoi_netlist::{ModuleBuilder, Signal, Ty};

use super::issue::Issue;
use crate::circuits::is;

/// Pipeline stage after the MFT's read.
pub(super) struct StageOne {
    pub(super) valid: Signal,
    pub(super) first: Signal,
    pub(super) last: Signal,
    pub(super) end: Signal,
    pub(super) keep: Signal,
    pub(super) in_range: Signal,
    pub(super) weight: Signal,
    pub(super) slot: Signal,
    /// Ports whose rows were read, where ports take turns.
    pub(super) turns: Option<Signal>,
    /// Ports that request the upper record, where two records share a row.
    pub(super) upper: Option<Signal>,
    /// Whether entries are single ids.
    pub(super) single: Signal,
}

impl StageOne {
    /// `vertices` is the setting.
    pub(super) fn build(
        m: &mut ModuleBuilder,
        config: &Config,
        issue: &Issue,
        vertices: Signal,
    ) -> Self {
        m.section("Stage 1: features of the rows that were read");
        let (bit, ports) = (Ty::bit(), config.gu.ports);
        let (whole_cells, groups) = (config.is_parity(), config.vertices_a_row());
        let (p, asks) = (&issue.offered, issue.asks);
        let step = |m: &mut ModuleBuilder, name: &str, of_p: Signal| match whole_cells {
            true => of_p,
            false => m.data_reg(name, bit),
        };
        let in_range = m.out(issue.table, "in_range");
        let valid = m.reg("s1_valid", bit, 0);
        let first = step(m, "s1_first", p.first);
        let last = step(m, "s1_last", p.last);
        let end = m.data_reg("s1_end", bit);
        let keep = m.data_reg("s1_keep", Ty::u(ports));
        let held_in_range = m.data_reg("s1_in_range", Ty::u(ports * groups));
        let weight = m.data_reg("s1_weight", Ty::u(16 * ports * groups));
        let slot = m.data_reg("s1_slot", Ty::u(config.rit.slot_bits * ports));
        m.set_next(valid, issue.fire);
        // What a port without an entry reads is not known, and must not reach the stream.
        let in_range = by_port(m, in_range, p.keep);
        let slots = by_port(m, p.slot, p.keep);
        for (reg, value) in [
            (end, p.end),
            (keep, p.keep),
            (held_in_range, in_range),
            (slot, slots),
        ] {
            m.set_next_if(reg, asks, value);
        }
        if !whole_cells {
            m.set_next_if(first, asks, p.first);
            m.set_next_if(last, asks, p.last);
        }
        let turns = issue.granted.map(|granted| {
            let reg = m.reg("s1_read", granted.ty(), 0);
            m.note(reg, "ports whose rows were read, or that have no entry");
            // A port without an entry reduces its zeros with the others' last turn.
            let void = m.not(p.keep);
            let fires = m.repeat(issue.fire, void.width());
            let void = m.and(void, fires);
            let reads = m.or(granted, void);
            m.set_next(reg, reads);
            reg
        });
        let single = is(m, vertices, 0);
        let single = m.name(single, "single_ids");
        let given = given_weight(m, config, single, p.weight);
        let given = by_port(m, given, p.keep);
        m.set_next_if(weight, asks, given);
        let upper = issue.shared.as_ref().map(|shared| {
            let reg = m.data_reg("s1_upper_record", Ty::u(ports));
            m.set_next_if(reg, asks, shared.upper);
            reg
        });
        Self {
            valid,
            first,
            last,
            end,
            keep,
            in_range: held_in_range,
            weight,
            slot,
            turns,
            upper,
            single,
        }
    }

    /// Whether a requested row is not loaded.
    pub(super) fn row_not_loaded(&self, m: &mut ModuleBuilder, config: &Config) -> Signal {
        let groups = config.vertices_a_row();
        let outside: Vec<_> = (0..config.gu.ports)
            .map(|p| {
                let kept = m.bit(self.keep, p);
                let ok = m.slice(self.in_range, p * groups, groups);
                let ok = m.all(ok);
                let outside = m.not(ok);
                m.and(kept, outside)
            })
            .collect();
        let outside = m.any_of(&outside);
        m.and(self.valid, outside)
    }
}

/// Values of the ports, 0 where a port has no entry.
fn by_port(m: &mut ModuleBuilder, values: Signal, keep: Signal) -> Signal {
    let ports = keep.width();
    let masks: Vec<_> = (0..ports)
        .rev()
        .map(|p| {
            let kept = m.bit(keep, p);
            m.repeat(kept, values.width() / ports)
        })
        .collect();
    let mask = m.cat(&masks);
    m.and(values, mask)
}

/// Weights of the issued entries; a single id has weight 1.
fn given_weight(
    m: &mut ModuleBuilder,
    config: &Config,
    single: Signal,
    of_entries: Signal,
) -> Signal {
    if config.gu.modes != Modes::Both {
        return of_entries;
    }
    let one = m.lit(1u32 << config.gu.weight_bits, Ty::u(16));
    let ones = vec![one; config.gu.ports as usize];
    let ones = m.cat(&ones);
    m.mux(single, ones, of_entries)
}
