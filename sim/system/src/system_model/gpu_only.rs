//! A frame on a GPU alone, with its own memory: our fused program, and the published one.

use potamoi_gpu::programs::{DirectVoxGo, Program as _, TorchNgp, TorchTensorf};
use potamoi_gpu::{Device, Frame, Launch, Overlap};
use schemars::JsonSchema;
use serde::Serialize;

use super::at_bounds::AtBounds;
use super::kernels;
use super::work::{FrameWork, PathWork};

/// Likely counts of `sim/gpu/rows` where this crate counts none. Assumed.
const ROUNDS: f64 = 20.0;
/// Lines and sectors of requests to tables of small entries, and to channel-major grids.
const HASHED: [f64; 2] = [8.0, 9.5];
const CHANNEL_MAJOR: [f64; 2] = [13.5, 14.0];

/// Frames of a path by one program on a GPU alone.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct Alone {
    /// The program.
    pub program: &'static str,
    /// Nanoseconds of a frame, the mean over the path.
    pub frame_ns: AtBounds<f64>,
}

/// A path on the system's GPU without accelerator, with the memory that the device has itself.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct GpuOnly {
    /// Our own fused program: the conservative baseline.
    pub fused: Alone,
    /// The published program; none where there is none in `potamoi-gpu`.
    pub published: Option<Alone>,
}

impl GpuOnly {
    /// Models the full frames of a path.
    #[must_use]
    pub fn of(device: &Device, path: &PathWork) -> Self {
        let works = || (0..path.targets.len()).map(|number| path.full(number));
        let mean = |program, of: &dyn Fn(&FrameWork) -> Frame| {
            let mut frame_ns = AtBounds::default();
            // Frames of a window have the same work.
            let mut last: Option<(&FrameWork, AtBounds<f64>)> = None;
            for work in works() {
                let own = match last {
                    Some((known, own)) if std::ptr::eq(known, work) => own,
                    _ => at_bounds(device, &of(work)),
                };
                last = Some((work, own));
                frame_ns.max += own.max / path.targets.len() as f64;
                frame_ns.sum += own.sum / path.targets.len() as f64;
            }
            Alone { program, frame_ns }
        };
        let published = published(&path.algorithm);
        Self {
            fused: mean("own fused program", &fused),
            published: published.map(|(name, counts)| mean(name, &|work| counts(work, device))),
        }
    }
}

/// Nanoseconds of a frame on a device with its own memory, by our fused program.
#[must_use]
pub fn gpu_only(device: &Device, work: &FrameWork) -> AtBounds<f64> {
    at_bounds(device, &fused(work))
}

/// The same at one bound.
pub(super) fn gpu_only_at(device: &Device, work: &FrameWork, overlap: Overlap) -> f64 {
    fused(work).time(device, overlap, None).seconds * 1e9
}

fn at_bounds(device: &Device, frame: &Frame) -> AtBounds<f64> {
    let ns = |overlap| frame.time(device, overlap, None).seconds * 1e9;
    AtBounds {
        max: ns(Overlap::Whole),
        sum: ns(Overlap::None),
    }
}

/// All kernels of a frame by our own program.
fn fused(work: &FrameWork) -> Frame {
    let mut all = kernels::indexing(work).kernels;
    // Records of splats are read by the kernel that blends them.
    if work.gaussians == 0 || kernels::has_field_of_colours(work) {
        all.extend(kernels::gathering(work).kernels);
    }
    all.extend(kernels::computation(work));
    Frame {
        launch: Launch::Native,
        kernels: all,
    }
}

type Published = fn(&FrameWork, &Device) -> Frame;

/// The published program of an algorithm, at a frame's counts.
fn published(algorithm: &str) -> Option<(&'static str, Published)> {
    match algorithm {
        "3DGS" => Some(("3DGS, the paper's viewer", |work, device| {
            kernels::published_splatting(work).frame(device)
        })),
        "DirectVoxGO" => Some(("DirectVoxGO, eager", |work, device| {
            direct_voxgo(work).frame(device)
        })),
        "TensoRF" => Some(("torch-ngp, TensoRF", |work, device| {
            tensorf(work).frame(device)
        })),
        own if own.starts_with("Instant-NGP") => {
            Some(("torch-ngp, hash grid of 2^19 entries", |work, device| {
                torch_ngp(work).frame(device)
            }))
        }
        _ => None,
    }
}

/// Every sample that is gathered here survives all tests there.
fn direct_voxgo(work: &FrameWork) -> DirectVoxGo {
    const CHANNELS: f64 = 12.0;
    let gathered = kernels::samples_gathered(work);
    let [lines, sectors] = CHANNEL_MAJOR;
    DirectVoxGo {
        rays: work.pixels as f64,
        in_box: work.samples as f64,
        in_mask: gathered,
        by_alpha: gathered,
        by_weight: gathered,
        voxels: work.reads.model_bytes as f64 / (2.0 * (CHANNELS + 1.0)),
        channels: CHANNELS,
        lines,
        sectors,
    }
}

fn torch_ngp(work: &FrameWork) -> TorchNgp {
    let [lines, sectors] = HASHED;
    TorchNgp {
        rays: work.pixels as f64,
        slots: kernels::samples_gathered(work),
        looks: work.samples as f64,
        rounds: ROUNDS,
        lines,
        sectors,
        parameters: work.reads.model_bytes as f64 / 2.0,
    }
}

fn tensorf(work: &FrameWork) -> TorchTensorf {
    let [lines, sectors] = CHANNEL_MAJOR;
    TorchTensorf {
        rays: work.pixels as f64,
        slots: kernels::samples_gathered(work),
        looks: work.samples as f64,
        rounds: ROUNDS,
        lines,
        sectors,
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use potamoi_gpu::rows::{At, Row};

    use super::*;

    /// The counts that are taken from the measured rows are those rows' likely ones.
    #[test]
    fn assumed_counts_are_those_of_the_rows() {
        let rows = Row::all().unwrap();
        let of = |id: &str| rows.iter().find(|row| row.id == id).unwrap().at(At::Mid);
        for (id, [lines, sectors]) in [
            ("2080ti-torch-ngp-lego", HASHED),
            ("v100-torch-tensorf-lego", CHANNEL_MAJOR),
        ] {
            let counts = of(id);
            let found = ["rounds", "lines", "sectors"].map(|name| counts[name]);
            assert_eq!(found, [ROUNDS, lines, sectors], "{id}");
        }
    }
}
