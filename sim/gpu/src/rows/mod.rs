//! Measured frames of public programs: counts in one file, frame rates in another.
//!
//! Counts were fixed before frame rates were compared, and are not changed to meet them.

mod file;

use std::collections::BTreeMap;

use crate::programs::{CountError, Counts, Kind, Registered};
use crate::{Device, DeviceError};

/// Least, likely and largest value of a count.
#[derive(Debug, Clone, PartialEq)]
pub struct Range {
    /// Least.
    pub low: f64,
    /// Likely.
    pub mid: f64,
    /// Largest.
    pub high: f64,
    /// Publication, or rule by which it is derived.
    pub origin: String,
    /// Whether it is published.
    pub published: bool,
}

/// A program on a device with counts of a scene.
#[derive(Debug, Clone)]
pub struct Row {
    /// Short name.
    pub id: String,
    /// Program, scene and mode, for tables.
    pub title: String,
    /// The program.
    pub program: &'static Registered,
    /// The device.
    pub device: Device,
    /// Its counts, by name.
    pub counts: BTreeMap<String, Range>,
}

/// Which value of each range is meant.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum At {
    /// The least.
    Low,
    /// The likely one.
    Mid,
    /// The largest.
    High,
}

/// A measured frame rate.
#[derive(Debug, Clone)]
pub struct Measured {
    /// Program, device and counts of the measurement.
    pub row: Row,
    /// Least frames a second that are published for it.
    pub least: f64,
    /// Most frames a second that are published for it.
    pub most: f64,
    /// Where.
    pub publication: String,
    /// Version of the program.
    pub version: String,
    /// Timed region.
    pub timed: String,
    /// Power mode.
    pub mode: String,
    /// Resolution of the pictures.
    pub resolution: String,
    /// Missing documentation, for which the row is not judged.
    pub beside: Option<String>,
    /// The term or count that is missing, where the prediction is off by more than twice.
    pub missing: Option<String>,
    /// The one assumption that would close the gap, where it was looked for.
    pub closes: Option<String>,
}

impl Measured {
    /// All measurements of this crate.
    ///
    /// # Errors
    ///
    /// [`RowError`], where a file is not as it has to be.
    pub fn all() -> Result<Vec<Self>, RowError> {
        file::measured(include_str!("../../rows/measured.toml"), &Row::all()?)
    }

    /// Geometric mean of the least and the most published frames a second.
    #[must_use]
    pub fn frames_s(&self) -> f64 {
        (self.least * self.most).sqrt()
    }

    /// Whether program version, timed region, power mode and counts are documented.
    #[must_use]
    pub const fn judged(&self) -> bool {
        self.beside.is_none()
    }
}

/// Why rows are refused.
#[derive(Debug, thiserror::Error)]
pub enum RowError {
    /// The file is not as it has to be.
    #[error("{file}: {message}")]
    Form {
        /// The file.
        file: &'static str,
        /// The fault, and its remedy.
        message: String,
    },
    /// The device of a row is refused.
    #[error("row `{row}`: {source}")]
    Device {
        /// The row.
        row: String,
        /// Why.
        source: Box<DeviceError>,
    },
    /// The counts of a row are refused.
    #[error("row `{row}`: {source}")]
    Counts {
        /// The row.
        row: String,
        /// Why.
        source: Box<CountError>,
    },
}

impl Row {
    /// All rows of this crate.
    ///
    /// # Errors
    ///
    /// [`RowError`], where a file is not as it has to be.
    pub fn all() -> Result<Vec<Self>, RowError> {
        file::rows(include_str!("../../rows/counts.toml"))
    }

    /// The counts at one end of their ranges, or the likely ones.
    #[must_use]
    pub fn at(&self, at: At) -> Counts {
        let value = |range: &Range| match at {
            At::Low => range.low,
            At::Mid => range.mid,
            At::High => range.high,
        };
        let one = |(name, range): (&String, &Range)| (name.clone(), value(range));
        self.counts.iter().map(one).collect()
    }

    /// The likely counts with those chosen times a factor. What is fixed by picture, program or
    /// model stays; shares stay at most 1.
    #[must_use]
    pub fn times(&self, factor: f64, chosen: impl Fn(&str) -> bool) -> Counts {
        let mut counts = self.at(At::Mid);
        for count in self.program.counts() {
            let value = counts.get_mut(count.name).filter(|_| chosen(count.name));
            match (count.kind, value) {
                (Kind::Count, Some(value)) => *value *= factor,
                (Kind::Share, Some(value)) => *value = (*value * factor).min(1.0),
                _ => {}
            }
        }
        counts
    }
}

#[cfg(test)]
mod tests;
