//! JSON reports.

use potamoi_system::system_model::System;
use schemars::JsonSchema;
use serde::Serialize;

/// Version of the JSON reports.
///
/// 2: results at both bounds of the GPU's kernels (`run.max`, `run.sum`), and the GPU alone.
pub(super) const FORMAT_VERSION: u32 = 3;

/// Results of scenes on a system.
#[derive(Serialize, JsonSchema)]
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
