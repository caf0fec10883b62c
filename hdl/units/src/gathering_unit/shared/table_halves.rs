//! The two halves of the MVoxel feature table in any organisation: the one written, the one read,
//! and their numbers of rows.

use potamoi_netlist::{ModuleBuilder, Signal, Ty};

/// State of the halves.
pub(crate) struct TableHalves {
    loaded: [Signal; 2],
    rows: [Signal; 2],
    /// The half being written, and the half being read.
    pub(crate) write: Signal,
    pub(crate) read: Signal,
}

/// The half being read.
pub(crate) struct Readable {
    pub(crate) is_loaded: Signal,
    pub(crate) rows: Signal,
}

impl TableHalves {
    /// Declares the halves, with row counts of type `rows`.
    pub(crate) fn declare(m: &mut ModuleBuilder, rows: Ty) -> Self {
        m.section("State of each half");
        Self {
            loaded: [0, 1].map(|h| m.reg(&format!("loaded_{h}"), Ty::bit(), 0)),
            rows: [0, 1].map(|h| m.data_reg(&format!("rows_{h}"), rows)),
            write: m.reg("write_half", Ty::bit(), 0),
            read: m.reg("read_half", Ty::bit(), 0),
        }
    }

    /// Whether the half being written is free: the stream's ready.
    pub(crate) fn ready(&self, m: &mut ModuleBuilder) -> Signal {
        let full = m.mux(self.write, self.loaded[1], self.loaded[0]);
        let ready = m.not(full);
        m.name(ready, "write_ready")
    }

    /// Whether each half is loaded, half 0 lowest.
    pub(crate) fn loaded(&self, m: &mut ModuleBuilder) -> Signal {
        let loaded = m.cat(&[self.loaded[1], self.loaded[0]]);
        m.name(loaded, "loaded")
    }

    /// The half that was read last.
    pub(crate) fn read_last(&self, m: &mut ModuleBuilder, read: Signal) -> Signal {
        let half = m.data_reg("half_of_words", Ty::bit());
        m.note(half, "half of the words read last");
        m.set_next_if(half, read, self.read);
        half
    }

    /// Whether no half is loaded and none is partly written.
    pub(crate) fn is_empty(&self, m: &mut ModuleBuilder, partly: &[Signal]) -> Signal {
        let mut holds = self.loaded.to_vec();
        holds.extend(partly);
        let holds = m.any_of(&holds);
        m.not(holds)
    }

    /// Switches halves: the writer with `loads`, which stores the number of rows, and the reader
    /// with `release`.
    pub(crate) fn advance(
        &self,
        m: &mut ModuleBuilder,
        loads: Signal,
        rows: Signal,
        release: Signal,
    ) -> Readable {
        m.section("The halves change hands");
        let other = m.not(self.write);
        let other = m.name(other, "other_write_half");
        m.set_next_if(self.write, loads, other);
        let other_read = m.not(self.read);
        let other_read = m.name(other_read, "other_read_half");
        for (h, written, read) in [(0, other, other_read), (1, self.write, self.read)] {
            let fills = m.and(loads, written);
            let fills = m.name(fills, &format!("load_{h}"));
            let frees = m.and(release, read);
            let stays = m.not(frees);
            let kept = m.and(self.loaded[h], stays);
            let next = m.or(fills, kept);
            m.set_next(self.loaded[h], next);
            m.set_next_if(self.rows[h], fills, rows);
        }
        m.set_next_if(self.read, release, other_read);
        let rows = m.mux(self.read, self.rows[1], self.rows[0]);
        Readable {
            is_loaded: m.mux(self.read, self.loaded[1], self.loaded[0]),
            rows: m.name(rows, "read_count"),
        }
    }
}
