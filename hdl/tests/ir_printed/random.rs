//! A seeded source of choices, the same on every machine.

/// SplitMix64.
pub(crate) struct Random(u64);

impl Random {
    pub(crate) fn new(seed: u64) -> Self {
        Self(seed)
    }

    pub(crate) fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut x = self.0;
        x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        x ^ (x >> 31)
    }

    /// A number from 0 to `end - 1`.
    pub(crate) fn below(&mut self, end: usize) -> usize {
        (self.next() % end as u64) as usize
    }

    pub(crate) fn chance(&mut self, percent: u64) -> bool {
        self.next() % 100 < percent
    }

    pub(crate) fn pick<T: Copy>(&mut self, from: &[T]) -> T {
        from[self.below(from.len())]
    }

    /// A value of `width` bits, low word first: often one at which arithmetic
    /// goes wrong, such as 0, all ones, and both sides of the sign.
    pub(crate) fn value(&mut self, width: u32) -> Vec<u32> {
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
