//! Windows: the frames that each reference serves.

use std::ops::Range;

/// The first frame of each reference, and the number of frames.
#[derive(Debug)]
pub(crate) struct Windows(Vec<usize>);

impl Windows {
    /// Windows from the first frame of each reference, in order.
    pub(crate) fn starting_at(mut first: Vec<usize>, frames: usize) -> Self {
        first.push(frames);
        Self(first)
    }

    /// `references` windows of `window` frames each; the last has what remains of `frames`.
    pub(crate) fn every(window: usize, references: usize, frames: usize) -> Self {
        let first = (0..references).map(|reference| reference * window.max(1));
        Self::starting_at(first.collect(), frames)
    }

    /// Frames of the path.
    pub(crate) fn frames(&self) -> usize {
        self.0.last().copied().unwrap_or(0)
    }

    /// The frames that a reference serves. The first sets its urgency.
    pub(crate) fn of(&self, reference: usize) -> Range<usize> {
        self.0[reference]..self.0[reference + 1]
    }

    /// The reference that serves a frame.
    pub(crate) fn reference_of(&self, frame: usize) -> usize {
        let first = &self.0[..self.0.len() - 1];
        first.partition_point(|first| *first <= frame).max(1) - 1
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn windows_follow_one_another() {
        let windows = Windows::every(3, 3, 8);
        let all = [0..3, 3..6, 6..8];
        assert_eq!([0, 1, 2].map(|r| windows.of(r)), all);
        assert_eq!(windows.frames(), 8);
        for (reference, frames) in all.into_iter().enumerate() {
            let mut served = frames.map(|frame| windows.reference_of(frame));
            assert!(served.all(|own| own == reference));
        }
    }
}
