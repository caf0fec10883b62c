//! Reading of files of rows.

use std::collections::BTreeMap;

use serde::Deserialize;

use super::{Range, Row, RowError};
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
    // Those of the row itself come last.
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
