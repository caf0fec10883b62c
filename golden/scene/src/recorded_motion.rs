//! Placing a recorded motion in a scene.

use std::ffi::OsStr;
use std::path::Path;

use glam::DAffine3;
use potamoi_base::camera::Camera;
use potamoi_base::file_keys::Notes;
use potamoi_formats::document::{self, Value};

use super::description::TrajectoryDescription;
use super::trajectory::{self, Dialect, FileFacts, GAP, Motion, Placement, Span, Trajectory};
use super::{Scene, SceneError, camera_file, transforms};

/// Of the scene's radius, the farthest that a motion of no stated scale leaves its first place.
const SHARE: f64 = 0.5;
/// The largest scale, and the largest distance of the motion from its first place in scene units.
const FAR: f64 = 1e9;
/// Where a motion begins unless given.
const FIRST_VIEW: &str = "first-view";
/// A span may be longer than the trajectory by this share, for rounding.
const ROUNDING: f64 = 1e-9;
/// The largest camera file, in bytes, that is searched for its kind.
const LIMIT: u64 = 1 << 26;

impl Scene {
    /// The camera follows the motion that a description names.
    pub(super) fn follow_motion(
        &mut self,
        own: &TrajectoryDescription,
        folder: &Path,
    ) -> Result<(), SceneError> {
        let format = own.format.as_deref();
        let dialect = format.map(|name| {
            Dialect::named(name).ok_or_else(|| {
                let all = Dialect::ALL.map(Dialect::name).join(", ");
                self.value("camera.format", name.to_owned(), &format!("one of {all}"))
            })
        });
        let facts = FileFacts {
            dialect: dialect.transpose()?,
            times: own.times.as_ref().map(|times| folder.join(times)),
            file_hz: own.file_hz,
            t_bs: own.t_bs,
        };
        let path = folder.join(&own.path);
        let mut notes = Notes::default();
        let trajectory = trajectory::read(&path, &facts, &mut notes)?;
        let span = self.span(own, &trajectory)?;
        say_gaps(&trajectory, span, &mut notes);
        if let Some(rate) = own.rate_hz.filter(|r| !(1e-3..=1e3).contains(r)) {
            let expected = "0.001 to 1000 frames a second";
            return Err(self.value("camera.rate_hz", rate.to_string(), expected));
        }
        self.anchor(own, folder)?;
        let placement = Placement {
            anchor: self.camera.world_to_camera,
            scale: self.scale(own, &trajectory, span, &mut notes)?,
        };
        self.notes.extend(notes.of_file(&path));
        self.motion = Motion::new(trajectory, span, placement, own.rate_hz);
        self.set_size(own.width, own.height)
    }

    /// The part of the trajectory that is used.
    fn span(
        &self,
        own: &TrajectoryDescription,
        trajectory: &Trajectory,
    ) -> Result<Span, SceneError> {
        let all = trajectory.seconds();
        let from = own.start_s.unwrap_or(0.0);
        if !(0.0..all).contains(&from) {
            let expected = format!("0 to below {all}, the seconds of the trajectory");
            return Err(self.value("camera.start_s", from.to_string(), &expected));
        }
        let Some(duration) = own.duration_s else {
            return Ok(Span {
                from,
                to: all,
                closed: true,
            });
        };
        let most = (all - from) * (1.0 + ROUNDING);
        if !(duration > 0.0 && duration <= most) {
            let expected = format!("above 0 to {}, what is left of the trajectory", all - from);
            return Err(self.value("camera.duration_s", duration.to_string(), &expected));
        }
        Ok(Span {
            from,
            to: (from + duration).min(all),
            closed: false,
        })
    }

    /// Sets the camera to the one at which the motion begins.
    fn anchor(&mut self, own: &TrajectoryDescription, folder: &Path) -> Result<(), SceneError> {
        let Some(at) = own.at.as_deref().filter(|at| *at != OsStr::new(FIRST_VIEW)) else {
            return match own.index {
                Some(index) => {
                    let expected = "it left out, unless camera.at names a camera file";
                    Err(self.value("camera.index", index.to_string(), expected))
                }
                None => Ok(()),
            };
        };
        let path = folder.join(at);
        let mut notes = Notes::default();
        let cameras: Vec<Camera> = match is_transforms(&path) {
            true => {
                let frames = transforms::read(&path, &mut notes)?;
                frames.iter().map(|frame| frame.camera).collect()
            }
            false => {
                let all = camera_file::read(&path, &mut notes)?;
                all.iter().map(|own| own.camera).collect()
            }
        };
        self.notes.extend(notes.of_file(&path));
        let index = own.index.unwrap_or(0);
        let Some(camera) = cameras.get(index) else {
            let expected = camera_file::indices(cameras.len(), &path);
            return Err(self.value("camera.index", index.to_string(), &expected));
        };
        // Cameras are of the file's world, the model from its own origin on.
        let there = DAffine3::from_translation(self.origin);
        self.camera = Camera {
            world_to_camera: camera.world_to_camera * there,
            ..*camera
        };
        Ok(())
    }

    /// Scene units a unit of the file.
    fn scale(
        &self,
        own: &TrajectoryDescription,
        trajectory: &Trajectory,
        span: Span,
        notes: &mut Notes,
    ) -> Result<f64, SceneError> {
        let extent = trajectory.extent([span.from, span.to]);
        let radius = self.radius();
        let (scale, why) = match own.scale {
            Some(scale) => (scale, None),
            None if extent > 0.0 => {
                let why = format!(
                    "the camera moves {extent:.4} units of the file away from its first place, \
                     {SHARE} of the scene's radius of {radius:.4}"
                );
                (SHARE * radius / extent, Some(why))
            }
            None => (1.0, Some("the camera does not move".to_owned())),
        };
        let fits = scale > 0.0 && scale <= FAR;
        match why {
            None if !fits => {
                let expected = "above 0 to 1e9 scene units a unit of the file";
                return Err(self.value("camera.scale", scale.to_string(), expected));
            }
            None => {}
            Some(why) => notes.assume(format!("scale: {scale:.6} ({why})")),
        }
        let far = scale * extent;
        if !(fits && far <= FAR) {
            let expected =
                "one that moves the camera by at most 1e9 scene units; give camera.scale";
            return Err(self.value("camera.scale", format!("{scale:e}"), expected));
        }
        Ok(scale)
    }

    /// The radius of what a default view frames.
    fn radius(&self) -> f64 {
        let orbit = self.default_orbit();
        orbit.distance * (orbit.fov / 2.0).to_radians().sin()
    }
}

/// Names the gaps that interpolation bridges.
fn say_gaps(trajectory: &Trajectory, span: Span, notes: &mut Notes) {
    let gaps = trajectory.gaps([span.from, span.to]);
    let Some((at, step)) = gaps.iter().copied().max_by(|a, b| a.1.total_cmp(&b.1)) else {
        return;
    };
    notes.assume(format!(
        "motion is even across gaps: {} steps of more than {GAP} times the median of {:.4} s, the \
         longest of {step:.3} s at {at:.3} s",
        gaps.len(),
        trajectory.usual_step()
    ));
}

/// Whether a camera file is a `transforms.json`. What cannot be read is told by its reader.
fn is_transforms(path: &Path) -> bool {
    let bytes = potamoi_base::files::read(path, LIMIT).ok().flatten();
    let document = bytes.and_then(|bytes| document::json(&bytes).ok());
    matches!(&document, Some(map @ Value::Map(_)) if map.get("frames").is_some())
}
