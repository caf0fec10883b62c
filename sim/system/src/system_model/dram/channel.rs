//! One channel: its controller, command bus, ranks and banks.

use std::collections::VecDeque;

use super::bank::{Bank, Command, Shared, Waiting};
use super::counts::Counts;
use super::timing::{BurstAddress, Geometry, Relation, Timing};

/// Accesses that a controller holds before its banks' queues, for each direction.
pub(super) const HELD: usize = 32;
/// Writes that justify a turnaround of the bus when no read waits.
const WORTH: usize = 8;
/// Activates within the window of tFAW.
const WINDOW: usize = 4;

/// What the banks of a rank share.
#[derive(Debug, Clone, Default)]
struct Rank {
    /// The last activates, oldest first.
    activates: VecDeque<u64>,
    /// Banks with an open row, and since when at least one is open.
    open: u32,
    open_since: u64,
}

#[derive(Debug, Clone)]
pub(super) struct Channel {
    timing: Timing,
    /// Banks of a rank, and of a group.
    banks_of: [usize; 2],
    now: u64,
    /// No command is possible before.
    wake: u64,
    /// By rank, then group.
    banks: Vec<Bank>,
    /// By rank, then group.
    shared: Vec<Shared>,
    ranks: Vec<Rank>,
    reads: VecDeque<Waiting>,
    writes: VecDeque<Waiting>,
    /// Writes of the current batch still to be handed to banks.
    draining: usize,
    /// The bank with the lowest priority.
    last: usize,
    refresh_due: u64,
    /// The rank that is due next; ranks take turns within the interval.
    next_due: usize,
    /// Ranks that wait for their refresh, in order.
    owed: VecDeque<usize>,
    done: Counts,
}

impl Channel {
    pub(super) fn new(geometry: &Geometry, timing: Timing) -> Self {
        let [ranks, groups, banks] =
            [geometry.ranks, geometry.bank_groups, geometry.banks].map(|n| n as usize);
        Self {
            timing,
            banks_of: [banks, banks / groups],
            now: 0,
            wake: 0,
            banks: vec![Bank::default(); ranks * banks],
            shared: vec![Shared::default(); ranks * groups],
            ranks: vec![Rank::default(); ranks],
            reads: VecDeque::new(),
            writes: VecDeque::new(),
            draining: 0,
            last: 0,
            refresh_due: timing.refresh_interval / ranks as u64,
            next_due: 0,
            owed: VecDeque::new(),
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
        let open = self.ranks.iter().filter(|rank| rank.open > 0);
        let since: u64 = open.map(|rank| self.now - rank.open_since).sum();
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
            self.owed.push_back(self.next_due);
            self.next_due = (self.next_due + 1) % self.ranks.len();
            self.refresh_due += self.timing.refresh_interval / self.ranks.len() as u64;
        } else if now < self.wake {
            return;
        }
        let next = match self.owed.front().copied() {
            None => self.command(now, None),
            // The other ranks work on.
            Some(rank) => match self.refresh(rank, now) {
                None => None,
                Some(from) => (self.command(now, Some(rank))).map(|other| other.min(from)),
            },
        };
        let has_moved = self.hand_on();
        self.wake = match next {
            Some(from) if !has_moved => from.min(self.refresh_due),
            _ => now + 1,
        };
    }

    /// Advances the refresh of all banks of a rank, or returns the earliest clock at which it can.
    fn refresh(&mut self, rank: usize, now: u64) -> Option<u64> {
        let [banks, _] = self.banks_of;
        let own = rank * banks..(rank + 1) * banks;
        let open = own.clone().filter(|at| self.banks[*at].is_open());
        if let Some((at, from)) = open
            .map(|at| (at, self.precharge_from(at)))
            .min_by_key(|(_, from)| *from)
        {
            if from > now {
                return Some(from);
            }
            self.close(at, now);
            return None;
        }
        let banks = &mut self.banks[own];
        let from = banks.iter().map(Bank::activate_from).max();
        if let Some(from) = from.filter(|from| *from > now) {
            return Some(from);
        }
        for bank in banks {
            bank.refresh(now, &self.timing);
        }
        self.owed.pop_front();
        self.done.refreshes += 1;
        None
    }

    /// Earliest clock of a bank's precharge.
    fn precharge_from(&self, at: usize) -> u64 {
        let shared = self.shared[at / self.banks_of[1]].precharge_from;
        self.banks[at].precharge_from().max(shared)
    }

    /// Issues a command, round-robin over the banks but for those of a rank, or returns the earliest
    /// clock at which one can be.
    fn command(&mut self, now: u64, but: Option<usize>) -> Option<u64> {
        let [of_rank, of_group] = self.banks_of;
        let mut earliest = u64::MAX;
        let count = self.banks.len();
        for turn in 1..=count {
            let at = (self.last + turn) % count;
            if but == Some(at / of_rank) {
                continue;
            }
            match self.banks[at].next(now, self.shared[at / of_group]) {
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

    /// What the banks of a rank share, group by group.
    fn shared_of(&mut self, rank: usize) -> &mut [Shared] {
        let groups = self.banks_of[0] / self.banks_of[1];
        &mut self.shared[rank * groups..(rank + 1) * groups]
    }

    fn activate(&mut self, at: usize, row: u64, now: u64) {
        let timing = self.timing;
        self.banks[at].activate(row, now, &timing);
        let of = at / self.banks_of[0];
        let rank = &mut self.ranks[of];
        if rank.open == 0 {
            rank.open_since = now;
        }
        rank.open += 1;
        self.done.activates += 1;
        rank.activates.push_back(now);
        let mut from = now + timing.activate_to_activate;
        if rank.activates.len() > WINDOW {
            rank.activates.pop_front();
        }
        if rank.activates.len() == WINDOW {
            from = from.max(rank.activates[0] + timing.four_activates);
        }
        for shared in self.shared_of(of) {
            shared.activate_from = from;
        }
    }

    fn column(&mut self, at: usize, place: usize, is_write: bool, now: u64) {
        let timing = self.timing;
        self.banks[at].column(place, is_write, now, &timing);
        let [of_rank, of_group] = self.banks_of;
        for (group, shared) in self.shared.iter_mut().enumerate() {
            let relation = match group {
                same if same == at / of_group => Relation::SameGroup,
                other if other * of_group / of_rank == at / of_rank => Relation::OtherGroup,
                _ => Relation::OtherRank,
            };
            let [read, write] = timing.after_column(is_write, relation);
            shared.read_from = shared.read_from.max(now + read);
            shared.write_from = shared.write_from.max(now + write);
        }
        let (count, latency) = match is_write {
            true => (&mut self.done.writes, timing.write_latency),
            false => (&mut self.done.reads, timing.read_latency),
        };
        *count += 1;
        self.done.clocks = self.done.clocks.max(now + latency + timing.burst);
    }

    fn issue(&mut self, at: usize, command: Command, now: u64) {
        match command {
            Command::Activate { row } => self.activate(at, row, now),
            Command::Precharge => self.close(at, now),
            Command::Column {
                at: place,
                is_write,
            } => self.column(at, place, is_write, now),
        }
    }

    fn close(&mut self, at: usize, now: u64) {
        self.banks[at].precharge(now, &self.timing);
        let of = at / self.banks_of[0];
        let from = now + self.timing.precharge_to_precharge;
        for shared in self.shared_of(of) {
            shared.precharge_from = from;
        }
        let rank = &mut self.ranks[of];
        rank.open -= 1;
        if rank.open == 0 {
            self.done.active_clocks += now - rank.open_since;
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
