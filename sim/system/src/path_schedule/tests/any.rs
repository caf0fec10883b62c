//! Properties of random plans with random times.

use potamoi_warp::{Counts, Plan, ReferenceFrom};
use proptest::prelude::*;

use super::super::*;
use super::{FixedClock, plan};

/// Times that differ by task.
#[derive(Debug, Clone)]
struct TableClock {
    times: Vec<[Nanos; 4]>,
}

impl TableClock {
    fn of(&self, number: usize) -> [Nanos; 4] {
        self.times[number % self.times.len()]
    }
}

impl Clock for TableClock {
    fn reference(&self, reference: usize) -> Nanos {
        self.of(reference)[0]
    }

    fn served(&self, reference: usize) -> Nanos {
        self.of(reference)[1]
    }

    fn target(&self, frame: usize, _: &Counts) -> Nanos {
        self.of(frame)[2]
    }

    fn full(&self, frame: usize) -> Nanos {
        self.of(frame)[3]
    }
}

#[derive(Clone)]
struct Case {
    /// Frames, window, origin of references, lead.
    asked: (usize, u32, ReferenceFrom, Option<u32>),
    plan: Plan,
    counts: Vec<Counts>,
    clock: TableClock,
    options: Options,
    remote: Option<Remote>,
}

/// Without cameras, so that failures stay readable.
impl std::fmt::Debug for Case {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let full: Vec<u64> = self.counts.iter().map(|c| c.full).collect();
        let Self {
            asked,
            clock,
            options,
            remote,
            ..
        } = self;
        write!(f, "{asked:?} {full:?} {clock:?} {options:?} {remote:?}")
    }
}

impl Case {
    fn run(&self) -> Schedule {
        schedule(
            &self.plan,
            &self.counts,
            &self.clock,
            &self.options,
            self.remote.as_ref(),
        )
        .unwrap()
    }
}

fn any_remote() -> impl Strategy<Value = Option<Remote>> {
    let remote = (
        (1u64..4, 0u64..30, 0u64..3, 0u64..60),
        (0u64..400, prop::collection::btree_set(0usize..8, 0..4)),
    );
    let remote = remote.prop_map(|((speed, latency, request_bytes, reference_bytes), rest)| {
        let link = Link {
            bytes_per_second: speed * 500_000_000,
            latency,
            nanojoules_per_byte: 100,
        };
        let (timeout, lost) = rest;
        Remote {
            link,
            request_bytes,
            reference_bytes,
            timeout,
            lost,
        }
    });
    prop::option::of(remote)
}

fn any_case() -> impl Strategy<Value = Case> {
    let poses = prop_oneof![
        Just(Poses::AtOnce),
        Just(Poses::OnShown),
        (1u32..200).prop_map(|n| Poses::Rate {
            frames: n * 1_000_000,
            seconds: 1
        }),
    ];
    let from = prop_oneof![
        4 => Just(ReferenceFrom::Predicted),
        1 => Just(ReferenceFrom::First),
        1 => Just(ReferenceFrom::Centre),
    ];
    let time = || prop_oneof![1 => Just(0u64), 6 => 1u64..100];
    let times = prop::collection::vec([time(), time(), time(), time()], 1..12);
    let refused = prop::collection::vec(prop::bool::weighted(0.15), 1..20);
    (
        (0usize..30, 1u32..9, from, prop::option::of(0u32..40)),
        (poses, any::<bool>(), 1usize..4),
        (times, refused, any_remote()),
    )
        .prop_map(
            |(path, (poses, concurrent, slots), (times, refused, remote))| {
                let (frames, window, from, lead) = path;
                let from = match (from, poses) {
                    (ReferenceFrom::Centre, Poses::OnShown) => ReferenceFrom::First,
                    _ => from,
                };
                let counts = (0..frames).map(|k| Counts {
                    full: u64::from(refused[k % refused.len()]),
                    ..Counts::default()
                });
                Case {
                    asked: (frames, window, from, lead),
                    plan: plan(frames, window, from, lead),
                    counts: counts.collect(),
                    clock: TableClock { times },
                    options: Options {
                        poses,
                        concurrent,
                        slots,
                    },
                    remote,
                }
            },
        )
}

