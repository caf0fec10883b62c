//! The reference buffer (paper, "Rendering Engine").

/// A slot held by a reference, from its begin until its last target has read it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Hold<M> {
    /// The reference.
    pub(crate) reference: usize,
    /// The slot.
    pub(crate) slot: usize,
    /// Moment of its begin.
    pub(crate) from: M,
    /// Moment of its release.
    pub(crate) until: M,
}

/// Slots that references are written to. A slot has at most one holder at a time.
#[derive(Debug)]
pub(super) struct Slots<M> {
    /// Holder of each slot and since when, or since when it is free.
    slots: Vec<Slot<M>>,
    /// Holds that ended, in that order.
    holds: Vec<Hold<M>>,
}

#[derive(Debug, Clone, Copy)]
enum Slot<M> {
    Free { since: M },
    SlotHold { reference: usize, from: M },
}

impl<M: Copy + Default + Ord> Slots<M> {
    pub(super) fn new(slots: usize) -> Self {
        let since = M::default();
        Self {
            slots: vec![Slot::Free { since }; slots],
            holds: vec![],
        }
    }

    /// The slot that has been free for longest, and since when.
    pub(super) fn free(&self) -> Option<(M, usize)> {
        let free = self.slots.iter().enumerate().filter_map(|(n, s)| match s {
            Slot::Free { since } => Some((*since, n)),
            Slot::SlotHold { .. } => None,
        });
        free.min()
    }

    /// Takes the slot that has been free for longest. Returns the slot and since when it was free.
    pub(super) fn take(&mut self, reference: usize, from: M) -> Option<(M, usize)> {
        let (since, slot) = self.free()?;
        self.slots[slot] = Slot::SlotHold { reference, from };
        Some((since, slot))
    }

    /// Releases the slot that a reference holds, if any.
    pub(super) fn release(&mut self, by: usize, now: M) {
        for (number, slot) in self.slots.iter_mut().enumerate() {
            if let Slot::SlotHold { reference, from } = *slot
                && reference == by
            {
                self.holds.push(Hold {
                    reference,
                    slot: number,
                    from,
                    until: now,
                });
                *slot = Slot::Free { since: now };
            }
        }
    }

    /// Holds that ended.
    pub(super) fn into_holds(self) -> Vec<Hold<M>> {
        self.holds
    }
}
