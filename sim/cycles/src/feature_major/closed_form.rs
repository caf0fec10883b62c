//! Closed-form cycles of the feature-major organisation, R entries at a time, with sources and sink
//! always ready.

use potamoi_formats::config::Config;

use super::{LaneRun, Rounds, latency};
use crate::closed_form::{Chain, GatherCycles, Halves, Part};
use crate::work::WorkError;

/// Times at which lanes are filled, gathered and free again.
#[derive(Default)]
struct Lanes {
    vertices: usize,
    /// First cycle in which each half may be filled.
    free: [u64; 2],
    /// The half to fill next.
    half: usize,
    /// Cycle of the last round.
    done: Option<u64>,
    out: GatherCycles,
}

impl Lanes {
    /// Gathers channels of R entries that were filled before cycle `filled`, from an MVoxel loaded
    /// by cycle `loaded`.
    fn gather(&mut self, rounds: &Rounds, channels: u64, filled: u64, loaded: u64) {
        let v = self.vertices;
        let read = self.done.map_or(filled, |done| filled.max(done));
        let first = (read + 1).max(loaded);
        match self.done {
            None => self.out.fill = first,
            Some(done) => {
                let next = done + 1;
                let mft = loaded.clamp(next, first) - next;
                self.out.stall_mft += mft;
                self.out.stall_rit += first - next - mft;
            }
        }
        let sum: u64 = rounds[..v].iter().map(|&r| u64::from(r)).sum();
        let (steps, cycles) = (channels * v as u64, channels * sum);
        self.out.busy += steps;
        self.out.stall_bank += cycles - steps;
        let done = first + cycles - 1;
        // The last step is read with the last round of the one before it.
        let last_read = if steps == 1 {
            read
        } else {
            done - u64::from(rounds[v - 1])
        };
        self.free[self.half] = last_read + 1;
        self.half ^= 1;
        self.done = Some(done);
    }
}

/// Exact cycles of a run of the feature-major unit with sources and sink always ready.
///
/// Takes time in proportion to the entries.
///
/// # Errors
/// Work that the unit cannot do.
pub fn feature_major_cycles(
    config: &Config,
    work: &LaneRun<'_>,
) -> Result<GatherCycles, WorkError> {
    work.check(config)?;
    let run = &work.run;
    let ports = u64::from(config.gu.ports);
    let side = u64::from(config.gu.lanes) / ports;
    let half = u64::from(config.rit_entries(run.vertices));
    let mut chain = Chain::new(config, run.vertices);
    let (mut rit, mut mft) = (Halves::default(), Halves::default());
    let mut lanes = Lanes {
        vertices: run.vertices.count(),
        ..Lanes::default()
    };
    for (mvoxel, rounds) in run.mvoxels.iter().zip(work.rounds) {
        let again = run.streamed_again(config, *mvoxel);
        let parts = u64::from(mvoxel.entries).div_ceil(half);
        let mut kept: [Option<Part>; 2] = [None; 2];
        for segment in 0..run.segments {
            let channels = work.channels(config, segment);
            let beats = work.mft_beats(config, mvoxel.rows, segment);
            let mut loaded = mft.write(beats) + beats;
            let mut next = rounds.iter();
            let mut in_lanes = 0;
            for index in 0..parts {
                let slot = (index & 1) as usize;
                let part = match kept[slot].filter(|_| !again) {
                    Some(part) => part,
                    None => {
                        let entries = (u64::from(mvoxel.entries) - index * half).min(half);
                        chain.write(&mut rit, entries, ports)
                    }
                };
                if run.segments > 1 && !again {
                    kept[slot] = Some(part);
                }
                for group in 0..part.groups {
                    let free = if in_lanes == 0 {
                        lanes.free[lanes.half]
                    } else {
                        0
                    };
                    chain.group(chain.readable(&part, group), free);
                    in_lanes += 1;
                    let over = index + 1 == parts && group + 1 == part.groups;
                    if in_lanes == side || over {
                        let filled = chain.last_issue() + 1;
                        if let Some(rounds) = next.next() {
                            let loaded = std::mem::take(&mut loaded);
                            lanes.gather(rounds, channels, filled, loaded);
                        }
                        in_lanes = 0;
                    }
                }
                if again || segment + 1 == run.segments {
                    rit.release(chain.read + 1);
                }
            }
            mft.release(lanes.done.map_or(0, |done| done + 1));
        }
    }
    lanes.out.elapsed = lanes.done.map_or(0, |done| done + latency() + 1);
    Ok(lanes.out)
}
