//! What is sent: tasks of a configuration as beats, with beats without bytes between
//! and behind them, or with one thing that is wrong.

use potamoi_formats::config::{Config, Organisation};
use potamoi_formats::rit::Vertices;
use potamoi_reference::GatherTask;
use potamoi_reference::gathering_unit::ReferenceGatheringUnit;
use potamoi_rtl::{FeatureBeat, GatherBeats, InputBeat, feature_beats};
use rand::Rng;
use rand_pcg::Pcg64Mcg;

use crate::cells::cells;

/// Beats in, and beats that must come back.
pub(crate) struct Traffic {
    pub(crate) tasks: Vec<GatherTask>,
    pub(crate) vertices: Vertices,
    pub(crate) segments: u32,
    pub(crate) settings: Vec<(&'static str, u64)>,
    pub(crate) slot_bits: u32,
    pub(crate) rit: Vec<InputBeat>,
    pub(crate) mft: Vec<InputBeat>,
    pub(crate) wanted: Vec<FeatureBeat>,
}

/// Entries of an MVoxel: few; a whole number of beats and groups, so that it can end
/// null; or about as many as halves of the buffer hold, where these are small.
fn entries(random: &mut Pcg64Mcg, config: &Config, vertices: Vertices) -> usize {
    let half = config.rit_entries(vertices) as usize;
    match random.random_range(0..4) {
        0 => random.random_range(1..=12),
        1 if half <= 64 => half * random.random_range(1..=3),
        2 if half <= 64 => half + random.random_range(1..=half),
        _ => 4 * config.gu.ports as usize * random.random_range(1..=2),
    }
}

impl Traffic {
    /// Right work without beats that have no bytes.
    pub(crate) fn plain(random: &mut Pcg64Mcg, config: &Config) -> Self {
        let built = config.supported_vertices();
        let vertices = built[random.random_range(0..built.len())];
        let a_segment = config.lanes_a_port() as usize;
        let a_segment = match config.organisation().0 {
            Organisation::FeatureMajor => config.gu.banks as usize,
            _ => a_segment,
        };
        let most = config.gu.segments.min(2) as usize * a_segment;
        let channels = random.random_range(1..=most);
        let count = random.random_range(2..=4);
        let tasks: Vec<_> = (0..count)
            .map(|_| {
                let entries = entries(random, config, vertices);
                cells(random, config, vertices, (channels, entries))
            })
            .collect();
        let beats = GatherBeats::of(config, &tasks).unwrap();
        let mut traffic = Self {
            vertices,
            segments: config.segments(channels).max(1) as u32,
            settings: beats.settings,
            slot_bits: beats.slot_bits,
            rit: beats.rit.concat(),
            mft: beats.mft.concat(),
            tasks,
            wanted: vec![],
        };
        traffic.expect(config, &|_, _| false);
        traffic
    }

    fn expect(&mut self, config: &Config, null: &dyn Fn(usize, usize) -> bool) {
        let twin = ReferenceGatheringUnit::new(config);
        let mut features = vec![];
        for task in &self.tasks {
            assert_eq!(twin.gather(task, &mut features), Ok(0));
        }
        self.wanted = feature_beats(config, &self.tasks, &features, null).unwrap();
    }

