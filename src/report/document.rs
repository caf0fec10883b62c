//! The document of a run, which the page is made from and has in it.

use std::collections::BTreeMap;

use potamoi_analysis::hard_cases::{HardCase, SceneCheck};
use potamoi_explore::accuracy::{ImageQuality, Reference, Sweep};
use potamoi_explore::effects::Effects;
use potamoi_machines::Row;
use potamoi_system::system_model::{Area, AtBounds, Clock};
use schemars::JsonSchema;
use serde::Serialize;
use serde_json::Value;

/// Version of the document.
pub(super) const FORMAT_VERSION: u32 = 1;

#[derive(Serialize, JsonSchema)]
pub(super) struct Document {
    pub(super) format_version: u32,
    pub(super) command: &'static str,
    /// Version of the program.
    pub(super) version: &'static str,
    pub(super) libraries: Vec<LibraryUsed>,
    pub(super) workload: potamoi_machines::Workload,
    pub(super) scenes: Vec<SceneFound>,
    /// Specifications of the plots, by name.
    pub(super) plots: BTreeMap<String, Value>,
    pub(super) provenance: Vec<Origin>,
    /// Items that scenes' files leave open.
    pub(super) not_checked: Vec<String>,
}

/// A library that the page holds.
#[derive(Serialize, JsonSchema)]
pub(super) struct LibraryUsed {
    pub(super) name: &'static str,
    pub(super) version: &'static str,
    pub(super) licence: &'static str,
    pub(super) sha256: &'static str,
}

/// Where a figure comes from.
#[derive(Serialize, JsonSchema)]
pub(super) struct Origin {
    pub(super) figure: &'static str,
    /// Measured, cycle model, synthesis, fitted, published or assumed.
    pub(super) origin: String,
    pub(super) how: String,
    /// Command that gives it by itself; none where there is none.
    pub(super) command: Option<String>,
}

#[derive(Serialize, JsonSchema)]
pub(super) struct SceneFound {
    pub(super) name: String,
    pub(super) algorithm: &'static str,
    pub(super) size: [u32; 2],
    /// Hash of all that its picture depends on.
    pub(super) hash: String,
    /// What pictures are compared with.
    pub(super) reference: Reference,
    pub(super) reference_picture: Image,
    pub(super) machines: Vec<MachineFound>,
}

/// A picture that the page holds.
#[derive(Clone, Serialize, JsonSchema)]
pub(super) struct Image {
    /// Its name among the page's pictures.
    pub(super) id: String,
    /// Hash of the PNG.
    pub(super) hash: String,
}

/// A value, or why there is none.
#[derive(Serialize, JsonSchema)]
#[serde(untagged)]
pub(super) enum Found<T> {
    Known(T),
    Unknown { unknown: String },
}

impl<T> Found<T> {
    pub(super) fn unknown(why: impl Into<String>) -> Self {
        let unknown = why.into();
        Self::Unknown { unknown }
    }

    /// Why there is none.
    pub(super) fn why(&self) -> Option<&str> {
        match self {
            Self::Known(_) => None,
            Self::Unknown { unknown } => Some(unknown),
        }
    }
}

#[derive(Serialize, JsonSchema)]
pub(super) struct MachineFound {
    pub(super) machine: String,
    /// Figures, or the reason of a refusal.
    pub(super) figures: Row,
    /// All that is found on a machine that renders the scene.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) more: Option<More>,
}

#[derive(Serialize, JsonSchema)]
pub(super) struct More {
    pub(super) preset: Option<&'static str>,
    /// Hash of the configuration, 12 hexadecimal digits.
    pub(super) configuration: String,
    pub(super) clock: Clock,
    pub(super) area: Area,
    /// Source of the energies.
    pub(super) energy_origin: String,
    pub(super) pictures: Pictures,
    pub(super) proof: Found<Proved>,
    pub(super) variants: Vec<VariantFound>,
    pub(super) accuracy: Found<SweepFound>,
    pub(super) effects: Found<Effects>,
    pub(super) hard_cases: HardCases,
    pub(super) paper: Vec<BesidePaper>,
    /// Number of the paper on arXiv.
    pub(super) arxiv: &'static str,
}

