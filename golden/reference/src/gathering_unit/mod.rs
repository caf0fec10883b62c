//! The gathering unit's arithmetic: weighted sums of feature rows.

use potamoi_formats::config::{Config, Sums, WeightTrust};
use potamoi_formats::fixed::{Format, Rounding, round_shift};
use potamoi_formats::rit::{RitEntry, Vertices};
use rayon::prelude::*;
use thiserror::Error;

use super::GatherTask;

/// Error flag: an issued id names a row that was not loaded.
pub const FLAG_ROW: u8 = 1 << 0;
/// Error flag: a weight has a bit above bit W set.
pub const FLAG_WEIGHT: u8 = 1 << 1;
/// Error flag: an entry's weights do not sum to 1 (`trusted` only).
pub const FLAG_SUM: u8 = 1 << 2;
/// Error flag: more rows than the MVoxel feature table holds.
pub const FLAG_TABLE: u8 = 1 << 6;

/// A task that the gathering unit's streams cannot express.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum GatherError {
    /// The task has no channels.
    #[error("gather task: 0 channels; a feature has at least 1")]
    NoChannels,
    /// The channels need more segments than the unit has.
    #[error(
        "gather task: {channels} channels are {segments} segments, \
         but gu.segments allows {allowed}; raise gu.segments or gu.banks"
    )]
    Segments {
        /// Channels of the task.
        channels: usize,
        /// Segments that they need.
        segments: usize,
        /// Segments that the unit was built for.
        allowed: u32,
    },
    /// The task has no entries.
    #[error("gather task: no entries; skip MVoxels without entries")]
    NoEntries,
    /// The task has no rows.
    #[error("gather task: no rows; the feature stream carries at least one")]
    NoRows,
    /// The feature codes are not a whole number of rows.
    #[error("gather task: {codes} feature codes are not a multiple of {channels} channels")]
    Ragged {
        /// Feature codes given.
        codes: usize,
        /// Channels of a row.
        channels: usize,
    },
    /// A feature does not fit the width of the lanes.
    #[error(
        "gather task: feature {code} in row {row}, channel {channel} does not fit \
         gu.feature_bits = {bits}; quantise features to that width"
    )]
    Feature {
        /// Row of the feature.
        row: usize,
        /// Channel of the feature.
        channel: usize,
        /// The feature code.
        code: i16,
        /// Width of the lanes in bits.
        bits: u32,
    },
    /// The unit was not built for entries of this size.
    #[error(
        "gather task: entries of {vertices} vertices, but the unit was built for {built:?}; \
         see gu.modes and gu.vertices"
    )]
    Vertices {
        /// Vertices of each entry of the task.
        vertices: usize,
        /// Vertices that the unit was built for.
        built: Vec<usize>,
    },
    /// A single id cannot carry the slot.
    #[error(
        "gather task: entry {entry} has slot {slot}, but a single id carries 16 bits; \
         use a smaller ray group"
    )]
    Slot {
        /// The entry.
        entry: usize,
        /// Its slot.
        slot: u32,
    },
}

/// The arithmetic of a reducer: exact sums in a wrapping accumulator, and one rounding.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Reducer {
    feature: Format,
    weight_bits: u32,
    accumulator_bits: u32,
}

impl Reducer {
    /// The reducer of the unit that `config` describes.
    #[must_use]
    pub fn new(config: &Config) -> Self {
        Self {
            feature: Format::signed(config.gu.feature_bits.clamp(2, 16) - 1, 0),
            weight_bits: config.gu.weight_bits.min(15),
            accumulator_bits: config.accumulator_bits().min(60),
        }
    }

    /// Fraction bits of weights, `W`.
    #[must_use]
    pub fn weight_bits(&self) -> u32 {
        self.weight_bits
    }

    /// The significant bits of a weight.
    fn weight(&self, code: u16) -> i64 {
        i64::from(code) & ((2 << self.weight_bits) - 1)
    }

    /// The unrounded accumulator of one channel: the sum of weight times code over `terms`. Sums
    /// over the parts of an entry add up to the sum of the whole entry.
    #[must_use]
    pub fn sum(&self, terms: impl Iterator<Item = (u16, i16)>) -> i64 {
        let products = terms.map(|(w, code)| self.weight(w) * i64::from(code));
        self.wrap(products.sum())
    }

