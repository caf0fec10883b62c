//! Which frames wait for which (paper, "Proactive Rendering Runtime").
//!
//! A reference serves a run of frames, its window. It begins when its pose is known and a slot of
//! the reference buffer is free; a slot is free again when the last frame of the window that held
//! it is made. What a frame needs soonest begins first. [`runtime`](crate::runtime) keeps these
//! rules as things happen, a renderer doing one frame at a time; [`soc`](crate::soc) as
//! dependencies of jobs, since there frames overlap on units that share memory.

use std::ops::Range;

/// References that the buffer holds: one is written while the other is read.
pub(crate) const REFERENCE_SLOTS: usize = 2;

/// The first frame of each reference, and the number of frames.
#[derive(Debug)]
pub(crate) struct Windows(Vec<usize>);

impl Windows {
    /// By the first frame of each reference, in order.
    pub(crate) fn starting_at(mut first: Vec<usize>, frames: usize) -> Self {
        first.push(frames);
        Self(first)
    }

    /// So many references, one every `window` frames.
    pub(crate) fn every(window: usize, references: usize, frames: usize) -> Self {
        let first = (0..references).map(|reference| reference * window.max(1));
        Self::starting_at(first.collect(), frames)
    }

    /// The frames that a reference serves. The first of them is how urgent the reference is.
    pub(crate) fn of(&self, reference: usize) -> Range<usize> {
        self.0[reference]..self.0[reference + 1]
    }

    /// The reference that serves a frame.
    pub(crate) fn reference_of(&self, frame: usize) -> usize {
        let first = &self.0[..self.0.len() - 1];
        first.partition_point(|first| *first <= frame).max(1) - 1
    }

    /// The frame that has to be made before a reference has a slot, all before it being made in
    /// order; none of the first references.
    pub(crate) fn frees_slot_of(&self, reference: usize) -> Option<usize> {
        let held_by = reference.checked_sub(REFERENCE_SLOTS)?;
        Some(self.of(held_by).end - 1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn windows_follow_one_another_and_two_references_are_held() {
        let windows = Windows::every(3, 3, 8);
        let all = [0..3, 3..6, 6..8];
        assert_eq!([0, 1, 2].map(|r| windows.of(r)), all);
        for (reference, frames) in all.into_iter().enumerate() {
            assert!(
                frames
                    .into_iter()
                    .all(|f| windows.reference_of(f) == reference)
            );
        }
        let freed = [0, 1, 2].map(|r| windows.frees_slot_of(r));
        assert_eq!(freed, [None, None, Some(2)]);
    }
}
