//! Beats that break promises of the gathering unit's streams and settings. What the flags must be is
//! computed from the rules of `docs/reference/gathering-unit.md`.

use potamoi_formats::config::{Config, Organisation};
use potamoi_formats::rit::Vertices;

use super::beat::Beat;
use super::script::{Clock, Script, keep_of};

/// Flags of rows and weights.
const ENTRIES: u64 = 7;
const RAGGED: u64 = 1 << 3;
const GAP: u64 = 1 << 4;
const TOO_LARGE: u64 = 1 << 5;
const ALL: u64 = 0x1ff;

pub(super) type Settings = Vec<(&'static str, u64)>;

/// Kept bytes of a beat of the RIT stream, `tlast` and `tuser`.
#[derive(Debug, Clone)]
pub(super) struct Table {
    keep: Vec<u32>,
    last: bool,
    user: bool,
}

/// The script of the unit's flags.
pub(super) fn script(config: &Config) -> Script {
    let mut writer = Writer::new(config);
    for vertices in config.supported_vertices() {
        writer.settings = writer.of(vertices, 1);
        writer.ends(vertices);
    }
    writer.keeps();
    writer.users();
    writer.sizes();
    writer.rows();
    writer.ranges();
    writer.moves();
    Script {
        clocks: writer.clocks,
    }
}

pub(super) struct Writer<'a> {
    pub(super) config: &'a Config,
    /// Bytes of a beat of the RIT stream.
    pub(super) bytes: usize,
    pub(super) settings: Settings,
    /// Flags that only these beats raise: where lanes load entries before a table is there, those may
    /// have weights and rows that are not right.
    pub(super) known: u64,
    pub(super) clocks: Vec<Clock>,
}

impl<'a> Writer<'a> {
    fn new(config: &'a Config) -> Self {
        let mut writer = Self {
            config,
            bytes: config.rit_stream_bits() as usize / 8,
            settings: vec![],
            known: match config.organisation().0 {
                Organisation::FeatureMajor => ALL & !ENTRIES,
                _ => ALL,
            },
            clocks: vec![],
        };
        writer.settings = writer.of(config.supported_vertices()[0], 1);
        writer.reset();
        writer
    }

    pub(super) fn of(&self, vertices: Vertices, segments: u64) -> Settings {
        vec![
            ("cfg_vertices", u64::from(vertices.log2())),
            ("cfg_segments", segments),
            ("cfg_two_records", 0),
            ("cfg_channels", 1),
        ]
    }

    /// A clock after which these flags are up, and all others down.
    pub(super) fn clock(&mut self, beats: [Option<Beat>; 2], up: u64) -> &mut Clock {
        self.clocks.push(Clock {
            beats: beats.to_vec(),
            settings: self.settings.clone(),
            up,
            down: self.known & !up,
            ..Clock::default()
        });
        let last = self.clocks.len() - 1;
        &mut self.clocks[last]
    }

    pub(super) fn reset(&mut self) {
        self.clock([None, None], 0).reset = true;
    }

    pub(super) fn idle(&mut self, times: u32, up: u64) {
        self.clock([None, None], up).times = times;
    }

    pub(super) fn table(&mut self, table: &Table, up: u64) -> &mut Clock {
        let beat = Beat::from([
            ("tkeep", table.keep.clone()),
            ("tlast", vec![u32::from(table.last)]),
            ("tuser", vec![u32::from(table.user)]),
        ]);
        self.clock([Some(beat), None], up)
    }

    /// A beat of the MFT with so many bytes kept.
    pub(super) fn row(&mut self, keep: &dyn Fn(usize) -> bool, last: bool, up: u64) -> &mut Clock {
        let bytes = 2 * self.config.gu.banks as usize;
        let beat = Beat::from([
            ("tkeep", keep_of(bytes, keep)),
            ("tlast", vec![u32::from(last)]),
        ]);
        self.clock([None, Some(beat)], up)
    }

    pub(super) fn kept(&self, bytes: usize, last: bool) -> Table {
        Table {
            keep: keep_of(self.bytes, |byte| byte < bytes),
            last,
            user: false,
        }
    }

    pub(super) fn full(&self) -> Table {
        self.kept(self.bytes, false)
    }

    /// So many full beats, in which nothing is wrong.
    pub(super) fn fulls(&mut self, times: usize) {
        let full = self.full();
        if times > 0 {
            self.table(&full, 0).times = times as u32;
        }
    }

    /// Ends of an MVoxel after every number of beats and bytes: flag 3 where its entries are not whole,
    /// flag 4 where half a word is kept.
    fn ends(&mut self, vertices: Vertices) {
        let entry = self.config.entry_bytes(vertices);
        let row = 48 * self.config.gu.ports as usize;
        for before in 0..row.div_ceil(self.bytes) {
            for bytes in (0..=self.bytes).filter(|bytes| bytes % 2 == 0 || before == 0) {
                let (all, odd) = (before * self.bytes + bytes, bytes % 2 == 1);
                let ragged = all == 0 || !all.is_multiple_of(entry);
                let up = if odd { GAP } else { u64::from(ragged) * RAGGED };
                self.fulls(before);
                let end = self.kept(bytes, true);
                self.table(&end, up).down = self.known & !(up | if odd { RAGGED } else { 0 });
                self.reset();
            }
        }
    }

