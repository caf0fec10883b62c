//! Reading of files of rows.

use std::collections::BTreeMap;

use serde::Deserialize;

use super::{Measured, Range, Row, RowError};
use crate::Device;
use crate::programs::program;

const COUNTS: &str = "rows/counts.toml";

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct CountFile {
    set: BTreeMap<String, BTreeMap<String, CountEntry>>,
    row: Vec<RowEntry>,
}

#[derive(Deserialize, Clone)]
#[serde(deny_unknown_fields)]
struct CountEntry {
    low: f64,
    mid: f64,
    high: f64,
    source: Option<String>,
    derived: Option<String>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RowEntry {
    id: String,
    title: String,
    program: String,
    device: String,
    sets: Vec<String>,
    #[serde(default)]
    counts: BTreeMap<String, CountEntry>,
}

fn form(file: &'static str, message: String) -> RowError {
    RowError::Form { file, message }
}

impl CountEntry {
    fn range(&self, row: &str, name: &str) -> Result<Range, RowError> {
        let Self { low, mid, high, .. } = *self;
        if !(0.0 <= low && low <= mid && mid <= high && high.is_finite()) {
            let message = format!(
                "row `{row}`: `{name}` is {low}, {mid}, {high}, but has to rise from low to high"
            );
            return Err(form(COUNTS, message));
        }
        let (origin, published) = match (&self.source, &self.derived) {
            (Some(source), None) => (source, true),
            (None, Some(rule)) => (rule, false),
            _ => {
                let message = format!(
                    "row `{row}`: `{name}` needs either a `source` or a rule by which it is `derived`"
                );
                return Err(form(COUNTS, message));
            }
        };
        Ok(Range {
            low,
            mid,
            high,
            origin: origin.clone(),
            published,
        })
    }
}

/// Rows from the text of the file of counts.
pub(super) fn rows(text: &str) -> Result<Vec<Row>, RowError> {
    let file: CountFile = toml::from_str(text).map_err(|e| form(COUNTS, e.message().to_owned()))?;
    file.row.iter().map(|entry| row(entry, &file)).collect()
}

fn row(entry: &RowEntry, file: &CountFile) -> Result<Row, RowError> {
    let id = &entry.id;
    let mut merged: BTreeMap<&String, &CountEntry> = BTreeMap::new();
    for name in &entry.sets {
        let set = file.set.get(name).ok_or_else(|| {
            let message = format!("row `{id}`: no set is called `{name}`; define [set.{name}]");
            form(COUNTS, message)
        })?;
        merged.extend(set);
    }
    // Counts of the row itself come last.
    merged.extend(&entry.counts);
    let mut counts = BTreeMap::new();
    for (name, count) in merged {
        counts.insert(name.clone(), count.range(id, name)?);
    }
    let refused = |source| RowError::Counts {
        row: id.clone(),
        source: Box::new(source),
    };
    let own = Row {
        id: id.clone(),
        title: entry.title.clone(),
        program: program(&entry.program).map_err(refused)?,
        device: Device::builtin(&entry.device).map_err(|source| RowError::Device {
            row: id.clone(),
            source: Box::new(source),
        })?,
        counts,
    };
    for at in [super::At::Low, super::At::High] {
        own.program
            .frame(&own.at(at), &own.device)
            .map_err(refused)?;
    }
    Ok(own)
}

const MEASURED: &str = "rows/measured.toml";

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct MeasuredFile {
    measured: Vec<MeasuredEntry>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct MeasuredEntry {
    row: String,
    least: f64,
    most: f64,
    publication: String,
    version: String,
    timed: String,
    mode: String,
    resolution: String,
    beside: Option<String>,
    missing: Option<String>,
    closes: Option<String>,
}

/// Measurements from the text of their file; their rows are among `rows`.
pub(super) fn measured(text: &str, rows: &[Row]) -> Result<Vec<Measured>, RowError> {
    let file: MeasuredFile =
        toml::from_str(text).map_err(|e| form(MEASURED, e.message().to_owned()))?;
    let mut all = vec![];
    for entry in file.measured {
        let MeasuredEntry {
            row, least, most, ..
        } = &entry;
        let own = rows.iter().find(|r| r.id == *row).ok_or_else(|| {
            let message = format!("no row of {COUNTS} is called `{row}`; correct the name");
            form(MEASURED, message)
        })?;
        if !(0.0 < *least && least <= most && most.is_finite()) {
            let message = format!(
                "row `{row}`: frames a second are {least} to {most}, but have to rise from above 0"
            );
            return Err(form(MEASURED, message));
        }
        all.push(Measured {
            row: own.clone(),
            least: entry.least,
            most: entry.most,
            publication: entry.publication,
            version: entry.version,
            timed: entry.timed,
            mode: entry.mode,
            resolution: entry.resolution,
            beside: entry.beside,
            missing: entry.missing,
            closes: entry.closes,
        });
    }
    Ok(all)
}
