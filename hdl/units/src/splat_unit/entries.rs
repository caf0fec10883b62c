//! Entries whose pixels are in flight, by their number.

use potamoi_netlist::{MemId, ModuleBuilder, Signal};

use super::formats::{ENTRIES, STEP, Widths};

/// Bits of an entry's number while its pixels are in flight.
pub(super) const INDEX: u32 = ENTRIES.ilog2();

/// What an entry's pixels need, by its number.
pub(super) struct Entries {
    memory: MemId,
    /// Widths of the fields, the lowest first.
    widths: Vec<u32>,
}

/// Fields of a stored entry.
pub(super) struct Entry {
    pub(super) l11: Signal,
    pub(super) last_x: Signal,
    pub(super) slot: Signal,
    pub(super) limit: Signal,
    pub(super) opacity: Signal,
    pub(super) colour: Signal,
}

impl Entries {
    pub(super) fn declare(m: &mut ModuleBuilder, w: &Widths) -> Self {
        let widths = vec![STEP, 4, w.slot, w.power, 16, 48];
        let all = widths.iter().sum();
        let memory = m.memory("entries", ENTRIES, all, "entries with pixels in flight");
        Self { memory, widths }
    }

    pub(super) fn write(&self, m: &mut ModuleBuilder, enable: Signal, index: Signal, word: Signal) {
        m.mem_write(self.memory, enable, index, word);
    }

    /// The entry of a number; its word is named.
    pub(super) fn read(&self, m: &mut ModuleBuilder, index: Signal, name: &str) -> Entry {
        let word = m.mem_read_async(self.memory, index);
        let word = m.name(word, name);
        let mut at = 0;
        let mut next = |m: &mut ModuleBuilder, width: u32| {
            at += width;
            m.slice(word, at - width, width)
        };
        let fields: Vec<Signal> = self.widths.iter().map(|w| next(m, *w)).collect();
        Entry {
            l11: m.as_signed(fields[0]),
            last_x: fields[1],
            slot: fields[2],
            limit: fields[3],
            opacity: fields[4],
            colour: fields[5],
        }
    }
}