    fn wrap(&self, sum: i64) -> i64 {
        let spare = 64 - self.accumulator_bits;
        sum << spare >> spare
    }

    /// Of an accumulator halfway between two codes, whether it is rounded up; else nothing.
    #[must_use]
    pub fn tie(&self, sum: i64) -> Option<bool> {
        let unit = 1 << self.weight_bits;
        (2 * sum.rem_euclid(unit) == unit).then(|| sum.div_euclid(unit) & 1 == 1)
    }

    /// Rounds an accumulator to a feature code, half to even.
    #[must_use]
    pub fn round(&self, sum: i64) -> i16 {
        let sum = i128::from(self.wrap(sum));
        let rounded = round_shift(sum, self.weight_bits, Rounding::HalfEven);
        self.feature.saturate(rounded).0 as i16
    }
}

/// Bit-exact model of the gathering unit, without timing.
#[derive(Debug, Clone)]
pub struct ReferenceGatheringUnit {
    reducer: Reducer,
    trusted: bool,
    built: Vec<Vertices>,
    config: Config,
}

/// The type of a result: a rounded feature code, or the unrounded sum.
trait Code: Copy + Default + Send {
    /// From a sum of weight times code.
    fn of_sum(reducer: &Reducer, sum: i64) -> Self;
    /// From a code that is not weighted.
    fn of_code(reducer: &Reducer, code: i16) -> Self;
}

impl Code for i16 {
    fn of_sum(reducer: &Reducer, sum: i64) -> Self {
        reducer.round(sum)
    }

    fn of_code(_: &Reducer, code: i16) -> Self {
        code
    }
}

/// Trusted weights keep a sum below 2^31.
impl Code for i32 {
    fn of_sum(_: &Reducer, sum: i64) -> Self {
        sum as Self
    }

    fn of_code(reducer: &Reducer, code: i16) -> Self {
        Self::from(code) << reducer.weight_bits
    }
}

/// Minimum number of sums for a second thread.
const PARALLEL: usize = 1 << 14;

impl ReferenceGatheringUnit {
    /// The unit that `config` describes, which must have passed the rules of
    /// `potamoi_formats::config`.
    #[must_use]
    pub fn new(config: &Config) -> Self {
        Self {
            reducer: Reducer::new(config),
            trusted: config.gu.weights == WeightTrust::Trusted,
            built: config.supported_vertices(),
            config: config.clone(),
        }
    }

    /// Checks that the unit's streams can express `task`.
    ///
    /// # Errors
    /// The first rule that the task breaks.
    pub fn check(&self, task: &GatherTask) -> Result<(), GatherError> {
        let channels = task.channels;
        if channels == 0 {
            return Err(GatherError::NoChannels);
        }
        let (segments, allowed) = (self.config.segments(channels), self.config.gu.segments);
        if segments > allowed as usize {
            return Err(GatherError::Segments {
                channels,
                segments,
                allowed,
            });
        }
        if !self.built.contains(&task.vertices) {
            return Err(GatherError::Vertices {
                vertices: task.vertices.count(),
                built: self.built.iter().map(|v| v.count()).collect(),
            });
        }
        if task.entries.is_empty() {
            return Err(GatherError::NoEntries);
        }
        if task.rows.is_empty() {
            return Err(GatherError::NoRows);
        }
        if !task.rows.len().is_multiple_of(channels) {
            return Err(GatherError::Ragged {
                codes: task.rows.len(),
                channels,
            });
        }
        let outside = |&code: &i16| self.reducer.feature.saturate(i128::from(code)).1;
        if let Some(at) = task.rows.iter().position(outside) {
            return Err(GatherError::Feature {
                row: at / channels,
                channel: at % channels,
                code: task.rows[at],
                bits: self.reducer.feature.width(),
            });
        }
        if !task.vertices.is_structured() {
            let wide = |e: &RitEntry| e.slot > 0xffff;
            if let Some(entry) = task.entries.iter().position(wide) {
                return Err(GatherError::Slot {
                    entry,
                    slot: task.entries[entry].slot,
                });
            }
        }
        Ok(())
    }

