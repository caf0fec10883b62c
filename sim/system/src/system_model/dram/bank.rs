//! One bank: its row, and the earliest clocks of its commands.

use std::collections::VecDeque;

use super::timing::{BurstAddress, Timing};

/// An access that waits for its bank.
#[derive(Debug, Clone, Copy)]
pub(super) struct Waiting {
    pub(super) place: BurstAddress,
    pub(super) is_write: bool,
}

/// The next command of a bank.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Command {
    Activate {
        row: u64,
    },
    Precharge,
    /// A read or write of the access at this index of the queue.
    Column {
        at: usize,
        is_write: bool,
    },
}

/// Row hits in sequence after which other accesses come first.
const HITS: u32 = 4;
/// Accesses in a bank's queue.
pub(super) const QUEUE: usize = 8;

/// Earliest clocks of commands on the resources that banks share, for the banks of a group.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Shared {
    pub(super) activate_from: u64,
    pub(super) precharge_from: u64,
    pub(super) read_from: u64,
    pub(super) write_from: u64,
}

#[derive(Debug, Clone, Default)]
pub(super) struct Bank {
    row: Option<u64>,
    /// Accesses served since the row was opened.
    hits: u32,
    queue: VecDeque<Waiting>,
    /// Earliest clocks of commands.
    activate_from: u64,
    precharge_from: u64,
    column_from: u64,
}

impl Bank {
    pub(super) const fn is_open(&self) -> bool {
        self.row.is_some()
    }

    pub(super) fn is_empty(&self) -> bool {
        self.queue.is_empty()
    }

    pub(super) fn has_room(&self) -> bool {
        self.queue.len() < QUEUE
    }

    pub(super) fn take(&mut self, waiting: Waiting) {
        self.queue.push_back(waiting);
    }

    /// The command for the first waiting access that can have one at `now`; else the earliest clock
    /// of a command.
    pub(super) fn next(&self, now: u64, shared: Shared) -> Result<Command, u64> {
        let mut earliest = u64::MAX;
        for (at, own) in self.queue.iter().enumerate() {
            let (command, from) = match self.row {
                None => {
                    let from = self.activate_from.max(shared.activate_from);
                    (Command::Activate { row: own.place.row }, from)
                }
                Some(row) if row == own.place.row => {
                    let is_write = own.is_write;
                    let bus = if is_write {
                        shared.write_from
                    } else {
                        shared.read_from
                    };
                    (Command::Column { at, is_write }, self.column_from.max(bus))
                }
                // The oldest alone opens another row, when no hit waits or enough were served.
                Some(row) if at == 0 && (self.hits >= HITS || !self.has_hit(row)) => (
                    Command::Precharge,
                    self.precharge_from.max(shared.precharge_from),
                ),
                Some(_) => continue,
            };
            if from <= now {
                return Ok(command);
            }
            earliest = earliest.min(from);
            if self.row.is_none() {
                break;
            }
        }
        Err(earliest)
    }

    fn has_hit(&self, row: u64) -> bool {
        self.queue.iter().any(|own| own.place.row == row)
    }

    /// Earliest clock of a precharge.
    pub(super) const fn precharge_from(&self) -> u64 {
        self.precharge_from
    }

    /// Earliest clock of an activate or a refresh.
    pub(super) const fn activate_from(&self) -> u64 {
        self.activate_from
    }

    pub(super) fn activate(&mut self, row: u64, now: u64, timing: &Timing) {
        self.row = Some(row);
        self.hits = 0;
        self.column_from = now + timing.activate_to_column;
        self.precharge_from = now + timing.activate_to_precharge;
        self.activate_from = self.precharge_from + timing.precharge;
    }

    pub(super) fn precharge(&mut self, now: u64, timing: &Timing) {
        self.row = None;
        self.activate_from = self.activate_from.max(now + timing.precharge);
    }

    pub(super) fn refresh(&mut self, now: u64, timing: &Timing) {
        self.activate_from = now + timing.refresh;
    }

    pub(super) fn column(&mut self, at: usize, is_write: bool, now: u64, timing: &Timing) {
        self.hits += 1;
        self.queue.remove(at);
        let after = match is_write {
            true => timing.write_to_precharge(),
            false => timing.read_to_precharge,
        };
        self.precharge_from = self.precharge_from.max(now + after);
    }
}
