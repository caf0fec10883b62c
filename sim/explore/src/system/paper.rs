//! The paper's figures, for comparison.

use potamoi_system::system_model::{Frames, Outcome, Scenario};

/// Mean speed-up and energy saving over the scenario's baseline (paper, Sec. "Performance and
/// Energy"); bars by algorithm exist as pictures only.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Paper {
    /// Mean speed-up.
    pub speed_up: Option<f64>,
    /// Mean energy saving, as a factor.
    pub saving: Option<f64>,
    /// Loss of PSNR in dB against full frames of the algorithm: at most 1.0 for windows of 6, 1.4
    /// for 16 (paper, Sec. "Algorithm Quality").
    pub lost_db: Option<f64>,
}

impl Paper {
    /// The paper's figures for a variant, scenario and window; `None` where it has none.
    #[must_use]
    pub fn of(outcome: &Outcome, window: u32) -> Self {
        let (speed_up, saving) = match (outcome.scenario, outcome.variant.name) {
            (_, "baseline") => (Some(1.0), Some(1.0)),
            (Scenario::Local, "sparw") => (Some(8.1), Some(8.1)),
            // "An additional 1.1x speedup and 2.1x energy saving".
            (Scenario::Local, "sparw+fs") => (Some(8.1 * 1.1), Some(8.1 * 2.1)),
            (Scenario::Local, "potamoi") => (Some(53.1), Some(67.7)),
            (Scenario::Remote, "sparw") => (Some(2.1), None),
            (Scenario::Remote, "sparw+fs") => (Some(2.5), None),
            // "Transferring one frame consumes almost 3.0x lower energy than rendering".
            (Scenario::Remote, "potamoi") => (Some(7.5), Some(1.0 / 3.0)),
            _ => (None, None),
        };
        let lost_db = match (outcome.variant.frames, window) {
            (Frames::Warped, 6) => Some(1.0),
            (Frames::Warped, 16) => Some(1.4),
            _ => None,
        };
        Self {
            speed_up,
            saving,
            lost_db,
        }
    }
}

/// The paper's frame rate of an algorithm at 800 x 800 (Sec. "Introduction" and "Performance and
/// Energy"), rendered by the device itself. For two algorithms it timed the GPU alone, without the
/// array of its baseline and of this one.
#[must_use]
pub fn frames_per_second(outcome: &Outcome, algorithm: &str) -> Option<&'static str> {
    match (outcome.scenario, outcome.variant.name, algorithm) {
        (Scenario::Local, "baseline", "DirectVoxGO") => Some("0.8, GPU alone"),
        (Scenario::Local, "baseline", "3DGS") => Some("5, GPU alone"),
        (Scenario::Local, "baseline", "Instant-NGP") => Some("0.20"),
        (Scenario::Local, "potamoi", "Instant-NGP") => Some("9.33"),
        (Scenario::Local, "potamoi", "3DGS") => Some("over 1000"),
        _ => None,
    }
}

/// Mean speed-up of gathering on the unit (paper, Sec. "Feature Gathering").
const GATHERING: f64 = 64.1;
/// Speed-up of gathering on the unit for Instant-NGP (ibid.).
const GATHERING_NGP: f64 = 182.4;
/// Share of the memory energy saving that is due to less traffic (paper, Sec. "Memory Saving
/// Contribution").
pub const BY_TRAFFIC: f64 = 0.845;

/// The paper's speed-up of gathering for an algorithm, or on average, and which of the two it is.
#[must_use]
pub fn gathering_speed_up(algorithm: &str) -> (f64, &'static str) {
    match algorithm.starts_with("Instant-NGP") {
        true => (GATHERING_NGP, "of Instant-NGP"),
        false => (GATHERING, "on average"),
    }
}
