//! Rows of a sweep, and their file.

use std::path::Path;

use serde::{Deserialize, Serialize};

use super::SweepError;
use crate::cells::{COLUMNS, Cell};

/// A point with its figures.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SweepRow {
    /// Key of the point.
    pub key: String,
    /// Values of the varied fields.
    pub setting: Vec<String>,
    /// Figures, in the order of [`COLUMNS`].
    pub cells: Vec<Cell>,
    /// Why there are none.
    pub refused: Option<String>,
}

/// All rows of a sweep.
#[derive(Debug, Clone, PartialEq)]
pub struct Rows {
    /// Varied fields.
    pub fields: Vec<String>,
    /// Rows in the order of the plan's points.
    pub rows: Vec<SweepRow>,
}

/// Begin of the columns of varied fields, some of which are named as figures are.
const SET: &str = "set.";

/// Column of a varied field.
#[must_use]
pub fn setting(field: &str) -> String {
    format!("{SET}{field}")
}

/// Columns beside fields and figures.
const KEY: &str = "key";
const REFUSED: &str = "refused";

impl Rows {
    /// All rows as CSV: key, varied fields, [`COLUMNS`], and the reason of a refusal.
    ///
    /// # Errors
    /// None: it is written to memory.
    pub fn csv(&self) -> Result<String, csv::Error> {
        let mut csv = csv::Writer::from_writer(vec![]);
        let fields: Vec<String> = self.fields.iter().map(|own| setting(own)).collect();
        let fields = fields.iter().map(String::as_str);
        let figures = COLUMNS.iter().map(|own| own.name);
        csv.write_record(
            [KEY]
                .into_iter()
                .chain(fields)
                .chain(figures)
                .chain([REFUSED]),
        )?;
        for row in &self.rows {
            let cells = row.cells.iter().map(ToString::to_string);
            let first = [row.key.clone()].into_iter().chain(row.setting.clone());
            csv.write_record(
                first
                    .chain(cells)
                    .chain([row.refused.clone().unwrap_or_default()]),
            )?;
        }
        let bytes = csv.into_inner().map_err(|error| error.into_error())?;
        Ok(String::from_utf8_lossy(&bytes).into_owned())
    }

    /// Reads the file that [`Rows::csv`] makes.
    ///
    /// # Errors
    /// The file cannot be read, or has other columns.
    pub fn read(path: &Path) -> Result<Self, SweepError> {
        let fail = |problem: String| SweepError::Rows {
            path: path.to_owned(),
            problem,
        };
        let file = potamoi_base::files::open(path).map_err(|error| fail(error.to_string()))?;
        let mut csv = csv::Reader::from_reader(file);
        let header = csv
            .headers()
            .map_err(|error| fail(error.to_string()))?
            .clone();
        let names: Vec<&str> = header.iter().collect();
        let figures: Vec<&str> = COLUMNS.iter().map(|own| own.name).collect();
        let fields = names.len().checked_sub(figures.len() + 2);
        let fields = fields.filter(|count| names[1 + count..names.len() - 1] == figures[..]);
        let Some(count) = fields.filter(|_| names[0] == KEY) else {
            return Err(fail(
                "it has other columns than this program writes".to_owned(),
            ));
        };
        let mut rows = vec![];
        for record in csv.records() {
            let record = record.map_err(|error| fail(error.to_string()))?;
            let all: Vec<&str> = record.iter().collect();
            let last = all[all.len() - 1];
            rows.push(SweepRow {
                key: all[0].to_owned(),
                setting: all[1..=count].iter().map(|own| (*own).to_owned()).collect(),
                cells: all[1 + count..all.len() - 1]
                    .iter()
                    .map(|own| cell(own))
                    .collect(),
                refused: (!last.is_empty()).then(|| last.to_owned()),
            });
        }
        Ok(Self {
            fields: names[1..=count]
                .iter()
                .map(|own| own.strip_prefix(SET).unwrap_or(own).to_owned())
                .collect(),
            rows,
        })
    }
}

/// A cell as it was written.
fn cell(text: &str) -> Cell {
    match text.parse::<f64>() {
        _ if text.is_empty() => Cell::Unknown,
        Ok(number) => Cell::Number(number),
        Err(_) => Cell::Text(text.to_owned()),
    }
}
