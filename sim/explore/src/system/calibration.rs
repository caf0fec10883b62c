//! The factors of the GPU: found from what the paper timed.

use potamoi_system::soc::work::FrameWork;
use potamoi_system::soc::{Gpu, GpuOnlyTime, Memory, System, gpu_only};
use serde::Serialize;

use crate::{ExploreError, Setup};

/// Frames a second at 800 x 800 on the mobile GPU alone (paper, Sec. "Introduction").
pub const TIMED: [(&str, f64); 2] = [("DirectVoxGO", 0.8), ("3DGS", 5.0)];
/// Points that the mobile GPU warps, and the nanoseconds that it stays below (paper, Sec.
/// "Basic Algorithm"): taken as those that it needs.
pub const WARPED: (u64, f64) = (1_000_000, 1e6);
/// Pixels a side of what the paper timed.
pub const SIDE: u32 = 800;
/// Halvings of the interval in which a factor lies: more than its digits.
const HALVINGS: u32 = 60;

/// A scene's frame on the GPU alone.
#[derive(Debug, Clone, Serialize)]
pub struct Timed {
    /// As the scene was asked for.
    pub scene: String,
    /// The model's algorithm.
    pub algorithm: &'static str,
    /// Pixels of a row and rows.
    pub size: [u32; 2],
    /// Gaussians of the model; 0 of fields.
    pub gaussians: u64,
    /// Bytes of the model.
    pub model_bytes: u64,
    #[serde(skip)]
    work: FrameWork,
    /// As the GPU would do it at its best.
    pub best: GpuOnlyTime,
    /// As its programs do it by the factors that were found; by the system's where none was.
    pub by_factor: GpuOnlyTime,
}

impl Timed {
    /// Of the frame that a setup's camera sees, at the GPU's best.
    ///
    /// # Errors
    /// As [`Setup::frame`].
    pub fn of(name: &str, setup: &Setup) -> Result<Self, ExploreError> {
        let (system, camera) = (&setup.system, setup.scene.camera());
        let work = setup.frame()?;
        let best = gpu_only(
            &system.gpu.reaching(1.0),
            &system.instructions,
            setup.memory(),
            &work,
        );
        Ok(Self {
            scene: name.to_owned(),
            algorithm: setup.scene.model().algorithm(),
            size: [camera.width, camera.height],
            gaussians: work.gaussians,
            model_bytes: work.reads.model_bytes,
            best,
            by_factor: best,
            work,
        })
    }
}

/// What the GPU's programs reach of its best, 0 to 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GpuFactors {
    /// Of fields; none where no scene of theirs was timed, or all take longer at the GPU's best.
    pub fields: Option<f64>,
    /// Of splats, likewise.
    pub splats: Option<f64>,
    /// Of warping and scaling pictures.
    pub pictures: f64,
}

impl GpuFactors {
    /// The factors by which scenes take on average what the paper timed; sets their
    /// [`Timed::by_factor`].
    #[must_use]
    pub fn find(system: &System, scenes: &mut [Timed]) -> Self {
        let best = system.gpu.reaching(1.0);
        let memory = Memory::lpddr3(system.memory_channels);
        let time =
            |gpu: &Gpu, timed: &Timed| gpu_only(gpu, &system.instructions, &memory, &timed.work);
        let [fields, splats] = TIMED.map(|(algorithm, per_second)| {
            let own: Vec<&Timed> = scenes.iter().filter(|t| t.algorithm == algorithm).collect();
            factor(per_second, |efficiency| {
                let gpu = best.reaching(efficiency);
                let all = own.iter().map(|timed| time(&gpu, timed).total_ns());
                all.sum::<f64>() / own.len() as f64
            })
            .filter(|_| !own.is_empty())
        });
        let gpu = Gpu {
            fields_efficiency: fields.unwrap_or(system.gpu.fields_efficiency),
            splats_efficiency: splats.unwrap_or(system.gpu.splats_efficiency),
            ..best
        };
        for timed in scenes {
            timed.by_factor = time(&gpu, timed);
        }
        Self {
            fields,
            splats,
            pictures: system.gpu.efficiency_that_warps(WARPED.0, WARPED.1),
        }
    }
}

/// The share of the best at which frames take so many nanoseconds as come to a rate; none above 1.
fn factor(frames_per_second: f64, nanoseconds: impl Fn(f64) -> f64) -> Option<f64> {
    // The more it reaches, the less time it takes.
    let (mut low, mut high) = (1e-6f64, 1.0);
    for _ in 0..HALVINGS {
        let middle = (low * high).sqrt();
        match nanoseconds(middle) * frames_per_second > 1e9 {
            true => low = middle,
            false => high = middle,
        }
    }
    (high < 1.0).then_some(high)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Time of 0.2 s at the best, in inverse proportion to the share: a frame a second at a fifth,
    /// and no share is fast enough for six.
    #[test]
    fn a_factor_is_where_the_time_is_the_rates() {
        let time = |efficiency: f64| 0.2e9 / efficiency;
        let Some(found) = factor(1.0, time) else {
            unreachable!("a fifth is a share");
        };
        assert!((found - 0.2).abs() < 1e-12, "{found}");
        assert_eq!(factor(6.0, time), None);
    }
}
