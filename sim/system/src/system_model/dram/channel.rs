//! One channel: its controller, command bus and banks.

use std::collections::VecDeque;

use super::bank::{Bank, Command, Shared, Waiting};
use super::counts::Counts;
use super::timing::{BurstAddress, Timing};

/// Accesses that a controller holds before its banks' queues, for each direction.
const HELD: usize = 32;
/// Writes that justify a turnaround of the bus when no read waits.
const WORTH: usize = 8;
/// Activates within the window of tFAW.
const WINDOW: usize = 4;

#[derive(Debug, Clone)]
pub(super) struct Channel {
    timing: Timing,
    now: u64,
    /// No command is possible before.
    wake: u64,
    banks: Vec<Bank>,
    shared: Shared,
    reads: VecDeque<Waiting>,
    writes: VecDeque<Waiting>,
    /// Writes of the current batch still to be handed to banks.
    draining: usize,
    /// The bank with the lowest priority.
    last: usize,
    /// The last activates, oldest first.
    activates: VecDeque<u64>,
    refresh_due: u64,
    is_refresh_owed: bool,
    /// Banks with an open row, and since when at least one is open.
    open: u32,
    open_since: u64,
    done: Counts,
}

impl Channel {
    pub(super) fn new(timing: Timing, banks: u32) -> Self {
        Self {
            timing,
            now: 0,
            wake: 0,
            banks: vec![Bank::default(); banks as usize],
            shared: Shared::default(),
            reads: VecDeque::new(),
            writes: VecDeque::new(),
            draining: 0,
            last: 0,
            activates: VecDeque::new(),
            refresh_due: timing.refresh_interval,
            is_refresh_owed: false,
            open: 0,
            open_since: 0,
            done: Counts::default(),
        }
    }

    pub(super) fn has_room(&self, is_write: bool) -> bool {
        let queue = if is_write { &self.writes } else { &self.reads };
        queue.len() < HELD
    }

    pub(super) fn take(&mut self, place: BurstAddress, is_write: bool) {
        let queue = if is_write {
            &mut self.writes
        } else {
            &mut self.reads
        };
        queue.push_back(Waiting { place, is_write });
        self.wake = self.now;
    }

    /// Serves all accepted accesses to their end.
    pub(super) fn finish(&mut self) {
        while !(self.reads.is_empty() && self.writes.is_empty() && self.is_quiet()) {
            if self.reads.is_empty() && self.draining == 0 {
                self.draining = self.writes.len();
                self.wake = self.now;
            }
            self.step();
        }
    }

    fn is_quiet(&self) -> bool {
        self.banks.iter().all(Bank::is_empty)
    }

    pub(super) fn counts(&self) -> Counts {
        let since = if self.open > 0 {
            self.now - self.open_since
        } else {
            0
        };
        Counts {
            active_clocks: self.done.active_clocks + since,
            ..self.done
        }
    }

    /// One clock.
    pub(super) fn step(&mut self) {
        let now = self.now;
        self.now += 1;
        if now >= self.refresh_due {
            self.is_refresh_owed = true;
            self.refresh_due += self.timing.refresh_interval;
        } else if now < self.wake {
            return;
        }
        let next = match self.is_refresh_owed {
            true => self.refresh(now),
            false => self.command(now),
        };
        let has_moved = self.hand_on();
        self.wake = match next {
            Some(from) if !has_moved => from.min(self.refresh_due),
            _ => now + 1,
        };
    }

    /// Advances the refresh of all banks, or returns the earliest clock at which it can.
    fn refresh(&mut self, now: u64) -> Option<u64> {
        let open = self.banks.iter().enumerate().filter(|(_, b)| b.is_open());
        if let Some((at, from)) = open
            .map(|(at, bank)| (at, bank.precharge_from()))
            .min_by_key(|(_, from)| *from)
        {
            if from > now {
                return Some(from);
            }
            self.close(at, now);
            return None;
        }
        let from = self.banks.iter().map(Bank::activate_from).max();
        if let Some(from) = from.filter(|from| *from > now) {
            return Some(from);
        }
        for bank in &mut self.banks {
            bank.refresh(now, &self.timing);
        }
        self.is_refresh_owed = false;
        self.done.refreshes += 1;
        None
    }

    /// Issues a command, round-robin over the banks, or returns the earliest clock at which one can
    /// be.
    fn command(&mut self, now: u64) -> Option<u64> {
        let mut earliest = u64::MAX;
        let count = self.banks.len();
        for turn in 1..=count {
            let at = (self.last + turn) % count;
            match self.banks[at].next(now, self.shared) {
                Ok(command) => {
                    self.last = at;
                    self.issue(at, command, now);
                    return None;
                }
                Err(from) => earliest = earliest.min(from),
            }
        }
        Some(earliest)
    }

    fn issue(&mut self, at: usize, command: Command, now: u64) {
        let timing = self.timing;
        match command {
            Command::Activate { row } => {
                self.banks[at].activate(row, now, &timing);
                if self.open == 0 {
                    self.open_since = now;
                }
                self.open += 1;
                self.done.activates += 1;
                self.activates.push_back(now);
                let mut from = now + timing.activate_to_activate;
                if self.activates.len() > WINDOW {
                    self.activates.pop_front();
                }
                if self.activates.len() == WINDOW {
                    from = from.max(self.activates[0] + timing.four_activates);
                }
                self.shared.activate_from = from;
            }
            Command::Precharge => self.close(at, now),
            Command::Column {
                at: place,
                is_write,
            } => {
                self.banks[at].column(place, is_write, now, &timing);
                let (to_read, to_write, latency) = match is_write {
                    true => (
                        timing.write_to_read_command(),
                        timing.column_to_column,
                        timing.write_latency,
                    ),
                    false => (
                        timing.column_to_column,
                        timing.read_to_write(),
                        timing.read_latency,
                    ),
                };
                self.shared.read_from = self.shared.read_from.max(now + to_read);
                self.shared.write_from = self.shared.write_from.max(now + to_write);
                let count = if is_write {
                    &mut self.done.writes
                } else {
                    &mut self.done.reads
                };
                *count += 1;
                self.done.clocks = self.done.clocks.max(now + latency + timing.burst);
            }
        }
    }

    fn close(&mut self, at: usize, now: u64) {
        self.banks[at].precharge(now, &self.timing);
        self.open -= 1;
        if self.open == 0 {
            self.done.active_clocks += now - self.open_since;
        }
    }

    /// Hands the first access whose bank has room to that bank: a read, or a write while a batch of
    /// writes is served.
    fn hand_on(&mut self) -> bool {
        let is_worth = self.writes.len() >= HELD || (self.writes.len() > WORTH && self.is_quiet());
        if self.draining == 0 && is_worth {
            self.draining = self.writes.len();
        }
        let queue = match self.draining > 0 {
            true => &mut self.writes,
            false => &mut self.reads,
        };
        let banks = &mut self.banks;
        let has_room = |own: &Waiting| banks[own.place.bank as usize].has_room();
        let Some(at) = queue.iter().position(has_room) else {
            return false;
        };
        let Some(own) = queue.remove(at) else {
            return false;
        };
        if own.is_write {
            self.draining -= 1;
        }
        banks[own.place.bank as usize].take(own);
        true
    }
}
