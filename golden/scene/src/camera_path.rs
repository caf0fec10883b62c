//! The path of a scene's camera: of a file, recorded, or the scene's own.

use potamoi_base::camera::Camera;

use super::{Scene, SceneError, orbit};

/// Speed of the default path around a model without a path of its own, in degrees a second.
const TURN: f64 = 36.0;
/// Maximum number of frames in a path that is not of a camera file.
const MAX_FRAMES: u32 = 100_000;

impl Scene {
    /// Cameras from which models are compared: the first of a camera file's or a recorded motion's (30 a
    /// second), else the scene's own and others around the model, at equal angles.
    ///
    /// # Errors
    /// The file or motion has fewer.
    pub fn standard_cameras(&self, count: u32) -> Result<Vec<Camera>, SceneError> {
        if !self.path.is_empty() || self.motion.is_some() {
            return self.path(30.0, count);
        }
        let middle = self.default_orbit().target;
        let step = 360.0 / f64::from(count.max(1));
        let all =
            (0..count).map(|k| orbit::turned(&self.camera, middle, self.up, step * f64::from(k)));
        Ok(all.collect())
    }

    /// The rate of the path in frames a second for a command's rate `fps`: that of a recorded motion
    /// if the description states one, else `fps`. `None` if the cameras are those of a file, which
    /// have no times.
    #[must_use]
    pub fn path_rate(&self, fps: f64) -> Option<f64> {
        let fixed = self.motion.as_ref().and_then(|motion| motion.rate_hz());
        self.path.is_empty().then(|| fixed.unwrap_or(fps))
    }

    /// Whether [`Scene::path`] depends on its rate.
    #[must_use]
    pub fn follows_fps(&self) -> bool {
        let fixed = self.motion.as_ref().is_some_and(|m| m.rate_hz().is_some());
        self.path.is_empty() && !fixed
    }

    /// Number of frames of the path at `fps` frames a second, where it ends: of cameras in a camera
    /// file, from the chosen one on, or of a recorded motion.
    #[must_use]
    pub fn path_length(&self, fps: f64) -> Option<u32> {
        if let Some(motion) = &self.motion {
            return Some(motion.frames(motion.rate_hz().unwrap_or(fps)));
        }
        (!self.path.is_empty()).then(|| self.path.len().try_into().unwrap_or(u32::MAX))
    }

    /// Whether the camera follows a recorded motion.
    #[must_use]
    pub const fn has_motion(&self) -> bool {
        self.motion.is_some()
    }

    /// The scene with its own path from the same first camera, instead of a recorded motion.
    #[must_use]
    pub fn without_motion(&self) -> Self {
        Self {
            motion: None,
            ..self.clone()
        }
    }

    /// The first `frames` cameras of a path through the scene.
    ///
    /// If the camera is from a file, the path continues in the file, and `fps` is not used. If it
    /// follows a recorded motion, that is resampled to the rate of the description, or to `fps`
    /// frames a second. Otherwise it is the built-in path at `fps` frames a second; a model without
    /// one is circled about the vertical axis through its middle at 36 degrees a second. Successive
    /// frames overlap almost completely at 30 frames a second, but not at 1.
    ///
    /// # Errors
    /// The rate is outside 0.001 to 1000, or there are more frames than the file or the motion has or
    /// more than 100,000.
    pub fn path(&self, fps: f64, frames: u32) -> Result<Vec<Camera>, SceneError> {
        let refuse = |field, value: String, expected: &str| {
            Err(SceneError::Value {
                scene: self.name.clone(),
                field,
                value,
                expected: expected.to_owned(),
            })
        };
        if !self.path.is_empty() {
            let found = self.path.get(..frames as usize);
            let expected = format!("at most {}, as its cameras have", self.path.len());
            let all = found.map(<[Camera]>::to_vec);
            return all.map_or_else(|| refuse("frames", frames.to_string(), &expected), Ok);
        }
        let rate = self.path_rate(fps).unwrap_or(fps);
        if !(1e-3..=1e3).contains(&rate) {
            return refuse("fps", rate.to_string(), "0.001 to 1000 frames a second");
        }
        if frames > MAX_FRAMES {
            let expected = format!("at most {MAX_FRAMES}");
            return refuse("frames", frames.to_string(), &expected);
        }
        if let Some(motion) = &self.motion {
            let most = motion.frames(rate);
            if frames > most {
                let expected =
                    format!("at most {most}, as its trajectory has at {rate} frames a second");
                return refuse("frames", frames.to_string(), &expected);
            }
            let all = (0..frames).map(|k| motion.camera(k, rate, &self.camera));
            return Ok(all.collect());
        }
        let Camera { width, height, .. } = self.camera;
        let middle = self.default_orbit().target;
        let at = |k| {
            let seconds = f64::from(k) / rate;
            match self.truth {
                Some(analytic) => analytic.camera(seconds, width, height),
                None => orbit::turned(&self.camera, middle, self.up, TURN * seconds),
            }
        };
        Ok((0..frames).map(at).collect())
    }
}