    /// Gathers a task: appends `channels` feature codes for every entry and returns the error
    /// flags that the task raises (bits 0, 1, 2 and 6 of `stat_errors`).
    ///
    /// A row that was not loaded counts as 0. Bits W..0 of a weight count. The sum wraps at the
    /// accumulator's width, which weights that sum to 1 never reach. The number of segments does
    /// not change the result.
    ///
    /// # Errors
    /// Those of [`ReferenceGatheringUnit::check`]; nothing is appended then.
    pub fn gather(&self, task: &GatherTask, features: &mut Vec<i16>) -> Result<u8, GatherError> {
        self.append(task, features)
    }

    /// As [`ReferenceGatheringUnit::gather`], but returns unrounded sums in units of 2^-W, for weights that
    /// sum to at most 1. The sums of the partial entries of a cell in several MVoxels add up to
    /// the cell's sum.
    ///
    /// # Errors
    /// Those of [`ReferenceGatheringUnit::check`]; nothing is appended then.
    pub fn sums(&self, task: &GatherTask, sums: &mut Vec<i32>) -> Result<u8, GatherError> {
        self.append(task, sums)
    }

    /// The arithmetic of one reducer.
    #[must_use]
    pub fn reducer(&self) -> &Reducer {
        &self.reducer
    }

    fn append<T: Code>(&self, task: &GatherTask, features: &mut Vec<T>) -> Result<u8, GatherError> {
        self.check(task)?;
        let channels = task.channels;
        let capacity = self.config.mvoxel_capacity(task.vertices, channels) as usize;
        let held = (task.rows.len() / channels).min(capacity) * channels;
        let rows = task.rows.get(..held).unwrap_or_default();
        let begin = features.len();
        features.resize(begin + task.entries.len() * channels, T::default());
        let out = &mut features[begin..];
        if out.len() < PARALLEL {
            for (out, entry) in out.chunks_exact_mut(channels).zip(&task.entries) {
                self.reduce(task.vertices, rows, entry, out);
            }
        } else {
            out.par_chunks_exact_mut(channels)
                .zip(&task.entries)
                .for_each(|(out, entry)| self.reduce(task.vertices, rows, entry, out));
        }
        let loaded = held / channels;
        let mut flags = if held < task.rows.len() {
            FLAG_TABLE
        } else {
            0
        };
        for entry in &task.entries {
            flags |= self.flags(task.vertices, loaded, entry);
        }
        Ok(flags)
    }

    /// Reduces one entry. `out` holds 0 for every channel on entry.
    fn reduce<T: Code>(&self, vertices: Vertices, rows: &[i16], entry: &RitEntry, out: &mut [T]) {
        let channels = out.len();
        let row = |v: usize| {
            let from = usize::from(entry.rows[v]) * channels;
            rows.get(from..from + channels)
        };
        if !vertices.is_structured() {
            for (out, code) in out.iter_mut().zip(row(0).unwrap_or_default()) {
                *out = T::of_code(&self.reducer, *code);
            }
            return;
        }
        let mut terms = [(0u16, [].as_slice()); potamoi_formats::rit::MAX_VERTICES];
        let mut used = 0;
        for v in 0..vertices.count() {
            if let Some(row) = row(v) {
                terms[used] = (entry.weights[v], row);
                used += 1;
            }
        }
        for (channel, out) in out.iter_mut().enumerate() {
            let terms = terms[..used].iter().map(|(w, row)| (*w, row[channel]));
            *out = T::of_sum(&self.reducer, self.reducer.sum(terms));
        }
    }

    fn flags(&self, vertices: Vertices, loaded: usize, entry: &RitEntry) -> u8 {
        let count = vertices.count();
        let mut flags = 0;
        if entry.rows[..count]
            .iter()
            .any(|&r| usize::from(r) >= loaded)
        {
            flags |= FLAG_ROW;
        }
        if vertices.is_structured() {
            let weights = &entry.weights[..count];
            let weight = |w: u16| self.reducer.weight(w);
            if weights.iter().any(|&w| weight(w) != i64::from(w)) {
                flags |= FLAG_WEIGHT;
            }
            let sum: i64 = weights.iter().map(|&w| weight(w)).sum();
            let one = 1 << self.reducer.weight_bits;
            let off = match self.config.gu.sums {
                Sums::Rounded => sum != one,
                Sums::Exact => sum > one,
            };
            if self.trusted && off {
                flags |= FLAG_SUM;
            }
        }
        flags
    }
}

#[cfg(test)]
mod tests;
