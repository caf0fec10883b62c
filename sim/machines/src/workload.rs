//! What machines do on a scene, and how it is timed.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Method of times and energies.
#[derive(
    Debug, Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, JsonSchema,
)]
#[serde(rename_all = "kebab-case")]
pub enum Fidelity {
    /// The largest demand of a frame on any resource or channel: a bound, without a schedule. For
    /// full frames alone.
    Demand,
    /// A schedule of the frames' blocks, with cycles by the cycle models.
    #[default]
    Schedule,
}

impl Fidelity {
    /// Both, the fastest first.
    pub const ALL: [Self; 2] = [Self::Demand, Self::Schedule];

    /// Its name.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Demand => "demand",
            Self::Schedule => "schedule",
        }
    }
}

/// What machines do on a scene.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Workload {
    /// Frames of the scene's path.
    pub frames: u32,
    /// Frames a second along a path that has no rate of its own.
    pub fps: f64,
    /// Method of the times.
    pub fidelity: Fidelity,
    /// Whether the quality of the picture is measured.
    pub quality: bool,
}

impl Default for Workload {
    fn default() -> Self {
        Self {
            frames: 8,
            fps: 30.0,
            fidelity: Fidelity::Schedule,
            quality: true,
        }
    }
}
