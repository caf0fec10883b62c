//! Pixels of rows, one a clock: the power of each, and the cut.

use super::Pair;
use super::front::Row;

/// Stages from a pixel to the cut.
const STAGES: usize = 7;
/// Clocks from a row to its first pair, which is offered.
pub(super) const CYCLES: usize = STAGES + 2;

/// A pixel in a stage.
struct Step {
    pair: Option<Pair>,
    /// It is the last one of its record.
    is_last: bool,
}

/// Registers.
#[derive(Default)]
pub(super) struct Walk {
    /// The row whose pixels are walked, and those that are left.
    walked: Option<(Row, u16)>,
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
        if self.kept.is_none() || taken {
            self.advance(&mut walked);
        }
        if self.walked.is_none() {
            self.walked = row.map(|row| (row.clone(), row.mask));
            walked.takes_row = row.is_some();
        }
        walked
    }

    /// All stages move, and the row gives its next pixel.
    fn advance(&mut self, walked: &mut Walked) {
        self.kept = None;
        if let Some(Step { pair, is_last }) = self.stages[STAGES - 1].take() {
            walked.released = is_last;
            walked.summed = pair.is_some();
            self.kept = pair.filter(|pair| pair.alpha().is_some());
        }
        self.stages.rotate_right(1);
        self.stages[0] = self.walked.take().map(|(row, left)| {
            let rest = left & left.wrapping_sub(1);
            let step = Step {
                pair: (left != 0).then(|| Pair {
                    entry: row.entry.clone(),
                    row: row.row,
                    column: left.trailing_zeros() as usize,
                }),
                is_last: row.is_last && rest == 0,
            };
            self.walked = (rest != 0).then_some((row, rest));
            step
        });
    }
}
