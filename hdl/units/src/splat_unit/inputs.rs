//! Inputs of the unit, and the promises about them.

use potamoi_netlist::{ModuleBuilder, Signal, Ty};

use super::formats::Widths;
use crate::circuits::{ones, sticky};

/// Bits of a record.
pub(super) const RECORD: u32 = 256;
/// Bytes of a word of the limits.
pub(super) const WORD: u32 = 4;
/// Bits of a tile's column or row in the picture.
pub(super) const TILE: u32 = 12;

/// Inputs.
pub(super) struct Inputs {
    pub(super) clear: Signal,
    pub(super) cap: Signal,
    pub(super) min: Signal,
    pub(super) stop: Signal,
    pub(super) centred: Signal,
    pub(super) last_slot: Signal,
    pub(super) valid: Signal,
    pub(super) data: Signal,
    pub(super) keep: Signal,
    pub(super) last: Signal,
    pub(super) user: Signal,
    pub(super) sink: Signal,
}

impl Inputs {
    pub(super) fn declare(m: &mut ModuleBuilder, w: &Widths) -> Self {
        let mut input = |name: &str, bits: u32, doc: &str| m.input(name, Ty::u(bits), doc);
        Self {
            clear: input("cfg_clear", 1, "clears the counters"),
            cap: input("cfg_alpha_cap", 17, "largest alpha, U0.16"),
            min: input("cfg_alpha_min", 17, "smaller alphas do not count"),
            stop: input(
                "cfg_stop_below",
                38,
                "a pixel ends below it, 36 fraction bits",
            ),
            centred: input(
                "cfg_centred",
                1,
                "pixel centres lie at half a pixel, not at 0",
            ),
            last_slot: input(
                "cfg_last_slot",
                w.slot,
                "pixels of tiles 0 to this are given, and records in later ones dropped",
            ),
            valid: input(
                "s_axis_spl_tvalid",
                1,
                "a record in a tile, or a word of the limits",
            ),
            data: input(
                "s_axis_spl_tdata",
                RECORD,
                "the record; or a word of the limits from bit 8, and its address in bits 6 .. 0",
            ),
            keep: input(
                "s_axis_spl_tkeep",
                RECORD / 8,
                "all bytes of a record, four of a word of the limits, or none",
            ),
            last: input("s_axis_spl_tlast", 1, "ends the job: pixels follow"),
            user: input(
                "s_axis_spl_tuser",
                w.slot + 2 * TILE + 8,
                "slot; the tile's column and row, 12 bits each; its last pixel's column and row, 4 each",
            ),
            sink: input("m_axis_pix_tready", 1, ""),
        }
    }

    /// Flags: bytes that are neither a record nor a word, a setting that moves within a job, and a record
    /// that was dropped.
    pub(super) fn flag(
        &self,
        m: &mut ModuleBuilder,
        busy: Signal,
        [enters, is_dropped]: [Signal; 2],
    ) {
        let all = m.lit(ones(RECORD / 8), self.keep.ty());
        let four = m.lit(ones(WORD), self.keep.ty());
        let nothing = m.lit(0, self.keep.ty());
        let right = [all, four, nothing].map(|allowed| m.eq(self.keep, allowed));
        let right = m.any_of(&right);
        let wrong = m.not(right);
        let torn = m.and(enters, wrong);
        let settings = [self.cap, self.min, self.stop, self.centred, self.last_slot];
        let settings = m.cat(&settings);
        let settings = m.name(settings, "settings");
        let past = m.data_reg("settings_before", settings.ty());
        m.set_next(past, settings);
        let other = m.ne(settings, past);
        let moved = m.and(other, busy);
        let dropped = m.and(enters, is_dropped);
        let flags = [
            sticky(m, "record_dropped", self.clear, dropped),
            sticky(m, "setting_moved", self.clear, moved),
            sticky(m, "torn_beat", self.clear, torn),
        ];
        let flags = m.cat(&flags);
        m.output(
            "stat_errors",
            flags,
            "0: bytes kept that are none of the three; 1: a setting moved within a job; 2: a record dropped",
        );
    }
}
