//! Results of `exp` by operand. Operands have few bits and frames many exponentials: each result is
//! computed once.

use std::sync::OnceLock;
use std::sync::atomic::{AtomicU64, Ordering};

use potamoi_formats::fixed::Format;

/// Operands, at most, of a table: 2 MiB of results.
const MOST: i128 = 1 << 18;
/// Marks a result that is known.
const KNOWN: u64 = 1 << 32;

/// Results by the operand's code, filled as they are asked for.
#[derive(Debug)]
pub(crate) struct ExpTable {
    low: i64,
    high: i64,
    results: OnceLock<Box<[AtomicU64]>>,
}

impl ExpTable {
    /// An empty table over the codes of a format; `None` if those are too many.
    pub(crate) fn new(input: Format) -> Option<Self> {
        let (low, high) = (input.min(), input.max());
        (high - low < MOST).then(|| Self {
            low: low as i64,
            high: high as i64,
            results: OnceLock::new(),
        })
    }

    /// The result of `a`, which is clamped to the format; `compute` gives one that is not known.
    pub(crate) fn of(&self, a: i32, compute: impl FnOnce(i32) -> i32) -> i32 {
        let results = self.results.get_or_init(|| {
            let count = self.high - self.low + 1;
            (0..count).map(|_| AtomicU64::new(0)).collect()
        });
        let code = i64::from(a).clamp(self.low, self.high);
        let slot = &results[(code - self.low) as usize];
        // Threads that find one at the same time find the same.
        match slot.load(Ordering::Relaxed) {
            0 => {
                let found = compute(a);
                slot.store(KNOWN | u64::from(found as u32), Ordering::Relaxed);
                found
            }
            known => known as u32 as i32,
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn every_operand_is_computed_once_and_those_outside_are_the_ends() {
        let table = ExpTable::new(Format::signed(0, 3)).unwrap();
        let mut asked = vec![];
        for a in [-9, -8, i32::MIN, 0, 7, 8, 0, i32::MAX, -1] {
            let code = a.clamp(-8, 7);
            let found = table.of(a, |a| {
                asked.push(a);
                -3 * a.clamp(-8, 7)
            });
            assert_eq!(found, -3 * code, "{a}");
        }
        assert_eq!(asked, [-9, 0, 7, -1]);
        assert!(ExpTable::new(Format::unsigned(4, 20)).is_none());
    }
}
