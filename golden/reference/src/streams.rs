//! Functional model of the gathering unit's stream protocol, without timing: which bytes belong to
//! an MVoxel, where it ends, how its features are framed, and which flags malformed beats raise
//! (`docs/reference/gathering-unit.md`, Streams and Errors).

use potamoi_formats::config::Config;
use potamoi_formats::rit::{MAX_VERTICES, Vertices, WORD_BYTES};

/// Error flag: an MVoxel's bytes are not a whole number of entries, or there are none.
pub(crate) const FLAG_RAGGED: u8 = 1 << 3;
/// Error flag: bytes or `tuser` of a beat break the protocol.
pub(crate) const FLAG_BEAT: u8 = 1 << 4;
/// Error flag: an MVoxel that must be kept for several segments exceeds both halves of the buffer.
pub(crate) const FLAG_LARGE: u8 = 1 << 5;

/// A beat of the RIT stream.
#[derive(Debug, Clone, Copy)]
pub struct RitBeat<'a> {
    /// The bytes of `tdata`, byte 0 first.
    pub bytes: &'a [u8],
    /// `tkeep`, one flag a byte.
    pub keep: &'a [bool],
    /// `tlast`.
    pub last: bool,
    /// `tuser`.
    pub user: bool,
}

/// The entries of an MVoxel for one segment.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Packet {
    /// Packed entries.
    pub bytes: Vec<u8>,
    /// Whether they were streamed once for every segment.
    pub streamed: bool,
    /// Whether the last beat has no bytes.
    pub ends_null: bool,
}

/// The state of the RIT stream since reset.
#[derive(Debug, Clone)]
pub struct RitStream {
    entry_bytes: usize,
    /// Bytes of both halves.
    buffer_bytes: usize,
    segments: u32,
    begun: Option<Packet>,
}

impl RitStream {
    /// The stream of a unit that `config` describes.
    #[must_use]
    pub fn new(config: &Config, vertices: Vertices, segments: u32) -> Self {
        let half = config.rit.entries as usize * MAX_VERTICES * WORD_BYTES;
        Self {
            entry_bytes: config.entry_bytes(vertices),
            buffer_bytes: 2 * half,
            segments,
            begun: None,
        }
    }

    /// Accepts a beat. Returns the error flags that it raises and, with the last beat, the
    /// MVoxel's packet. After a flag the state is undefined until reset.
    pub fn take(&mut self, beat: &RitBeat<'_>) -> (u8, Option<Packet>) {
        let kept = beat.keep.iter().take_while(|k| **k).count();
        let null = beat.keep.iter().all(|k| !k);
        if null && !beat.last {
            return (0, None);
        }
        let mut flags = 0;
        let is_right = kept % 2 == 0
            && beat.keep[kept..].iter().all(|k| !k)
            && (beat.last || kept == beat.keep.len());
        let begun = self.begun.get_or_insert_with(|| Packet {
            streamed: beat.user,
            ..Packet::default()
        });
        if !is_right || begun.streamed != beat.user {
            flags |= FLAG_BEAT;
        }
        begun.bytes.extend(&beat.bytes[..kept]);
        if !beat.last {
            let is_kept = self.segments > 1 && !begun.streamed;
            if is_kept && begun.bytes.len() >= self.buffer_bytes {
                flags |= FLAG_LARGE;
            }
            return (flags, None);
        }
        let mut packet = self.begun.take().unwrap_or_default();
        packet.ends_null = null;
        if packet.bytes.is_empty() || !packet.bytes.len().is_multiple_of(self.entry_bytes) {
            flags |= FLAG_RAGGED;
        }
        (flags, Some(packet))
    }
}

/// The entries in one beat of the feature stream.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FeatureFrame {
    /// Number of the first entry.
    pub first: usize,
    /// Number of entries.
    pub kept: usize,
    /// Whether the beat is the last of its MVoxel and segment.
    pub last: bool,
}

/// The feature beats of `entries` entries, `side` of them a beat. A last beat without bytes behind
/// a whole number of beats ends them with a beat that holds no entry, since the entries before it
/// may have been sent by then.
#[must_use]
pub fn frames(entries: usize, side: usize, ends_null: bool) -> Vec<FeatureFrame> {
    let firsts = (0..entries).step_by(side.max(1));
    let mut frames: Vec<_> = firsts
        .map(|first| FeatureFrame {
            first,
            kept: side.min(entries - first),
            last: false,
        })
        .collect();
    if ends_null && entries.is_multiple_of(side.max(1)) {
        frames.push(FeatureFrame {
            first: entries,
            kept: 0,
            last: false,
        });
    }
    if let Some(frame) = frames.last_mut() {
        frame.last = true;
    }
    frames
}

/// Checks the feature-major MFT stream, in which each channel of a block has B rows.
#[derive(Debug, Clone, Default)]
pub struct BlockStream {
    /// Rows received of each channel of the current block.
    channels: Vec<usize>,
    /// Whether a block of fewer than B rows is complete.
    partial: bool,
    blocks: u32,
}

