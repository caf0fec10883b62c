//! Forms of a record, and its rows.

use std::collections::VecDeque;
use std::rc::Rc;

use super::Entry;
use super::tiles::Live;

/// Products of a record: a factor times half an offset each.
pub(super) const PHASES: u32 = 6;
/// Clocks from the last product to the rows.
const SETTLES: u32 = 4;
/// Stages from a row to its live pixels.
const STAGES: usize = 12;
/// Records whose pixels are in flight before the exponential.
const ENTRIES: usize = 8;
/// Rows that wait for their pixels.
pub(super) const ROWS: usize = 4;

/// Clocks from a record to its first row.
pub(super) const CYCLES: usize = PHASES as usize + SETTLES as usize + 2 + STAGES;

/// A row of a record.
#[derive(Clone)]
pub(super) struct Row {
    pub(super) entry: Rc<Entry>,
    pub(super) row: usize,
    pub(super) is_last: bool,
    /// Pixels to walk.
    pub(super) mask: u16,
}

/// Registers.
#[derive(Default)]
pub(super) struct Front {
    held: Option<Rc<Entry>>,
    phase: u32,
    settling: Option<Rc<Entry>>,
    settled: u32,
    searched: Option<(Rc<Entry>, u16)>,
    in_flight: usize,
    stages: [Option<Row>; STAGES],
    rows: VecDeque<Row>,
}

impl Front {
    /// Whether a record leaves the products.
    fn leaves(&self) -> bool {
        self.held.is_some() && self.phase == PHASES - 1 && self.settling.is_none()
    }

    /// Whether a record is taken at the clock edge.
    pub(super) fn is_ready(&self) -> bool {
        self.held.is_none() || self.leaves()
    }

    pub(super) fn is_busy(&self) -> bool {
        self.held.is_some() || self.settling.is_some() || self.in_flight > 0
    }

    /// The oldest row that waits.
    pub(super) fn row(&self) -> Option<&Row> {
        self.rows.front()
    }

    /// One clock edge.
    pub(super) fn step(
        &mut self,
        accepted: Option<Rc<Entry>>,
        live: &Live,
        takes_row: bool,
        released: bool,
    ) {
        let leaves = self.leaves();
        let has_room = self.rows.len() != ROWS;
        let ends = |(_, left): &(_, u16)| left & (left - 1) == 0;
        let is_free = self
            .searched
            .as_ref()
            .is_none_or(|own| has_room && ends(own));
        let takes = is_free && self.in_flight != ENTRIES;
        let found = |entry: &Rc<Entry>| entry.pairs.rows & live.rows_alive(entry.slot);

        let pushed = self.stages[STAGES - 1].take_if(|_| has_room);
        // The row that enters the last stage was asked for its live pixels.
        if let Some(row) = &mut self.stages[STAGES - 2] {
            row.mask = row.entry.pairs.spans[row.row] & live.row(row.entry.slot, row.row);
        }
        if takes_row {
            self.rows.pop_front();
        }
        self.rows
            .extend(pushed.filter(|row| row.mask != 0 || row.is_last));
        if has_room {
            self.stages.rotate_right(1);
            self.stages[0] = self.searched.take().map(|(entry, left)| {
                let rest = left & (left - 1);
                let row = Row {
                    entry: Rc::clone(&entry),
                    row: left.trailing_zeros() as usize,
                    is_last: rest == 0,
                    mask: 0,
                };
                self.searched = (rest != 0).then_some((entry, rest));
                row
            });
        }
        let is_settled = self.settled == SETTLES;
        let gone = self
            .settling
            .take_if(|own| is_settled && (found(own) == 0 || takes));
        self.in_flight -= usize::from(released);
        if let Some(entry) = gone.filter(|own| found(own) != 0) {
            let rows = found(&entry);
            self.searched = Some((entry, rows));
            self.in_flight += 1;
        }
        self.settled = match leaves {
            true => 0,
            false => (self.settled + u32::from(self.settling.is_some())).min(SETTLES),
        };
        if leaves {
            self.settling = self.held.take();
        }
        self.phase = match (&accepted, &self.held) {
            (Some(_), _) => 0,
            (None, Some(_)) => (self.phase + 1).min(PHASES - 1),
            (None, None) => self.phase,
        };
        self.held = accepted.or_else(|| self.held.take());
    }
}
