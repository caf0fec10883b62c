//! Choices and values with which random modules are grown and fed.

use crate::choices::Random;

impl Random {
    pub(crate) fn chance(&mut self, percent: u64) -> bool {
        self.next() % 100 < percent
    }

    /// A value of `width` bits, low word first: often one at which arithmetic
    /// goes wrong, such as 0, all ones, and both sides of the sign.
    pub(crate) fn edge_value(&mut self, width: u32) -> Vec<u32> {
        let count = width.div_ceil(32) as usize;
        let top = 1u32 << ((width - 1) % 32);
        let last = count - 1;
        let mut words = vec![0; count];
        match self.below(8) {
            0 => {}
            1 => words.fill(u32::MAX),
            2 => words[last] = top,
            3 => {
                words.fill(u32::MAX);
                words[last] = top - 1;
            }
            4 => words[0] = self.next() as u32 % 16,
            _ => words.fill_with(|| self.next() as u32),
        }
        words[last] &= top | (top - 1);
        words
    }
}
