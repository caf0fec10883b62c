//! What `cost --scene` reports: every setting of every knob, and what a search found.

use serde::Serialize;

use super::trial::Point;
use potamoi_explore::system::Rung;

/// All that was found.
#[derive(Serialize)]
pub(super) struct Report {
    pub(super) format_version: u32,
    pub(super) command: &'static str,
    pub(super) scene: String,
    pub(super) algorithm: &'static str,
    pub(super) size: [u32; 2],
    /// Hexadecimal digits of the default's configuration.
    pub(super) configuration: String,
    /// The default first.
    pub(super) points: Vec<Point>,
    /// Settings that cannot be, and why.
    pub(super) refused: Vec<Refused>,
    /// Places among the points, by rising time.
    pub(super) front: Vec<usize>,
    pub(super) knee: Option<usize>,
    /// The model's own fidelity.
    pub(super) ladder: Vec<Rung>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) found: Option<Found>,
}

/// A setting that cannot be.
#[derive(Serialize)]
pub(super) struct Refused {
    pub(super) knob: &'static str,
    pub(super) setting: String,
    pub(super) why: String,
}

/// What a search found.
#[derive(Serialize)]
pub(super) struct Found {
    pub(super) settings: Vec<String>,
    pub(super) point: Point,
    /// Combinations that were tried beside single settings.
    pub(super) tried: usize,
}

impl Report {
    pub(super) fn default_point(&self) -> &Point {
        &self.points[0]
    }
}
