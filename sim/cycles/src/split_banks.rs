//! Banks split by row: ports take turns at the table.
//!
//! Their cycles depend on which rows are read. [`turns`] counts them from the entries
//! alone; [`SplitRun`] is the work with them, for [`GatherModel::of_turns`] and
//! [`split_cycles`](super::closed_form::split_cycles). Rules: `docs/reference/gathering-unit.md`.
//!
//! [`GatherModel::of_turns`]: super::gathering_unit::GatherModel::of_turns

use potamoi_formats::config::{Config, ExtraPorts};
use potamoi_formats::rit::{RitEntry, Vertices};

use super::bank_rounds::Rounds;
use super::work::{GatherRun, WorkError};

/// Rows that a part of a bank reads at once.
const READS: u16 = 2;

/// Turns of each vertex of every M entries: a part reads two rows a turn, and the part with the
/// most reads decides.
#[must_use]
pub fn turns(config: &Config, vertices: Vertices, entries: &[RitEntry]) -> Vec<Rounds> {
    let parts = config.table_parts() as usize;
    let group = |entries: &[RitEntry]| {
        let mut turns = Rounds::default();
        for (v, turns) in turns.iter_mut().enumerate().take(vertices.count()) {
            let mut asked = vec![0u16; parts];
            for entry in entries {
                asked[usize::from(entry.rows[v]) % parts] += 1;
            }
            let most = asked.into_iter().max().unwrap_or(0);
            *turns = most.div_ceil(READS);
        }
        turns
    };
    entries
        .chunks(config.gu.ports.max(1) as usize)
        .map(group)
        .collect()
}

/// A run on a unit whose ports take turns.
#[derive(Debug, Clone, Copy)]
pub struct SplitRun<'a> {
    /// MVoxels, entry size and segments.
    pub run: GatherRun<'a>,
    /// For each MVoxel, the turns of each M entries.
    pub turns: &'a [Vec<Rounds>],
}

impl SplitRun<'_> {
    /// Checks that a unit of `config` can do this work.
    ///
    /// # Errors
    /// Names the problem.
    pub fn check(&self, config: &Config) -> Result<(), WorkError> {
        self.run.check(config)?;
        for (index, mvoxel) in self.run.mvoxels.iter().enumerate() {
            let expected = mvoxel.entries.div_ceil(config.gu.ports) as usize;
            let given = self.turns.get(index).map_or(&[][..], |turns| turns);
            if given.len() != expected {
                let problem = format!("turns of {} groups: expected {expected}", given.len());
                return Err(WorkError::Rounds { index, problem });
            }
            let vertices = self.run.vertices.count();
            if given.iter().any(|group| group[..vertices].contains(&0)) {
                let problem = "a vertex of 0 turns: expected 1 or more".to_owned();
                return Err(WorkError::Rounds { index, problem });
            }
        }
        Ok(())
    }
}

/// Checks that ports of `config` never wait for one another.
pub(super) fn check_no_turns(config: &Config) -> Result<(), WorkError> {
    match config.gu.extra_ports {
        ExtraPorts::Copies => Ok(()),
        ExtraPorts::Split => Err(WorkError::Turns),
    }
}

/// Turns of a run, in the order of issue.
#[derive(Debug, Clone)]
pub(super) struct Turns {
    turns: Vec<Vec<Rounds>>,
    segments: u32,
    mvoxel: usize,
    segment: u32,
    group: usize,
    /// Turns done of the current vertex.
    over: u16,
}

impl Turns {
    pub(super) fn new(work: &SplitRun<'_>) -> Self {
        Self {
            turns: work.turns.to_vec(),
            segments: work.run.segments,
            mvoxel: 0,
            segment: 0,
            group: 0,
            over: 0,
        }
    }

    /// One turn of a vertex, in the last group or not. Returns whether it was the vertex's last.
    pub(super) fn turn(&mut self, vertex: u32, last: bool) -> bool {
        let Some(groups) = self.turns.get(self.mvoxel) else {
            return true;
        };
        self.over += 1;
        if self.over < groups[self.group][vertex as usize] {
            return false;
        }
        self.over = 0;
        if last {
            self.group += 1;
            if self.group == groups.len() {
                self.group = 0;
                self.segment += 1;
            }
            if self.segment == self.segments {
                self.segment = 0;
                self.mvoxel += 1;
            }
        }
        true
    }
}