impl BlockStream {
    /// Accepts a beat. `keep` has a bit a byte; the segment has `channels` channels and the MVoxel
    /// at most `most` blocks. Returns whether the beat raises flag 6.
    pub fn take(&mut self, keep: &[bool], last: bool, channels: usize, most: u32) -> bool {
        let kept = keep.iter().take_while(|k| **k).count();
        let null = keep.iter().all(|k| !k);
        if null && !last {
            return false;
        }
        if null {
            let amid = !self.channels.is_empty();
            *self = Self::default();
            return amid;
        }
        let mut wrong = kept % 2 != 0
            || keep[kept..].iter().any(|k| *k)
            || self.channels.first().is_some_and(|first| *first != kept)
            || self.channels.is_empty() && (self.partial || self.blocks >= most);
        self.channels.push(kept);
        if self.channels.len() >= channels {
            self.channels.clear();
            self.blocks += 1;
            self.partial = kept < keep.len();
        }
        if last {
            wrong |= !self.channels.is_empty();
            *self = Self::default();
        }
        wrong
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    /// Single ids of 4 bytes in beats of 8, halves of 96 bytes.
    fn stream(segments: u32) -> RitStream {
        let text = "[gu]\nbanks = 1\nports = 1\n[rit]\nentries = 2\nstream_bits = 64\n";
        let config = Config::from_toml(text, "test").unwrap();
        RitStream::new(&config, Vertices::One, segments)
    }

    fn take(stream: &mut RitStream, keep: u8, last: bool, user: bool) -> (u8, Option<Packet>) {
        let keep: [bool; 8] = std::array::from_fn(|i| keep >> i & 1 == 1);
        let bytes = [7; 8];
        stream.take(&RitBeat {
            bytes: &bytes,
            keep: &keep,
            last,
            user,
        })
    }

    #[test]
    fn bare_beats_mark_an_end_and_nothing_else() {
        let mut stream = stream(1);
        assert_eq!(take(&mut stream, 0, false, true), (0, None));
        assert_eq!(take(&mut stream, 0xff, false, false), (0, None));
        assert_eq!(take(&mut stream, 0, false, true), (0, None));
        let (flags, packet) = take(&mut stream, 0, true, false);
        let packet = packet.unwrap();
        assert_eq!((flags, packet.bytes.len(), packet.ends_null), (0, 8, true));
        assert_eq!(take(&mut stream, 0, true, false).0, FLAG_RAGGED);
        let (flags, packet) = take(&mut stream, 0xf, true, true);
        assert_eq!((flags, packet.unwrap().ends_null), (0, false));
    }

    #[test]
    fn each_shape_that_is_wrong_has_its_flag() {
        for (keep, last, flags) in [
            (0x0f, false, FLAG_BEAT),
            (0xf0, true, FLAG_BEAT | FLAG_RAGGED),
            (0x3f, true, FLAG_RAGGED),
            (0x1f, true, FLAG_BEAT | FLAG_RAGGED),
            (0xfe, false, FLAG_BEAT),
        ] {
            assert_eq!(take(&mut stream(1), keep, last, false).0, flags, "{keep:x}");
        }
        let mut turns = stream(1);
        take(&mut turns, 0xff, false, false);
        assert_eq!(take(&mut turns, 0xff, true, true).0, FLAG_BEAT);
    }

    #[test]
    fn an_mvoxel_that_is_to_be_kept_ends_within_both_halves() {
        for (segments, user, flags) in [(1, false, 0), (2, false, FLAG_LARGE), (2, true, 0)] {
            let mut stream = stream(segments);
            let beats = 2 * 96 / 8;
            for _ in 1..beats {
                assert_eq!(take(&mut stream, 0xff, false, user).0, 0);
            }
            assert_eq!(take(&mut stream, 0xff, false, user).0, flags);
        }
        let mut stream = stream(2);
        (1..24).for_each(|_| drop(take(&mut stream, 0xff, false, false)));
        assert_eq!(take(&mut stream, 0xff, true, false).0, 0);
    }

    #[test]
    fn a_bare_end_behind_full_beats_is_a_beat_of_its_own() {
        let all = |entries, null| {
            let frames = frames(entries, 2, null);
            frames
                .iter()
                .map(|f| (f.first, f.kept, f.last))
                .collect::<Vec<_>>()
        };
        assert_eq!(all(4, false), [(0, 2, false), (2, 2, true)]);
        assert_eq!(all(4, true), [(0, 2, false), (2, 2, false), (4, 0, true)]);
        assert_eq!(all(3, true), [(0, 2, false), (2, 1, true)]);
    }

    #[test]
    fn blocks_have_the_same_rows_with_every_channel() {
        let keep = |kept: usize| -> Vec<bool> { (0..8).map(|i| i < kept).collect() };
        let wrong = |beats: &[(usize, bool)]| {
            let mut stream = BlockStream::default();
            let flags = beats
                .iter()
                .map(|(kept, last)| stream.take(&keep(*kept), *last, 2, 3));
            flags.collect::<Vec<_>>()
        };
        assert_eq!(
            wrong(&[(8, false), (0, false), (8, false), (4, false), (4, true)]),
            [false; 5]
        );
        assert_eq!(wrong(&[(4, false), (4, false), (0, true)]), [false; 3]);
        assert_eq!(
            wrong(&[(8, false), (0, true), (8, false)]),
            [false, true, false]
        );
        assert_eq!(wrong(&[(8, true)]), [true]);
        assert_eq!(wrong(&[(3, false)]), [true]);
        assert_eq!(wrong(&[(8, false), (6, false)]), [false, true]);
        assert_eq!(
            wrong(&[(4, false), (4, false), (8, false)]),
            [false, false, true]
        );
    }
}
