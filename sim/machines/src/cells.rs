//! Figures as cells of a table: one list of columns for CSV, fronts and sweeps.

use std::fmt;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::Figures;

/// A cell.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum Cell {
    /// Not known, or not for this row.
    Unknown,
    /// A number, in the unit of its column.
    Number(f64),
    /// A word.
    Text(String),
}

impl Cell {
    /// The number, if it is one.
    #[must_use]
    pub const fn number(&self) -> Option<f64> {
        match self {
            Self::Number(own) => Some(*own),
            _ => None,
        }
    }
}

impl From<Option<f64>> for Cell {
    fn from(own: Option<f64>) -> Self {
        own.map_or(Self::Unknown, Self::Number)
    }
}

impl From<f64> for Cell {
    fn from(own: f64) -> Self {
        Self::Number(own)
    }
}

impl From<u32> for Cell {
    fn from(own: u32) -> Self {
        Self::Number(own.into())
    }
}

impl From<&str> for Cell {
    fn from(own: &str) -> Self {
        Self::Text(own.to_owned())
    }
}

impl From<Option<&str>> for Cell {
    fn from(own: Option<&str>) -> Self {
        own.map_or(Self::Unknown, Self::from)
    }
}

impl fmt::Display for Cell {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unknown => Ok(()),
            Self::Number(own) => own.fmt(f),
            Self::Text(own) => own.fmt(f),
        }
    }
}

/// A column of figures.
pub struct Column {
    /// Its name, with the unit where it has one.
    pub name: &'static str,
    /// Its cell.
    pub of: fn(&Figures) -> Cell,
}

const fn column(name: &'static str, of: fn(&Figures) -> Cell) -> Column {
    Column { name, of }
}

/// Columns of figures. `_low` and `_high` are the bounds of the GPU's kernels; without them a figure is
/// their geometric mean.
pub const COLUMNS: [Column; 39] = [
    column("machine", |own| own.machine.as_str().into()),
    column("preset", |own| own.preset.into()),
    column("scene", |own| own.scene.as_str().into()),
    column("algorithm", |own| own.algorithm.as_str().into()),
    column("width", |own| own.size[0].into()),
    column("height", |own| own.size[1].into()),
    column("frames", |own| own.frames.into()),
    column("variant", |own| own.variant.into()),
    column("gpu", |own| own.gpu.as_str().into()),
    column("memory", |own| own.memory.0.as_str().into()),
    column("memory_channels", |own| own.memory.1.into()),
    column("fidelity", |own| own.fidelity.name().into()),
    column("clock_ghz", |own| own.clock_ghz.into()),
    column("clock_origin", |own| own.clock_origin.word().into()),
    column("reached_ghz", |own| own.reached_ghz.into()),
    column("clock_bound_by", |own| own.clock_bound_by.as_deref().into()),
    column("fps", |own| own.frames_per_second.mid().into()),
    column("fps_low", |own| own.frames_per_second.low().into()),
    column("fps_high", |own| own.frames_per_second.high().into()),
    column("frame_ms", |own| own.frame_ms().mid().into()),
    column("free_units_fps", |own| {
        own.free_units_frames_per_second.mid().into()
    }),
    column("gpu_alone_fps", |own| {
        own.gpu_alone_frames_per_second.mid().into()
    }),
    column("gpu_alone_fps_low", |own| {
        own.gpu_alone_frames_per_second.low().into()
    }),
    column("gpu_alone_fps_high", |own| {
        own.gpu_alone_frames_per_second.high().into()
    }),
    column("bottleneck", |own| own.bottleneck.max.0.into()),
    column("bottleneck_share", |own| own.bottleneck.max.1.into()),
    column("bottleneck_not_overlapped", |own| {
        own.bottleneck.sum.0.into()
    }),
    column("mj", |own| own.mj.map(|mj| mj.mid()).into()),
    column("mj_low", |own| own.mj.map(|mj| mj.low()).into()),
    column("mj_high", |own| own.mj.map(|mj| mj.high()).into()),
    column("gpu_mj", |own| own.gpu_mj.mid().into()),
    column("accelerator_mj", |own| {
        own.accelerator_mj.map(|mj| mj.mid()).into()
    }),
    column("memory_mj", |own| own.memory_mj.mid().into()),
    column("mj_ms", |own| own.energy_delay().into()),
    column("units_mm2", |own| own.units_mm2.into()),
    column("mm2", |own| own.mm2.into()),
    column("psnr_db", |own| own.quality.and_then(|own| own.db).into()),
    column("psnr_beside", |own| {
        own.quality.map(|own| own.beside.name()).into()
    }),
    column("unknown", |own| {
        let each = own
            .unknown
            .iter()
            .map(|of| format!("{}: {}", of.block, of.why));
        let all: Vec<String> = each.collect();
        match all.is_empty() {
            true => Cell::Unknown,
            false => Cell::Text(all.join("; ")),
        }
    }),
];
