//! JSON reports.

use potamoi_explore::warping::Warping;
use schemars::JsonSchema;
use serde::Serialize;

/// Version of the JSON report.
pub(super) const FORMAT_VERSION: u32 = 2;

#[derive(Serialize, JsonSchema)]
pub(super) struct Report {
    pub(super) format_version: u32,
    pub(super) command: &'static str,
    #[serde(flatten)]
    pub(super) found: Warping,
}

#[derive(Serialize, JsonSchema)]
pub(super) struct Reports {
    pub(super) format_version: u32,
    pub(super) command: &'static str,
    pub(super) scenes: Vec<Warping>,
}
