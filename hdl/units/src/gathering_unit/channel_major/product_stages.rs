//! Pipeline stages after stage 1, for the products.

use potamoi_formats::config::Config;
use potamoi_netlist::{ModuleBuilder, Signal, Ty};

use super::stage_one::StageOne;
use crate::gathering_unit::shared::reducer::stage_name;

/// Control signals of the summed terms.
pub(super) struct Summed {
    pub(super) valid: Signal,
    /// Arrival of terms: at all ports with `valid`, or one bit per port where ports take turns.
    pub(super) arrives: Signal,
    pub(super) first: Signal,
    pub(super) last: Signal,
    pub(super) end: Signal,
    pub(super) keep: Signal,
    pub(super) slot: Signal,
    /// Enables of the stages after stage 1, by their names at the reducers.
    pub(super) enables: Vec<(&'static str, Signal)>,
}

/// Stage 1 itself, or the last stage after it where products are registered.
pub(super) fn summed(m: &mut ModuleBuilder, config: &Config, s1: &StageOne) -> Summed {
    let (whole_cells, turns) = (config.is_parity(), s1.turns);
    let mut stage = Summed {
        valid: s1.valid,
        arrives: turns.unwrap_or(s1.valid),
        first: s1.first,
        last: s1.last,
        end: s1.end,
        keep: s1.keep,
        slot: s1.slot,
        enables: vec![],
    };
    // What one stage holds enables the next one.
    for next in config.reducer_pipeline().stages().skip(1) {
        let name = stage_name(next);
        if stage.enables.is_empty() {
            m.section("Stages of the products");
        }
        let valid = m.reg(&format!("{name}_valid"), Ty::bit(), 0);
        m.set_next(valid, stage.valid);
        let (before, arrives) = match turns {
            None => (stage.valid, valid),
            Some(read) => {
                let arrives = m.reg(&format!("{name}_read"), read.ty(), 0);
                m.set_next(arrives, stage.arrives);
                (m.any(stage.arrives), arrives)
            }
        };
        let mut follow = |what: &str, from: Signal| {
            let reg = m.data_reg(&format!("{name}_{what}"), from.ty());
            m.set_next_if(reg, before, from);
            reg
        };
        let mut enables = stage.enables;
        enables.push((name, arrives));
        stage = Summed {
            valid,
            arrives,
            first: if whole_cells {
                stage.first
            } else {
                follow("first", stage.first)
            },
            last: if whole_cells {
                stage.last
            } else {
                follow("last", stage.last)
            },
            end: follow("end", stage.end),
            keep: follow("keep", stage.keep),
            slot: follow("slot", stage.slot),
            enables,
        };
    }
    stage
}
