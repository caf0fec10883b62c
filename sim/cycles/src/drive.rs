//! Runs the stepwise models under a stimulus plan.

use std::collections::VecDeque;

use potamoi_formats::config::Config;

use super::gathering_unit::{Cause, Counters, GatherInputs, GatherModel, GatherOutputs};
use super::split_banks::SplitRun;
use super::stimulus::{Plan, Source, Stalls};
use super::work::{GatherRun, WorkError};

/// Cycles without progress, all streams willing, that count as a deadlock; the unit's own registers
/// are fewer than ten.
const PATIENCE: u32 = 64;

/// Timestamps of one group.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct GroupLog {
    /// Cycle in which vertex 0 was issued.
    pub issued: u64,
    /// Cycle in which the sink accepted its features.
    pub accepted: u64,
    /// Entries in it.
    pub kept: u32,
    /// The last of its MVoxel and segment.
    pub last: bool,
}

/// Log of a run. Cycle 0 is the plan's first.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct CycleLog {
    /// Cycles until the sink has accepted everything.
    pub cycles: u64,
    /// Cycle of the first accepted RIT beat.
    pub first_beat: Option<u64>,
    /// Cycle of the first issue, or of the first turn at the table.
    pub first_issue: Option<u64>,
    /// Cycle of the last issue.
    pub last_issue: Option<u64>,
    /// Final counters.
    pub counters: Counters,
    /// Accepted RIT beats.
    pub rit_beats: u64,
    /// Accepted MFT rows.
    pub mft_rows: u64,
    /// Groups, in the order of the feature stream.
    pub groups: Vec<GroupLog>,
}

/// Runs the stepwise model under the stalls of a seed.
///
/// # Errors
/// Work that the unit cannot do, stalls without end, or a deadlock.
pub fn run_gather(
    config: &Config,
    run: &GatherRun<'_>,
    stalls: &Stalls,
    seed: u64,
) -> Result<CycleLog, WorkError> {
    run_gather_watched(config, run, Plan::new(seed, stalls)?, |_, _, _| {})
}

/// As [`run_gather`], with an observer of every cycle's inputs and outputs.
///
/// # Errors
/// As [`run_gather`].
pub fn run_gather_watched(
    config: &Config,
    run: &GatherRun<'_>,
    plan: Plan,
    watch: impl FnMut(u64, &GatherInputs, &GatherOutputs),
) -> Result<CycleLog, WorkError> {
    run.check(config)?;
    let model = GatherModel::new(config, run.vertices, run.segments)?;
    play(config, run, model, plan, watch)
}

/// As [`run_gather`], for a unit whose ports take turns.
///
/// # Errors
/// As [`run_gather`].
pub fn run_split(
    config: &Config,
    work: &SplitRun<'_>,
    stalls: &Stalls,
    seed: u64,
) -> Result<CycleLog, WorkError> {
    let model = GatherModel::of_turns(config, work)?;
    let plan = Plan::new(seed, stalls)?;
    play(config, &work.run, model, plan, |_, _, _| {})
}

fn play(
    config: &Config,
    run: &GatherRun<'_>,
    mut model: GatherModel,
    mut plan: Plan,
    mut watch: impl FnMut(u64, &GatherInputs, &GatherOutputs),
) -> Result<CycleLog, WorkError> {
    let mut rit = Source::new(run.rit_beats(config));
    let mut mft = Source::new(run.mft_beats());
    let mut log = CycleLog::default();
    let mut issued = VecDeque::new();
    let mut idle = 0;
    for cycle in 0.. {
        if rit.is_done() && mft.is_done() && model.is_idle() {
            break;
        }
        let willing = plan.step();
        let inputs = GatherInputs {
            rit: rit.offer(willing.rit).map(|piece| piece.beat),
            mft: mft.offer(willing.mft).map(|piece| piece.last),
            feat_ready: willing.sink,
        };
        let outputs = model.step(&inputs);
        watch(cycle, &inputs, &outputs);
        log.cycles = cycle + 1;

        let turn = outputs.stall == Some(Cause::Turn);
        let mut moves = outputs.issue.is_some() || turn;
        if moves {
            log.first_issue.get_or_insert(cycle);
        }
        if inputs.rit.is_some() && outputs.rit_ready {
            rit.accepted();
            log.first_beat.get_or_insert(cycle);
            log.rit_beats += 1;
            moves = true;
        }
        if inputs.mft.is_some() && outputs.mft_ready {
            mft.accepted();
            log.mft_rows += 1;
            moves = true;
        }
        if let Some(issue) = outputs.issue {
            log.last_issue = Some(cycle);
            if issue.vertex == 0 {
                issued.push_back(cycle);
            }
        }
        if let Some(feature) = outputs.feat.filter(|_| inputs.feat_ready) {
            if let Some(issued) = issued.pop_front() {
                log.groups.push(GroupLog {
                    issued,
                    accepted: cycle,
                    kept: feature.kept,
                    last: feature.last,
                });
            }
            moves = true;
        }

        let all_willing = (inputs.rit.is_some() || rit.is_done())
            && (inputs.mft.is_some() || mft.is_done())
            && inputs.feat_ready;
        idle = if moves {
            0
        } else {
            idle + u32::from(all_willing)
        };
        if idle > PATIENCE {
            return Err(WorkError::Deadlock { cycle });
        }
    }
    log.counters = model.counters();
    Ok(log)
}
