//! Calibration of GPU efficiencies to the times in the paper.

use potamoi_system::system_model::work::FrameWork;
use potamoi_system::system_model::{Gpu, GpuOnlyTime, Memory, System, gpu_only};
use serde::Serialize;

use crate::{ExploreError, Setup};

/// Frame rates at 800 x 800 on the mobile GPU alone (paper, Sec. "Introduction").
pub const TIMED: [(&str, f64); 2] = [("DirectVoxGO", 0.8), ("3DGS", 5.0)];
/// Points warped on the mobile GPU, and the upper bound of their nanoseconds (paper, Sec. "Basic
/// Algorithm"), taken as the time itself.
pub const WARPED: (u64, f64) = (1_000_000, 1e6);
/// Width and height in pixels of the paper's timed frames.
pub const SIDE: u32 = 800;
/// Bisection steps for an efficiency: more than its digits.
const HALVINGS: u32 = 60;

/// Times of a scene's frame on the GPU alone.
#[derive(Debug, Clone, Serialize)]
pub struct Timed {
    /// Name of the scene, as requested.
    pub scene: String,
    /// The model's algorithm.
    pub algorithm: &'static str,
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Gaussians of the model; 0 for fields.
    pub gaussians: u64,
    /// Bytes of the model.
    pub model_bytes: u64,
    #[serde(skip)]
    work: FrameWork,
    /// Times at peak rates.
    pub best: GpuOnlyTime,
    /// Times at the calibrated efficiencies, or the system's where none was found.
    pub by_factor: GpuOnlyTime,
}

impl Timed {
    /// Times the frame that a setup's camera sees at the GPU's peak rates.
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

/// Efficiencies of GPU programs, as shares of peak from 0 to 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GpuFactors {
    /// Field programs; `None` where no field scene was timed, or all exceed the paper's time even
    /// at peak.
    pub fields: Option<f64>,
    /// Splat programs; `None` in the same cases.
    pub splats: Option<f64>,
    /// Warping and upscaling.
    pub pictures: f64,
}

impl GpuFactors {
    /// Finds the efficiencies at which scenes take the paper's times on average, and sets their
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

/// Efficiency at which frames reach a rate; `None` if it would exceed 1.
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

    /// 0.2 s at peak, inversely proportional to the efficiency: a frame a second at 0.2, and no
    /// efficiency gives six.
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