    /// Beats with a hole, without their first bytes, or not full, first and last: flag 4.
    fn keeps(&mut self) {
        let bytes = self.bytes;
        // Two bytes alone: a wide beat's pairs are many.
        let firsts = |byte: usize| match bytes {
            ..=8 => (0..byte).collect(),
            _ => vec![0, byte / 2],
        };
        for byte in 1..bytes {
            for first in firsts(byte).into_iter().filter(|first| first + 1 < byte) {
                let table = Table {
                    keep: keep_of(bytes, |own| own == byte || own == first),
                    last: true,
                    user: false,
                };
                self.table(&table, GAP).down = self.known & !(GAP | RAGGED);
                self.reset();
            }
        }
        for (byte, last) in (0..bytes).flat_map(|byte| [(byte, false), (byte, true)]) {
            let patterns: [&dyn Fn(usize) -> bool; 3] =
                [&|own| own != byte, &|own| own > byte, &|own| own <= byte];
            for (i, pattern) in patterns.into_iter().enumerate() {
                let keep = keep_of(bytes, pattern);
                let count = (0..bytes).filter(|own| pattern(*own)).count();
                let contiguous = (0..count).all(pattern);
                let right = count == 0 || contiguous && count.is_multiple_of(2) && last;
                if right || contiguous && count == bytes {
                    continue;
                }
                let table = Table {
                    keep,
                    last,
                    user: false,
                };
                // Whether entries are whole is not defined where bytes are not.
                self.table(&table, GAP).down = self.known & !(GAP | RAGGED);
                if i == 0 {
                    self.clock([None, None], GAP).down = self.known & !(GAP | RAGGED);
                    let down = self.known & !RAGGED;
                    let clear = self.clock([None, None], 0);
                    (clear.clear, clear.down) = (true, down);
                }
                self.reset();
            }
        }
        // In the clock of the clear nothing is flagged.
        let hole = Table {
            keep: keep_of(bytes, |own| own == 1),
            last: true,
            user: false,
        };
        self.table(&hole, 0).clear = true;
        self.reset();
    }

    /// `tuser` changes within an MVoxel: flag 4; between two, or on beats that are ignored, it may.
    fn users(&mut self) {
        let full = self.full();
        let other = Table {
            user: true,
            ..self.full()
        };
        let ignored = Table {
            user: true,
            ..self.kept(0, false)
        };
        for (first, then) in [(&full, &other), (&other, &full)] {
            self.table(first, 0);
            self.idle(1, 0);
            self.table(then, GAP);
            self.idle(3, GAP);
            self.clock([None, None], 0).clear = true;
            self.reset();
        }
        // A MVoxel that fills a half goes on in the other one.
        let half = 48 * self.config.rit.entries as usize / self.bytes;
        self.fulls(half);
        self.table(&other, GAP);
        self.reset();
        self.fulls(half);
        let end = self.kept(0, true);
        self.table(&end, 0);
        self.reset();
        self.table(&ignored, 0);
        self.table(&full, 0);
        self.table(&ignored, 0);
        self.table(&full, 0);
        self.reset();
        // An end without bytes ends whole entries only, and has the `tuser` of its MVoxel.
        for vertices in self.config.supported_vertices() {
            self.settings = self.of(vertices, 1);
            let entry = self.config.entry_bytes(vertices);
            for beats in 1..=12 {
                let ragged = !(beats * self.bytes).is_multiple_of(entry);
                self.fulls(beats);
                self.idle(1, 0);
                let end = self.kept(0, true);
                self.table(&end, u64::from(ragged) * RAGGED);
                self.reset();
            }
        }
        self.fulls(1);
        let end = Table {
            user: true,
            ..self.kept(0, true)
        };
        self.table(&end, GAP).down = self.known & !(GAP | RAGGED);
        self.reset();
    }

    /// More than both halves of the buffer hold: flag 5, if they are to be kept for further segments.
    fn sizes(&mut self) {
        let config = self.config;
        let both = 2 * 48 * config.rit.entries as usize / self.bytes;
        let vertices = config.supported_vertices()[0];
        let most = u64::from(config.gu.segments);
        for (segments, user, last) in [
            (most, false, false),
            (most.min(2), false, false),
            (1, false, false),
            (most, true, false),
            (most, false, true),
        ] {
            self.settings = self.of(vertices, segments);
            let full = Table {
                user,
                ..self.full()
            };
            self.table(&full, 0).times = both as u32 - 1;
            let large = segments > 1 && !user && !last;
            let up = u64::from(large) * TOO_LARGE;
            self.table(&Table { last, ..full }, up);
            self.idle(3, up);
            self.clock([None, None], 0).clear = true;
            self.reset();
        }
        self.settings = self.of(vertices, 1);
    }
}
