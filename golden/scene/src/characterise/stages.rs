//! Time of the paper's three stages in the float renderer.

use std::time::{Duration, Instant};

use glam::DVec3;
use schemars::JsonSchema;
use serde::Serialize;

use potamoi_base::camera::Camera;
use potamoi_fields::{RayLengths, RayStages};
use potamoi_gaussians::Cloud;
use potamoi_splats::{FloatOptions, Profile, RenderError, View, render_view};

/// Maximum number of rays that are timed, spread over the frame.
const RAYS: u32 = 5_000;

/// Time of the stages in seconds, measured on this machine. For a field: of one thread, on rays
/// spread over the frame. For splats: of all threads, on the whole frame, with gathering and
/// computation of a pixel as one stage.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct Stages {
    /// Locating samples; for splats projection, sorting and tiling.
    pub indexing: f64,
    /// Reading and interpolating vertices.
    pub gathering: Option<f64>,
    /// Feature computation, including compositing.
    pub computation: f64,
}

impl Stages {
    /// Share of each stage in the total.
    #[must_use]
    pub fn shares(&self) -> [Option<f64>; 3] {
        let total = self.indexing + self.gathering.unwrap_or(0.0) + self.computation;
        let share = |part: f64| part / total.max(f64::MIN_POSITIVE);
        [
            Some(share(self.indexing)),
            self.gathering.map(share),
            Some(share(self.computation)),
        ]
    }
}

/// Times a field on rays of known lengths.
#[must_use]
pub fn field_stages(stops: &RayLengths<'_>) -> Stages {
    let camera = stops.camera();
    let pixels = camera.width.saturating_mul(camera.height);
    // An odd step meets every column.
    let step = (pixels / RAYS).max(1) | 1;
    let mut rays = RayStages::new(stops);
    let mut spent = [Duration::ZERO; 3];
    let mut sum = DVec3::ZERO;
    for i in (0..pixels).step_by(step as usize) {
        let pixel = [i % camera.width, i / camera.width];
        rays.aim(pixel);
        let start = Instant::now();
        rays.index();
        let indexed = Instant::now();
        rays.gather();
        let gathered = Instant::now();
        sum += rays.compute();
        let done = Instant::now();
        let parts = [indexed - start, gathered - indexed, done - gathered];
        for (to, part) in spent.iter_mut().zip(parts) {
            *to += part;
        }
    }
    // Nothing of it may be left out.
    std::hint::black_box(sum);
    let [indexing, gathering, computation] = spent.map(|d| d.as_secs_f64());
    Stages {
        indexing,
        gathering: Some(gathering),
        computation,
    }
}

/// Times splats.
///
/// # Errors
/// The camera is invalid.
pub fn splat_stages(
    cloud: &Cloud,
    camera: &Camera,
    profile: Profile,
) -> Result<Stages, RenderError> {
    let start = Instant::now();
    let view = View::new(cloud, camera, profile)?;
    let indexed = Instant::now();
    std::hint::black_box(render_view(&view, &FloatOptions::default())?);
    Ok(Stages {
        indexing: (indexed - start).as_secs_f64(),
        gathering: None,
        computation: indexed.elapsed().as_secs_f64(),
    })
}
