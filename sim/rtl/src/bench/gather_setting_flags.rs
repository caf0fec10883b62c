//! Rows of the MFT, and settings, that break promises of the gathering unit.

use potamoi_formats::config::Organisation;
use potamoi_formats::rit::Vertices;

use super::gather_flags::Writer;

const ROWS: u64 = 1 << 6;
const SETTING: u64 = 1 << 7;
const MOVED: u64 = 1 << 8;
/// Clocks after which an MVoxel of one entry is issued.
const ISSUED: u32 = 60;

impl Writer<'_> {
    /// Rows past those of an MVoxel: flag 6, and what else the feature-major unit flags.
    pub(super) fn rows(&mut self) {
        let config = self.config;
        let lanes = config.organisation().0 == Organisation::FeatureMajor;
        let rows = config.mft_rows();
        let most = if lanes { rows / config.gu.banks } else { rows };
        for last in [false, true] {
            self.row(&|_| true, false, 0).times = most;
            self.idle(1, 0);
            self.row(&|_| true, last, ROWS);
            self.idle(3, ROWS);
            self.clock([None, None], 0).clear = true;
            self.reset();
        }
        self.row(&|_| true, false, 0).times = most - 1;
        self.row(&|_| true, true, 0);
        self.row(&|_| true, false, 0);
        self.reset();
        if !lanes {
            return;
        }
        let patterns: [&dyn Fn(usize) -> bool; 3] =
            [&|own| own < 1, &|own| own == 2 || own == 3, &|own| {
                own != 4 && own != 5
            }];
        for keep in patterns {
            self.row(keep, true, ROWS);
            self.reset();
        }
        // A block after a short one; of two channels, other rows than the first, and the end within.
        self.row(&|own| own < 4, false, 0);
        self.row(&|_| true, true, ROWS);
        self.reset();
        self.set("cfg_channels", 2);
        self.row(&|own| own < 4, false, 0);
        self.row(&|own| own < 2, true, ROWS);
        self.reset();
        self.row(&|_| true, true, ROWS);
        self.reset();
        self.set("cfg_channels", 1);
    }

    fn set(&mut self, name: &str, to: u64) {
        let own = self.settings.iter_mut().filter(|(own, _)| *own == name);
        own.for_each(|(_, value)| *value = to);
    }

    /// A setting out of range: flag 7, once an entry is issued. Results are not defined, nor other flags.
    pub(super) fn ranges(&mut self) {
        let config = self.config;
        let built = config.supported_vertices();
        let most = u64::from(config.gu.segments);
        let normal = self.of(built[0], 1);
        self.settings = normal.clone();
        self.issue(built[0], false);
        let powers = (0..7).map(|bit| 1 << bit);
        for segments in powers.clone().filter(|own| *own <= most) {
            self.set("cfg_segments", segments);
            self.issue(built[0], false);
        }
        for segments in powers.filter(|own| *own > most).chain([0, most + 1, 127]) {
            if (1..=most).contains(&segments) || segments > 127 {
                continue;
            }
            self.set("cfg_segments", segments);
            self.issue(built[0], true);
        }
        self.settings = normal.clone();
        for vertices in [
            Vertices::One,
            Vertices::Two,
            Vertices::Four,
            Vertices::Eight,
        ] {
            self.set("cfg_vertices", u64::from(vertices.log2()));
            self.issue(vertices, !built.contains(&vertices));
        }
        self.settings = normal.clone();
        if config.organisation().0 == Organisation::FeatureMajor {
            for channels in [0, u64::from(config.gu.banks) + 1, 127] {
                self.set("cfg_channels", channels.min(127));
                self.issue(built[0], true);
            }
        }
        self.settings = normal;
    }

    /// An MVoxel of one row and one entry, which reads it.
    fn issue(&mut self, vertices: Vertices, wrong: bool) {
        // Entries of every size fill as many bytes as the largest that was built.
        let built = self.config.supported_vertices().into_iter();
        let largest = built.map(|built| self.config.entry_bytes(built)).max();
        let entry = match wrong {
            true => largest.unwrap_or_default(),
            false => self.config.entry_bytes(vertices),
        };
        let (up, down) = if wrong { (SETTING, 0) } else { (0, SETTING) };
        let first = self.clocks.len();
        self.row(&|_| true, true, 0);
        let beats = entry.div_ceil(self.bytes);
        self.fulls(beats - 1);
        let end = self.kept(entry - (beats - 1) * self.bytes, true);
        self.table(&end, 0);
        self.idle(ISSUED, 0);
        for clock in &mut self.clocks[first..] {
            clock.down = down;
        }
        self.idle(3, up);
        let last = self.clocks.len() - 1;
        self.clocks[last].down = down;
        let clear = self.clock([None, None], 0);
        (clear.clear, clear.down) = (true, SETTING);
        self.reset();
    }

    /// Settings that change: flag 8 while `idle` is low, whichever bit it is, and nothing while it is high.
    pub(super) fn moves(&mut self) {
        let built = self.config.supported_vertices();
        let normal = self.of(built[0], 1);
        let full = self.full();
        for (setting, bits) in [
            ("cfg_vertices", 2),
            ("cfg_segments", 7),
            ("cfg_two_records", 1),
            ("cfg_channels", 7),
        ] {
            let channels = setting == "cfg_channels"
                && self.config.organisation().0 != Organisation::FeatureMajor;
            let records = setting == "cfg_two_records" && self.config.gu.records_a_row != 2;
            for bit in (0..bits).filter(|_| !channels && !records) {
                let own = normal.iter().find(|(name, _)| *name == setting);
                let moved = own.map_or(0, |own| own.1) ^ 1 << bit;
                let steady = self.known & !SETTING;
                self.set(setting, moved);
                self.idle(2, 0);
                self.table(&full, 0);
                self.clock([None, None], 0).down = steady;
                self.clock([None, None], 0).down = steady;
                self.reset();
                self.settings = normal.clone();
                self.table(&full, 0);
                self.idle(2, 0);
                // What moves may be out of range as well.
                let down = self.known & !(MOVED | SETTING);
                self.set(setting, moved);
                self.clock([None, None], MOVED).down = down;
                self.settings = normal.clone();
                self.clock([None, None], MOVED).down = down;
                self.clock([None, None], MOVED).down = down;
                self.reset();
            }
        }
        // A table that is written, or loaded, keeps the unit from being idle.
        for last in [false, true] {
            self.row(&|_| true, last, 0);
            self.idle(2, 0);
            self.set("cfg_segments", 2);
            self.idle(3, MOVED);
            self.clock([None, None], 0).clear = true;
            self.settings = normal.clone();
            self.reset();
        }
    }
}
