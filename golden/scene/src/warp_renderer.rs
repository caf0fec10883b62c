//! A scene as the floating-point renderer of warped sequences.

use glam::DVec3;

use super::{Kind, Scene, SceneError};
use potamoi_base::camera::Camera;
use potamoi_base::mask::Mask;
use potamoi_base::picture::Picture;
use potamoi_fields as fields;
use potamoi_gaussians::Cloud;
use potamoi_splats as splats;
use potamoi_warp::{Renderer, Shaded, VOID_BELOW, WarpError};

/// Standard deviations at which an opaque Gaussian's alpha falls below 1/255:
/// `sqrt(2 ln 255)`, rounded up.
const REACH: f64 = 3.34;

impl Renderer for Scene {
    fn background(&self) -> [f32; 3] {
        self.background
    }

    fn bounds(&self) -> Option<[DVec3; 2]> {
        match self.model.kind() {
            Kind::Splats(cloud) => splat_bounds(cloud),
            Kind::Field(field) => Some(field.sampling().bounds),
        }
    }

    fn shade(&self, camera: &Camera, only: Option<&Mask>) -> Result<Shaded, WarpError> {
        let fail = |error: SceneError| WarpError::from(error);
        match self.model.kind() {
            Kind::Splats(cloud) => {
                let options = splats::FloatOptions {
                    background: self.background,
                    depth: true,
                    work: self.splat_work(),
                    ..splats::FloatOptions::default()
                };
                let cloud = self.seen_from(cloud, camera);
                let frame = match only {
                    None => splats::render_float(&cloud, camera, self.profile, &options),
                    Some(mask) => {
                        splats::render_masked(&cloud, camera, self.profile, &options, mask)
                    }
                };
                let frame = frame.map_err(|e| fail(e.into()))?;
                let depth = frame.depth.unwrap_or_default();
                Ok(shaded(frame.picture, &frame.transmittance, &depth))
            }
            Kind::Field(field) => {
                let options = self.float_options(field);
                let field = self.stopping(field);
                let frame = fields::render_masked(&field, camera, &options, only)
                    .map_err(|e| fail(e.into()))?;
                Ok(shaded(frame.picture, &frame.transmittance, &frame.depth))
            }
        }
    }
}

fn shaded(picture: Picture, transmittance: &[f64], depth: &[f64]) -> Shaded {
    let depth = transmittance.iter().zip(depth).map(|(left, depth)| {
        if 1.0 - left < VOID_BELOW {
            f32::INFINITY
        } else {
            *depth as f32
        }
    });
    Shaded {
        depth: depth.collect(),
        picture,
    }
}

/// Bounds of every Gaussian's visible extent; `None` without Gaussians or if one is not finite.
fn splat_bounds(cloud: &Cloud) -> Option<[DVec3; 2]> {
    let none = [DVec3::INFINITY, DVec3::NEG_INFINITY];
    let all = cloud.means().iter().zip(cloud.log_scales());
    let [low, high] = all.fold(none, |[low, high], (mean, scales)| {
        let widest = scales.iter().copied().fold(f32::NEG_INFINITY, f32::max);
        let reach = DVec3::splat(REACH * f64::from(widest).exp());
        let mean = DVec3::from(mean.map(f64::from));
        [low.min(mean - reach), high.max(mean + reach)]
    });
    (low.is_finite() && high.is_finite()).then_some([low, high])
}
