//! The files of a command's report: JSON, and its tables as CSV.

mod tables;

use std::path::{Path, PathBuf};

use clap::Args;
use potamoi_base::outputs::{self, FileError};
use serde::Serialize;

use crate::failure::Failure;

#[derive(Debug, Default, Args)]
pub(crate) struct ReportFiles {
    /// Write the report as JSON; several scenes or frames share one report
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Folder for the tables of the report as CSV, a file each; it is created if missing
    #[arg(long, value_name = "DIR")]
    csv_dir: Option<PathBuf>,
}

impl ReportFiles {
    /// Checks before any work that the files can be written, with other outputs of the command.
    pub(crate) fn prepare<'a>(
        &'a self,
        others: impl IntoIterator<Item = Option<&'a PathBuf>>,
    ) -> Result<(), FileError> {
        outputs::prepare(std::iter::once(self.json.as_ref()).chain(others))?;
        match &self.csv_dir {
            Some(folder) => outputs::prepare([Some(&file(folder, ""))]),
            None => Ok(()),
        }
    }

    /// Whether there is a file to write.
    pub(crate) fn are_asked(&self) -> bool {
        self.json.is_some() || self.csv_dir.is_some()
    }

    /// Writes the files that were asked for.
    pub(crate) fn write(&self, report: &impl Serialize) -> Result<(), Failure> {
        if let Some(path) = &self.json {
            outputs::write_json(path, report)?;
        }
        if let Some(folder) = &self.csv_dir {
            let whole = serde_json::to_value(report);
            let whole = whole.map_err(|error| FileError::new(folder, error.into()))?;
            for (place, table) in tables::of(&whole) {
                let path = file(folder, &place);
                let text = table.csv();
                let text = text.map_err(|error| FileError::new(&path, error))?;
                outputs::write(&path, &text)?;
            }
        }
        Ok(())
    }
}

/// The file of a table: what stands in no list is `report.csv`.
fn file(folder: &Path, place: &str) -> PathBuf {
    let name = if place.is_empty() { "report" } else { place };
    folder.join(format!("{name}.csv"))
}
