//! Beats of the splat unit's input.

use potamoi_cycles::splat_unit::SplatBeat;
use potamoi_reference::splat_unit::{SplatEntry, SplatPixel};

use crate::splat_beats::data_of;

/// A beat of the input.
#[derive(Clone, Copy)]
pub(super) enum Beat<'a> {
    /// A word of the limits.
    Limit(u32),
    /// A record, and whether it ends the job.
    Record(&'a SplatEntry, bool),
    /// The end of a job without records.
    End,
}

impl<'a> Beat<'a> {
    pub(super) fn entry(self) -> Option<&'a SplatEntry> {
        match self {
            Self::Record(entry, _) => Some(entry),
            Self::Limit(_) | Self::End => None,
        }
    }

    pub(super) fn of_model(self) -> SplatBeat<'a> {
        match self {
            Self::Record(entry, ends) => SplatBeat::Record(entry, ends),
            Self::Limit(_) => SplatBeat::Other(false),
            Self::End => SplatBeat::Other(true),
        }
    }

    /// Data, number of bytes that are kept, and whether the job ends.
    pub(super) fn words(self) -> (Vec<u32>, u32, bool) {
        match self {
            Self::Limit(word) => (vec![word, 0, 0, 0, 0, 0, 0, 0], 4, false),
            Self::End => (vec![0; 8], 0, true),
            Self::Record(entry, ends) => (data_of(entry), 32, ends),
        }
    }
}

/// Beats of a job.
pub(super) fn beats_of(job: &[SplatEntry]) -> Vec<Beat<'_>> {
    let count = job.len();
    let records = job.iter().enumerate();
    let mut beats: Vec<_> = records
        .map(|(i, own)| Beat::Record(own, i + 1 == count))
        .collect();
    if beats.is_empty() {
        beats.push(Beat::End);
    }
    beats
}

pub(super) fn pixel_of(words: &[u32]) -> SplatPixel {
    let bits = |low: usize, width: usize| {
        (0..width).fold(0u64, |value, i| {
            let bit = words[(low + i) / 32] >> ((low + i) % 32) & 1;
            value | u64::from(bit) << i
        })
    };
    SplatPixel {
        transmittance: bits(0, 24) as u32,
        colour: [0, 1, 2].map(|channel| bits(24 + 40 * channel, 40)),
    }
}