#[derive(Serialize, JsonSchema)]
pub(super) struct Pictures {
    pub(super) float: Image,
    pub(super) hardware: Image,
    pub(super) error: Image,
    /// Difference of a channel that the scale ends at, peak 1.
    pub(super) scale: f64,
    /// Largest difference of a channel, peak 1.
    pub(super) largest: f64,
    /// The hardware's picture beside the reference, and beside floating point.
    pub(super) beside_reference: ImageQuality,
    pub(super) beside_float: ImageQuality,
}

/// Units whose Verilog was compared with the golden models.
#[derive(Serialize, JsonSchema)]
pub(super) struct Proved {
    pub(super) units: Vec<UnitProved>,
    /// What agreement does not cover.
    pub(super) not_checked: Vec<String>,
}

#[derive(Serialize, JsonSchema)]
pub(super) struct UnitProved {
    pub(super) unit: &'static str,
    pub(super) of: &'static str,
    pub(super) compared: u64,
    pub(super) all: u64,
    /// `compared` over `all`, 0 to 1; none where there is no work.
    pub(super) share: Option<f64>,
}

/// A variant of the system.
#[derive(Serialize, JsonSchema)]
pub(super) struct VariantFound {
    pub(super) name: &'static str,
    pub(super) frames_per_second: AtBounds<f64>,
    /// Milliseconds of a frame.
    pub(super) frame_ms: AtBounds<f64>,
    pub(super) mj: Option<AtBounds<f64>>,
    /// Loss of the variant's frames against full ones in floating point, as PSNR.
    pub(super) full_db: Option<f64>,
    pub(super) speed_up: AtBounds<f64>,
    pub(super) saving: Option<AtBounds<f64>>,
    /// Milliseconds of work a frame by resource, and millijoules by part, each the geometric mean of
    /// both bounds.
    pub(super) work_ms: Vec<(&'static str, f64)>,
    pub(super) parts_mj: Vec<(&'static str, f64)>,
    pub(super) if_gpu_were_free: IfFree,
}

/// The same with a GPU that takes no time and no energy.
#[derive(Serialize, JsonSchema)]
pub(super) struct IfFree {
    pub(super) frames_per_second: AtBounds<f64>,
    pub(super) frame_ms: AtBounds<f64>,
    pub(super) mj: Option<AtBounds<f64>>,
    pub(super) work_ms: Vec<(&'static str, f64)>,
    pub(super) parts_mj: Vec<(&'static str, f64)>,
}

/// A sweep without its wall times.
#[derive(Serialize, JsonSchema)]
pub(super) struct SweepFound {
    #[serde(flatten)]
    pub(super) sweep: Sweep,
    /// Microseconds of a frame at each point.
    pub(super) frame_us: Vec<f64>,
    /// Names of its plots: beside the truth, and the converged picture.
    pub(super) plots: Vec<(&'static str, String)>,
}

/// A figure of the paper beside ours.
#[derive(Serialize, JsonSchema)]
pub(super) struct BesidePaper {
    pub(super) figure: String,
    pub(super) unit: &'static str,
    pub(super) paper: String,
    pub(super) ours: Found<AtBounds<f64>>,
    pub(super) reason: &'static str,
}

/// Hard cases with a configuration's formats, and on the scene.
#[derive(Serialize, JsonSchema)]
pub(super) struct HardCases {
    pub(super) cases: Vec<HardCase>,
    /// Checks of the pictures of hard scenes.
    pub(super) pictures: Vec<SceneCheck>,
    /// Why there are none.
    pub(super) no_pictures: Option<String>,
    /// Checks of the scene itself.
    pub(super) scene: Vec<SceneCheck>,
    /// Why there are none.
    pub(super) no_scene: Option<String>,
}
