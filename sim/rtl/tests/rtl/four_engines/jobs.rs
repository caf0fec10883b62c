//! Seeded random work of both units, and what the reference units make of it.

use potamoi_cycles::Stalls;
use potamoi_formats::config::{Config, Organisation};
use potamoi_formats::fixed::Rounding;
use potamoi_formats::units::{GATHERING_UNIT, VectorOp};
use potamoi_reference::GatherTask;
use potamoi_reference::gathering_unit::ReferenceGatheringUnit;
use potamoi_reference::vector_unit::ReferenceVectorUnit;
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64Mcg;

use crate::cells::cells;
use crate::gather_common::held_up;

/// An operation, its first and its second operands.
type Operation = (VectorOp, Vec<i32>, Vec<i32>);

pub(super) enum Work {
    Gather(Vec<GatherTask>, Vec<i16>),
    Vector(Vec<Operation>, Vec<i32>),
}

pub(super) struct Job {
    pub(super) name: String,
    pub(super) stalls: Stalls,
    /// Of the stalls.
    pub(super) seed: u64,
    pub(super) work: Work,
}

/// The jobs of a seed: streams always ready and held up, every number of vertices, one segment and
/// more, every operation.
pub(super) fn of(config: &Config, unit: &str, seed: u64) -> Vec<Job> {
    let mut random = Pcg64Mcg::seed_from_u64(seed);
    let mut jobs = vec![];
    for is_held in [false, true] {
        let held = if is_held { "held up" } else { "always ready" };
        let mut add = |random: &mut Pcg64Mcg, what: String, work| {
            let stalls = if is_held {
                held_up(random)
            } else {
                Stalls::NONE
            };
            jobs.push(Job {
                name: format!("{what}, streams {held}"),
                stalls,
                seed,
                work,
            });
        };
        if unit != GATHERING_UNIT {
            let work = operations(&mut random, config);
            add(&mut random, "every operation".to_owned(), work);
            continue;
        }
        for vertices in config.supported_vertices() {
            let a_segment = match config.organisation().0 {
                Organisation::FeatureMajor => config.gu.banks as usize,
                _ => config.lanes_a_port() as usize,
            };
            let most = config.gu.segments.min(3) as usize;
            let ranges = [1..=a_segment, a_segment + 1..=most * a_segment];
            for channels in ranges.into_iter().filter(|range| !range.is_empty()) {
                let channels = random.random_range(channels);
                // An odd number leaves a port of the last group without an entry.
                let mut sizes = [1, 3, random.random_range(2..12)];
                sizes.rotate_left(random.random_range(0..3));
                let tasks: Vec<_> = sizes
                    .iter()
                    .map(|size| cells(&mut random, config, vertices, (channels, *size)))
                    .collect();
                let twin = ReferenceGatheringUnit::new(config);
                let mut features = vec![];
                for task in &tasks {
                    assert_eq!(twin.gather(task, &mut features), Ok(0));
                }
                let v = vertices.count();
                let what = format!("V = {v}, {channels} channels, entries {sizes:?}");
                add(&mut random, what, Work::Gather(tasks, features));
            }
        }
    }
    jobs
}

/// Every operation of the unit once and a few again, on operands at the ends of their range and
/// inside.
fn operations(random: &mut Pcg64Mcg, config: &Config) -> Work {
    let ops = &config.vu.ops;
    let again = (0..ops.len() / 2).map(|_| ops[random.random_range(0..ops.len())]);
    let codes: Vec<_> = ops.iter().copied().chain(again).collect();
    let twin = ReferenceVectorUnit::new(&config.vu);
    let (mut work, mut results) = (vec![], vec![]);
    for code in codes {
        let op = VectorOp {
            code,
            shift: random.random_range(0..64),
            rounding: [Rounding::Floor, Rounding::HalfUp, Rounding::HalfEven]
                [random.random_range(0..3)],
        };
        // The last vector has empty lanes more often than not.
        let count = random.random_range(1..=2 * config.vu.lanes as usize + 1);
        let mut operands = || -> Vec<i32> {
            (0..count)
                .map(|_| match random.random_range(0..8) {
                    0 => i32::MIN,
                    1 => i32::MAX,
                    2 => 0,
                    _ => random.random::<i32>() >> random.random_range(0..31),
                })
                .collect()
        };
        let (a, b) = (operands(), operands());
        let from = results.len();
        results.resize(from + count, 0);
        twin.slice(op, &a, &b, &mut results[from..]).unwrap();
        work.push((op, a, b));
    }
    Work::Vector(work, results)
}
