//! Compares the gathering unit with its cycle model and its golden features in every cycle and
//! every bit.

use potamoi_cycles::UnitModel;
use potamoi_cycles::gathering_unit::Counters;
use potamoi_cycles::{GatherInputs, GatherWork, Group, WorkError};
use potamoi_formats::config::Config;
use potamoi_formats::units::GATHERING_UNIT;

use super::gather_drive::{BeatSeen, GatherSeen, GatherWatch};
use super::mismatch::{Mismatch, first_difference, same};
use super::model::RtlError;
use super::words::{code, slot};

/// Names of the counters' ports.
const COUNTERS: [&str; 6] = [
    "stat_busy",
    "stat_stall_fifo",
    "stat_stall_mft",
    "stat_stall_rit",
    "stat_entries",
    "stat_stall_bank",
];

/// Observer that fails at the first difference.
pub(super) struct GatherCheck<'a, T> {
    work: &'a GatherWork<'a>,
    /// Features in task and entry order.
    features: &'a [T],
    model: UnitModel,
    groups: Box<dyn Iterator<Item = Group> + 'a>,
    beat: Option<Expected>,
    cycles: u64,
    every: &'a mut dyn FnMut(u64),
}

/// The next expected beat.
pub(super) struct Expected {
    group: Group,
    pub(super) data: Vec<u32>,
    pub(super) mask: Vec<u32>,
    pub(super) keep: Vec<u32>,
    keep_mask: Vec<u32>,
}

/// Cycles between two calls of the progress function.
const EVERY: u64 = 1 << 14;

impl<'a, T: Copy + Into<i32>> GatherCheck<'a, T> {
    /// `every` is called now and then with the cycles since the last call.
    ///
    /// # Errors
    /// Work that the model refuses.
    pub(super) fn new(
        config: &Config,
        work: &'a GatherWork<'a>,
        features: &'a [T],
        every: &'a mut dyn FnMut(u64),
    ) -> Result<Self, WorkError> {
        let mut groups: Box<dyn Iterator<Item = Group>> = Box::new(work.groups());
        let beat = groups.next().map(|g| Expected::new(work, features, g));
        Ok(Self {
            work,
            features,
            model: UnitModel::new(config, work)?,
            groups,
            beat,
            cycles: 0,
            every,
        })
    }

    fn differs(&self, cycle: u64, signal: &str, found: String, expected: String) -> Mismatch {
        let place = self.beat.as_ref().map_or_else(
            || "after the last beat".to_owned(),
            |b| {
                let g = &b.group;
                let last = g.entry + g.kept - 1;
                format!(
                    "next beat: MVoxel {}, segment {}, entries {} to {last}, channel {} and up",
                    g.task, g.segment, g.entry, g.low
                )
            },
        );
        Mismatch {
            module: GATHERING_UNIT,
            cycle,
            signal: signal.to_owned(),
            expected,
            found,
            place,
        }
    }

    fn beat(
        &self,
        cycle: u64,
        beat: &BeatSeen<'_>,
        wanted: &Expected,
    ) -> Result<(), Box<Mismatch>> {
        let work = self.work;
        let g = &wanted.group;
        same(u8::from(beat.last), u8::from(g.last), |found, expected| {
            self.differs(cycle, "m_axis_feat_tlast", found, expected)
        })?;
        let keep = first_difference(beat.keep, None, &wanted.keep, &wanted.keep_mask);
        if keep.is_some() {
            let hex = |words: &[u32]| words.iter().rev().map(|w| format!("{w:08x}")).collect();
            let (found, expected) = (hex(beat.keep), hex(&wanted.keep));
            return Err(Box::new(self.differs(
                cycle,
                "m_axis_feat_tkeep",
                found,
                expected,
            )));
        }
        for port in 0..work.side() {
            // A port without an entry has the slot 0.
            let entries = &work.tasks()[g.task].entries;
            let expected = match port < g.kept {
                true => entries[g.entry + port].slot,
                false => 0,
            };
            let wide = work.slot_bits() == 32;
            let expected = if wide { expected } else { expected & 0xffff };
            same(slot(beat.user, port, work.slot_bits()), expected, |f, e| {
                self.differs(cycle, &format!("m_axis_feat_tuser of port {port}"), f, e)
            })?;
        }
        if let Some(bit) = first_difference(beat.data, beat.unknown, &wanted.data, &wanted.mask) {
            let lane = bit / (8 * work.lane_bytes());
            let (port, bank) = (lane / work.width(), lane % work.width());
            let signal = format!("m_axis_feat_tdata of port {port}, bank {bank}");
            let unknown = beat
                .unknown
                .is_some_and(|u| code(u, lane, work.lane_bytes()) != 0);
            let found = if unknown {
                "not known (x or z)".to_owned()
            } else {
                code(beat.data, lane, work.lane_bytes()).to_string()
            };
            let expected = code(&wanted.data, lane, work.lane_bytes()).to_string();
            return Err(Box::new(self.differs(cycle, &signal, found, expected)));
        }
        Ok(())
    }
}

