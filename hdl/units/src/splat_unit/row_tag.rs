//! What goes along with a row through the stages of the search for its pixels.

use potamoi_netlist::{ModuleBuilder, Signal, Ty};

use super::registers::moved;

/// What goes along with a row.
#[derive(Clone, Copy)]
pub(super) struct RowTag {
    /// The stage in which it is.
    pub(super) stage: u32,
    pub(super) valid: Signal,
    /// The last row of its entry.
    pub(super) last: Signal,
    /// Number of its entry.
    pub(super) index: Signal,
    pub(super) row: Signal,
}

impl RowTag {
    /// In the next stage.
    pub(super) fn moved(self, m: &mut ModuleBuilder, enable: Signal) -> Self {
        let stage = self.stage + 1;
        let valid = m.reg(&format!("valid_{stage}"), Ty::bit(), 0);
        m.set_next_if(valid, enable, self.valid);
        let mut one = |name: &str, value| moved(m, &format!("{name}_{stage}"), value, enable);
        Self {
            stage,
            valid,
            last: one("last", self.last),
            index: one("index", self.index),
            row: one("row", self.row),
        }
    }

    /// In a later stage.
    pub(super) fn until(self, m: &mut ModuleBuilder, stage: u32, enable: Signal) -> Self {
        (self.stage..stage).fold(self, |tag, _| tag.moved(m, enable))
    }
}