    /// The same work, with beats without bytes wherever they may be.
    pub(crate) fn with_bare_beats(random: &mut Pcg64Mcg, config: &Config) -> Self {
        let mut traffic = Self::plain(random, config);
        let both = 2
            * config.rit_entries(traffic.vertices) as usize
            * config.entry_bytes(traffic.vertices);
        let packets = traffic.rit.split_inclusive(|beat| beat.last);
        let mut ends = vec![];
        let mut rit = vec![];
        for packet in packets {
            let mut packet = packet.to_vec();
            let end = packet.last().unwrap();
            let bytes = config.rit_stream_bits() / 8;
            // Two halves that are to be kept leave no room for an end by itself.
            let fills = traffic.segments > 1 && !end.user && packet.len() * bytes as usize == both;
            let end = packet.last_mut().unwrap();
            let null = is_full(&end.keep, bytes) && !fills && random.random_range(0..3) > 0;
            if null {
                end.last = false;
                let user = end.user;
                let end = InputBeat {
                    last: true,
                    user,
                    ..nothing(end)
                };
                packet.push(end);
            }
            ends.push(null);
            rit.extend(sprinkle(random, packet));
        }
        traffic.rit = rit;
        if config.organisation().0 == Organisation::FeatureMajor {
            let packets = traffic.mft.split_inclusive(|beat| beat.last);
            let mut mft = vec![];
            for packet in packets {
                let mut packet = packet.to_vec();
                if random.random() {
                    let end = packet.last_mut().unwrap();
                    end.last = false;
                    let end = InputBeat {
                        last: true,
                        ..nothing(end)
                    };
                    packet.push(end);
                }
                mft.extend(sprinkle(random, packet));
            }
            traffic.mft = mft;
        }
        // Of an MVoxel that is kept one packet serves all segments.
        let segments = traffic.segments as usize;
        let half = config.rit_entries(traffic.vertices) as usize;
        let mut of = vec![];
        let mut next = 0;
        for task in &traffic.tasks {
            let streamed = task.entries.len() > 2 * half;
            of.push(
                (0..segments)
                    .map(|s| ends[next + s * usize::from(streamed)])
                    .collect::<Vec<_>>(),
            );
            next += if streamed { segments } else { 1 };
        }
        assert_eq!(next, ends.len());
        traffic.expect(config, &|task, segment| of[task][segment]);
        traffic
    }
}

pub(crate) fn is_full(keep: &[u32], bits: u32) -> bool {
    keep.iter().map(|w| w.count_ones()).sum::<u32>() == bits
}

/// A beat without bytes, whatever its data says.
fn nothing(like: &InputBeat) -> InputBeat {
    InputBeat {
        data: like.data.iter().map(|w| !w).collect(),
        keep: vec![0; like.keep.len()],
        last: false,
        user: false,
    }
}

/// Beats without bytes before any beat.
fn sprinkle(random: &mut Pcg64Mcg, packet: Vec<InputBeat>) -> Vec<InputBeat> {
    let often = random.random_range(0..3);
    let mut beats = vec![];
    for beat in packet {
        while random.random_range(0..10) < often {
            let user = random.random();
            beats.push(InputBeat {
                user,
                ..nothing(&beat)
            });
        }
        beats.push(beat);
    }
    beats
}

/// One thing that is wrong with a beat.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Wrong {
    /// A byte that is not there.
    Hole,
    /// Any bits at all.
    Keep,
    /// `tlast` too early.
    Early,
    /// `tlast` too late.
    Late,
    /// Another `tuser` than the beats before.
    User,
    /// An MVoxel without entries.
    Empty,
    /// Halfwords missing from the end.
    Short,
    /// Beats of anything.
    Noise,
    /// More rows than the table holds.
    Rows,
}

pub(crate) const WRONGS: [Wrong; 9] = [
    Wrong::Hole,
    Wrong::Keep,
    Wrong::Early,
    Wrong::Late,
    Wrong::User,
    Wrong::Empty,
    Wrong::Short,
    Wrong::Noise,
    Wrong::Rows,
];

fn flip(keep: &mut [u32], bit: u32) {
    keep[bit as usize / 32] ^= 1 << (bit % 32);
}

/// Does one wrong thing to a stream, somewhere.
pub(crate) fn spoil(random: &mut Pcg64Mcg, beats: &mut Vec<InputBeat>, wrong: Wrong, bytes: u32) {
    let at = random.random_range(0..beats.len());
    let has_keep = !beats[at].keep.is_empty();
    match wrong {
        Wrong::Hole if has_keep => flip(&mut beats[at].keep, random.random_range(0..bytes)),
        Wrong::Keep if has_keep => {
            for bit in 0..bytes {
                if random.random() {
                    flip(&mut beats[at].keep, bit);
                }
            }
        }
        Wrong::Early => beats[at].last = true,
        Wrong::Late => {
            let after = beats.iter().skip(at).position(|b| b.last).unwrap_or(0);
            beats[at + after].last = false;
        }
        Wrong::User => beats[at].user ^= true,
        Wrong::Empty => {
            let place = beats
                .iter()
                .take(at)
                .rposition(|b| b.last)
                .map_or(0, |p| p + 1);
            let empty = InputBeat {
                last: true,
                ..nothing(&beats[at])
            };
            beats.insert(place, empty);
        }
        Wrong::Short if has_keep => {
            let drop = random.random_range(1..bytes);
            (bytes - drop..bytes).for_each(|bit| {
                beats[at].keep[bit as usize / 32] &= !(1 << (bit % 32));
            });
        }
        Wrong::Rows => {
            let end = beats.iter().skip(at).position(|b| b.last).unwrap_or(0);
            let more = InputBeat {
                last: false,
                ..beats[at].clone()
            };
            beats.splice(at + end..at + end, vec![more; random.random_range(1..600)]);
        }
        _ => {
            for beat in beats.iter_mut().skip(at).take(random.random_range(1..5)) {
                beat.data.iter_mut().for_each(|w| *w = random.random());
                for bit in 0..if has_keep { bytes } else { 0 } {
                    if random.random() {
                        flip(&mut beat.keep, bit);
                    }
                }
                beat.last = random.random();
                beat.user = random.random();
            }
        }
    }
}
