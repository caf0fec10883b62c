//! JSON reports.

use potamoi_base::outputs as files;
use potamoi_system::system_model::System;
use serde::Serialize;

use super::ModelArgs;
use crate::failure::Failure;

/// Version of the JSON reports.
///
/// 2: results at both bounds of the GPU's kernels (`run.max`, `run.sum`), and the GPU alone.
const FORMAT_VERSION: u32 = 3;

/// Results of scenes on a system.
#[derive(Serialize)]
pub(super) struct Report<T> {
    format_version: u32,
    command: &'static str,
    system: System,
    pub(super) scenes: Vec<T>,
    /// Items that the files of all scenes leave open.
    not_checked: Vec<String>,
}

impl<T> Report<T> {
    pub(super) fn new(command: &'static str, system: &System, scenes: Vec<T>) -> Self {
        Self {
            format_version: FORMAT_VERSION,
            command,
            system: system.clone(),
            scenes,
            not_checked: crate::scene::left_open_of_files(),
        }
    }
}

/// Writes a report if requested.
pub(super) fn write(report: &impl Serialize, args: &ModelArgs) -> Result<(), Failure> {
    match &args.json {
        Some(path) => Ok(files::write_json(path, report)?),
        None => Ok(()),
    }
}