const fn list(c: &Counters) -> [u64; 6] {
    [
        c.busy,
        c.stall_fifo,
        c.stall_mft,
        c.stall_rit,
        c.entries,
        c.stall_bank,
    ]
}

impl Expected {
    pub(super) fn new<T: Copy + Into<i32>>(
        work: &GatherWork<'_>,
        features: &[T],
        group: Group,
    ) -> Self {
        let channels = work.channels();
        let bytes = work.lane_bytes() * work.width() * work.side();
        let mut beat = Self {
            group,
            data: vec![0; bytes.div_ceil(4)],
            mask: vec![0; bytes.div_ceil(4)],
            keep: vec![0; bytes.div_ceil(32)],
            keep_mask: vec![0; bytes.div_ceil(32)],
        };
        beat.fill(work, features, group, channels);
        beat
    }

    fn fill<T: Copy + Into<i32>>(
        &mut self,
        work: &GatherWork<'_>,
        features: &[T],
        group: Group,
        channels: usize,
    ) {
        let width = work.width();
        self.group = group;
        for words in [&mut self.data, &mut self.keep] {
            words.fill(0);
        }
        let low = group.low;
        let count = width.min(channels - low);
        let bytes = work.lane_bytes() * width;
        for port in 0..group.kept {
            let at = (group.ordinal + port) * channels + low;
            let mut codes = features[at..at + count].iter();
            for lane in port * width..(port + 1) * width {
                // Channels of the last segment past C come back as 0.
                let code: i32 = codes.next().map_or(0, |code| (*code).into());
                if work.lane_bytes() == 4 {
                    self.data[lane] = code as u32;
                } else {
                    self.data[lane / 2] |= u32::from(code as u16) << (16 * (lane % 2));
                }
            }
            for bit in bytes * port..bytes * (port + 1) {
                self.keep[bit / 32] |= 1 << (bit % 32);
            }
        }
        for byte in 0..bytes * work.side() {
            self.keep_mask[byte / 32] |= 1 << (byte % 32);
            self.mask[byte / 4] |= 0xff << (8 * (byte % 4));
        }
    }
}

impl<T: Copy + Into<i32>> GatherWatch for GatherCheck<'_, T> {
    fn cycle(
        &mut self,
        cycle: u64,
        inputs: &GatherInputs,
        seen: &GatherSeen<'_>,
    ) -> Result<(), RtlError> {
        let is_idle = self.model.is_idle();
        let wanted = self.model.step(inputs);
        for (name, found, expected) in [
            ("s_axis_rit_tready", seen.rit_ready, wanted.rit_ready),
            ("s_axis_mft_tready", seen.mft_ready, wanted.mft_ready),
            (
                "m_axis_feat_tvalid",
                seen.beat.is_some(),
                wanted.feat.is_some(),
            ),
            ("idle", seen.idle, is_idle),
        ] {
            same(u8::from(found), u8::from(expected), |f, e| {
                self.differs(cycle, name, f, e)
            })?;
        }
        let counters = list(&wanted.counters);
        if seen.counters != counters {
            for (i, name) in COUNTERS.into_iter().enumerate() {
                same(seen.counters[i], counters[i], |f, e| {
                    self.differs(cycle, name, f, e)
                })?;
            }
        }
        if let (Some(beat), Some(feature)) = (&seen.beat, wanted.feat) {
            if let Some(expected) = &self.beat {
                same(feature.kept as usize, expected.group.kept, |f, e| {
                    self.differs(cycle, "entries of the beat, by the cycle model", f, e)
                })?;
                self.beat(cycle, beat, expected)?;
            } else {
                let (found, expected) = ("1".to_owned(), "0".to_owned());
                let signal = "m_axis_feat_tvalid";
                return Err(Box::new(self.differs(cycle, signal, found, expected)).into());
            }
            if inputs.feat_ready {
                let next = self.groups.next();
                match (next, self.beat.take()) {
                    (Some(group), Some(mut beat)) => {
                        beat.fill(self.work, self.features, group, self.work.channels());
                        self.beat = Some(beat);
                    }
                    (Some(group), None) => {
                        self.beat = Some(Expected::new(self.work, self.features, group));
                    }
                    (None, _) => self.beat = None,
                }
            }
        }
        self.cycles += 1;
        if self.cycles.is_multiple_of(EVERY) {
            (self.every)(EVERY);
        }
        Ok(())
    }
}
