//! The reference buffer (paper, "Rendering Engine").

use super::{Held, Nanos};

/// Slots that references are written to. One is taken by a reference until it is
/// given back, and by no other meanwhile.
#[derive(Debug)]
pub(super) struct Buffer {
    /// Of each slot: who holds it since when, or since when it is free.
    slots: Vec<Slot>,
    /// Who has held slots until when.
    pub(super) held: Vec<Held>,
}

#[derive(Debug, Clone, Copy)]
enum Slot {
    Free { since: Nanos },
    Held { reference: usize, from: Nanos },
}

impl Buffer {
    pub(super) fn new(slots: usize) -> Self {
        Self {
            slots: vec![Slot::Free { since: 0 }; slots],
            held: vec![],
        }
    }

    /// The slot that has been free for longest, and since when.
    pub(super) fn free(&self) -> Option<(Nanos, usize)> {
        let free = self.slots.iter().enumerate().filter_map(|(n, s)| match s {
            Slot::Free { since } => Some((*since, n)),
            Slot::Held { .. } => None,
        });
        free.min()
    }

    /// Takes a slot that is free.
    pub(super) fn take(&mut self, slot: usize, reference: usize, from: Nanos) {
        debug_assert!(matches!(self.slots[slot], Slot::Free { .. }));
        self.slots[slot] = Slot::Held { reference, from };
    }

    /// Gives back the slot that a reference holds, if it does.
    pub(super) fn release(&mut self, by: usize, now: Nanos) {
        for (number, slot) in self.slots.iter_mut().enumerate() {
            if let Slot::Held { reference, from } = *slot
                && reference == by
            {
                self.held.push(Held {
                    reference,
                    slot: number,
                    from,
                    until: now,
                });
                *slot = Slot::Free { since: now };
            }
        }
    }
}
