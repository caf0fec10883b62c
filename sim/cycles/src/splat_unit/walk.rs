//! Pixels of rows, one a clock: the power of each, and the cut.

use super::Pair;
use super::front::Row;

/// Stages from a pixel to the cut.
const STAGES: usize = 4;

/// A pixel in a stage.
struct Step {
    pair: Option<Pair>,
    /// It is the last one of its record.
    is_last: bool,
}

/// Registers.
#[derive(Default)]
pub(super) struct Walk {
    /// Pixels of the oldest row that are left, once some were walked.
    left: Option<u16>,
    stages: [Option<Step>; STAGES],
    kept: Option<Pair>,
}

/// What a clock edge did.
pub(super) struct Walked {
    pub(super) takes_row: bool,
    /// A record has no more pixels.
    pub(super) released: bool,
    pub(super) summed: bool,
}

impl Walk {
    /// Whether a pair that the cut kept is offered.
    pub(super) fn is_busy(&self) -> bool {
        self.kept.is_some()
    }

    /// The pair that the cut kept.
    pub(super) fn kept(&self) -> Option<Pair> {
        self.kept.clone()
    }

    /// One clock edge.
    pub(super) fn step(&mut self, taken: bool, row: Option<&Row>) -> Walked {
        let mut walked = Walked {
            takes_row: false,
            released: false,
            summed: false,
        };
        if self.kept.is_some() && !taken {
            return walked;
        }
        let compared = self.stages[STAGES - 1].take();
        self.kept = None;
        if let Some(Step { pair, is_last }) = compared {
            walked.released = is_last;
            walked.summed = pair.is_some();
            self.kept = pair.filter(|pair| pair.alpha().is_some());
        }
        self.stages.rotate_right(1);
        self.stages[0] = row.map(|row| {
            let left = self.left.unwrap_or(row.mask);
            let rest = left & left.wrapping_sub(1);
            walked.takes_row = rest == 0;
            self.left = (rest != 0).then_some(rest);
            Step {
                pair: (left != 0).then(|| Pair {
                    entry: row.entry.clone(),
                    row: row.row,
                    column: left.trailing_zeros() as usize,
                }),
                is_last: row.is_last && rest == 0,
            }
        });
        walked
    }
}