#[test]
fn a_faster_sparse_renderer_can_be_the_later_where_angles_are_too_large() {
    let plan = plan(4, 3, ReferenceFrom::Predicted, None);
    let mut counts = vec![Counts::default(); 4];
    counts[1].full = 1;
    let poses = Poses::Rate {
        frames: 50_000_000,
        seconds: 1,
    };
    let shown = |target| {
        let clock = FixedClock {
            reference: 50,
            served: 0,
            target,
            full: 20,
        };
        let options = Options::new(poses);
        schedule(&plan, &counts, &clock, &options, None)
            .unwrap()
            .totals
            .shown
    };
    // The full renderer gets frame 1 as it gets reference 1, and has it first.
    assert_eq!([shown(20), shown(10)], [130, 140]);
}

#[test]
fn a_faster_server_can_be_the_later_as_the_link_carries_both_ways() {
    let plan = plan(5, 4, ReferenceFrom::Predicted, None);
    let poses = Poses::Rate {
        frames: 98_000_000,
        seconds: 1,
    };
    let remote = Remote {
        link: Link {
            bytes_per_second: 500_000_000,
            latency: 26,
            nanojoules_per_byte: 0,
        },
        request_bytes: 0,
        reference_bytes: 4,
        timeout: 1000,
        lost: [].into(),
    };
    let shown = |served: [Nanos; 2]| {
        let clock = TableClock {
            times: served.map(|t| [0, t, 0, 0]).to_vec(),
        };
        let options = Options::new(poses);
        let schedule = schedule(
            &plan,
            &[Counts::default(); 5],
            &clock,
            &options,
            Some(&remote),
        );
        schedule.unwrap().totals.shown
    };
    // The answer has the link as the second request comes, and keeps it.
    assert_eq!([shown([15, 0]), shown([7, 0])], [100, 101]);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(1500))]

    #[test]
    fn dependencies_hold(case in any_case()) {
        let s = case.run();
        // Where the reference was brought to the buffer, and when.
        let brought = |r: usize| {
            let brings = if case.remote.is_some() { Job::Answer(r) } else { Job::Reference(r) };
            s.tasks.iter().find(|t| t.job == brings).map(|t| t.end)
        };
        let latency = case.remote.as_ref().map_or(0, |r| r.link.latency);
        for task in &s.tasks {
            prop_assert_eq!(task.asked + task.waits.total(), task.start);
            match task.job {
                Job::Target(frame) => {
                    let r = s.frames[frame].reference;
                    prop_assert!(task.start >= brought(r).unwrap() + latency);
                    prop_assert!(task.start >= s.frames[frame].pose);
                }
                Job::Fallback(frame) => prop_assert!(task.start >= s.frames[frame].pose),
                Job::Request(r) | Job::Reference(r) | Job::Answer(r) => {
                    let known = case.plan.references[r].known;
                    prop_assert!(task.start >= s.frames[known].pose);
                }
            }
        }
        for frame in &s.frames {
            let last = s.tasks.iter().rfind(|t| {
                t.job == Job::Target(frame.number) || t.job == Job::Fallback(frame.number)
            });
            let expected = match last {
                Some(task) => task.end,
                None => brought(frame.reference).unwrap() + latency,
            };
            prop_assert_eq!(frame.finished, expected);
            let started = frame.pose + frame.waits.total();
            prop_assert_eq!(started, last.map_or(frame.finished, |t| t.start));
            let lost = case.remote.as_ref().is_some_and(|r| r.lost.contains(&frame.reference));
            prop_assert!(!lost || frame.made == FrameOrigin::FullByLoss);
            let refused = frame.made == FrameOrigin::FullByAngle;
            prop_assert!(!refused || case.counts[frame.number].full > 0);
        }
        for pair in s.frames.windows(2) {
            prop_assert!(pair[0].shown <= pair[1].shown);
            prop_assert_eq!(pair[1].shown, pair[1].finished.max(pair[0].shown));
        }
    }

    #[test]
    fn a_resource_does_one_thing_at_a_time_and_all_its_time_is_told(case in any_case()) {
        let s = case.run();
        for used in &s.resources {
            let tasks: Vec<_> = s.tasks.iter().filter(|t| t.resource == used.resource).collect();
            let mut free = 0;
            for task in &tasks {
                prop_assert!(task.start >= free && task.end >= task.start);
                prop_assert_eq!(free + task.idle.total(), task.start);
                // Idle beside something that could be begun: never.
                prop_assert_eq!(task.idle.renderer, 0);
                free = task.end;
            }
            let busy: Nanos = tasks.iter().map(|t| t.end - t.start).sum();
            prop_assert_eq!(used.busy, busy);
            prop_assert_eq!(used.busy + used.idle.total() + used.after, s.totals.span);
        }
        let overlap: Nanos = (0..s.totals.span)
            .filter(|now| {
                let at = |of: fn(Job) -> bool| {
                    s.tasks.iter().any(|t| of(t.job) && t.start <= *now && *now < t.end)
                };
                at(|j| matches!(j, Job::Reference(_)))
                    && at(|j| matches!(j, Job::Target(_) | Job::Fallback(_)))
            })
            .count() as Nanos;
        prop_assert_eq!(s.totals.overlap, overlap);
    }

    #[test]
    fn a_slot_is_not_written_while_it_is_needed(case in any_case()) {
        let s = case.run();
        prop_assert_eq!(s.held.len(), case.plan.references.len());
        for (n, held) in s.held.iter().enumerate() {
            prop_assert!(held.slot < case.options.slots && held.from <= held.until);
            for other in &s.held[..n] {
                prop_assert!(other.slot != held.slot || other.until <= held.from);
            }
            for task in &s.tasks {
                let within = held.from <= task.start && task.end <= held.until;
                match task.job {
                    Job::Target(frame) if s.frames[frame].reference == held.reference => {
                        prop_assert!(within);
                    }
                    Job::Reference(r) if r == held.reference => {
                        prop_assert_eq!(task.slot, Some(held.slot));
                        let late = s.frames.iter().any(|f| {
                            f.reference == r && f.made == FrameOrigin::FullByLoss
                        });
                        prop_assert!(within || late);
                    }
                    _ => {}
                }
            }
        }
    }

    #[test]
    fn the_same_is_scheduled_the_same(case in any_case()) {
        let again = case.clone();
        prop_assert_eq!(case.run(), again.run());
    }

    /// Holds only for these cases, see [`schedule`]: one renderer does the same work in any order,
    /// and two renderers without a choice have one order.
    #[test]
    fn a_faster_resource_is_never_the_later(case in any_case(), which in 0usize..4) {
        let mut slow = Case { remote: None, ..case };
        if slow.options.concurrent {
            slow.counts.fill(Counts::default());
        }
        let mut fast = slow.clone();
        for times in &mut fast.clock.times {
            times[which] /= 2;
        }
        let shown = [fast.run().totals.shown, slow.run().totals.shown];
        prop_assert!(shown[0] <= shown[1], "{:?}", shown);
    }

    #[test]
    fn fixed_times_are_those_of_a_table(case in any_case()) {
        let [reference, served, target, full] = case.clock.of(0);
        let clock = FixedClock { reference, served, target, full };
        let table = Case { clock: TableClock { times: vec![case.clock.of(0)] }, ..case.clone() };
        let s = schedule(&case.plan, &case.counts, &clock, &case.options, case.remote.as_ref());
        prop_assert_eq!(s.unwrap(), table.run());
    }
}
