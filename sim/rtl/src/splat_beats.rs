//! Beats of the splat unit's input, shared by its driver and its bench.

use potamoi_formats::config::{Config, SuConfig};
use potamoi_reference::splat_unit::{SplatEntry, SplatSettings, StoredLimits};

/// Bytes of a record.
pub(super) const RECORD_BYTES: usize = 32;
/// Bytes of a word of the limits.
pub(super) const WORD_BYTES: usize = 4;

/// Words of the limits as beats: address, and word from bit 8.
pub(super) fn limit_words(config: &Config, settings: &SplatSettings) -> Vec<u32> {
    let exp = &config.vu.exp;
    let min = settings.thresholds.alpha_min as i32;
    let words = StoredLimits::new(exp, settings.opacity, min).words(exp.input.width());
    (0u32..)
        .zip(words)
        .map(|(at, word)| at | word << 8)
        .collect()
}

/// `tuser` of a record: slot, place of the tile, its last pixel.
pub(super) fn user_of(su: &SuConfig, entry: &SplatEntry) -> u64 {
    let slot = su.slot_bits();
    let fields = [
        (entry.slot, 0),
        (entry.tile[0], slot),
        (entry.tile[1], slot + 12),
        (u16::from(entry.last[0]), slot + 24),
        (u16::from(entry.last[1]), slot + 28),
    ];
    let placed = fields.map(|(value, low)| u64::from(value) << low);
    placed.into_iter().fold(0, |all, own| all | own)
}

/// Data of a record, low word first.
pub(super) fn data_of(entry: &SplatEntry) -> Vec<u32> {
    let channels = entry.record.to_channels();
    let halves = channels.as_chunks::<2>().0.iter();
    let word = |[low, high]: &[i16; 2]| u32::from(*low as u16) | u32::from(*high as u16) << 16;
    halves.map(word).collect()
}
