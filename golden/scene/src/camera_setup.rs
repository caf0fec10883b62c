//! Camera, picture size and background of a scene.

use std::path::Path;

use glam::{DAffine3, DVec3};
use potamoi_formats::record::COLOUR;

use super::builtin::SIDE;
use super::description::CameraDescription;
use super::transforms::PathFrame;
use super::{Kind, Orbit, Scene, SceneError, camera_file, colmap, transforms};
use potamoi_base::camera::Camera;
use potamoi_base::file_keys::Notes;

/// The largest picture side, in pixels.
const MAX_SIDE: u32 = 1 << 14;
/// The largest magnitude of a voxel background that the accumulator can hold.
const VOXEL_BACKGROUND: f64 = 7.999;
/// The largest distance of an orbit from its target, or of a target from the origin. Beyond it,
/// poses lose their rotation to rounding.
const FAR: f64 = 1e9;

/// An orbit that frames a box.
fn framing(bounds: [DVec3; 2]) -> Orbit {
    let size = bounds[1] - bounds[0];
    Orbit {
        distance: size.length() / 2.0 / (Orbit::USUAL.fov / 2.0).to_radians().sin(),
        target: bounds[0] + size / 2.0,
        ..Orbit::USUAL
    }
}

fn cameras_of(frames: &[PathFrame]) -> Vec<Camera> {
    frames.iter().map(|f| f.camera).collect()
}

impl Scene {
    pub(super) fn look(
        &mut self,
        camera: &CameraDescription,
        folder: &Path,
    ) -> Result<(), SceneError> {
        match camera {
            CameraDescription::Default => Ok(()),
            CameraDescription::OpencvJson {
                path,
                index,
                width,
                height,
            } => {
                self.set_camera_file(&folder.join(path), *index)?;
                self.set_size(*width, *height)
            }
            CameraDescription::Transforms {
                path,
                index,
                width,
                height,
            } => {
                let path = folder.join(path);
                let mut notes = Notes::default();
                let frames = transforms::read(&path, &mut notes)?;
                self.notes.extend(notes.of_file(&path));
                self.follow(cameras_of(&frames), *index, &path)?;
                self.set_size(*width, *height)
            }
            CameraDescription::Colmap {
                path,
                index,
                name,
                width,
                height,
            } => {
                let path = folder.join(path);
                let mut notes = Notes::default();
                let frames = colmap::read(&path, &mut notes)?;
                self.notes.extend(notes);
                let index = match (index, name) {
                    (Some(_), Some(name)) => {
                        let expected = "it left out, as camera.index is given";
                        return Err(self.value("camera.name", name.clone(), expected));
                    }
                    (index, None) => index.unwrap_or_default(),
                    (None, Some(name)) => {
                        let found = frames.iter().position(|f| f.picture == Path::new(name));
                        found.ok_or_else(|| {
                            let expected = format!("an image of {}", path.display());
                            self.value("camera.name", name.clone(), &expected)
                        })?
                    }
                };
                self.follow(cameras_of(&frames), index, &path)?;
                self.set_size(*width, *height)
            }
            CameraDescription::Trajectory(own) => self.follow_motion(own, folder),
            CameraDescription::Orbit {
                azimuth,
                elevation,
                distance,
                fov,
                target,
                width,
                height,
            } => {
                let default = self.default_orbit();
                let orbit = Orbit {
                    azimuth: azimuth.unwrap_or(default.azimuth),
                    elevation: elevation.unwrap_or(default.elevation),
                    distance: distance.unwrap_or(default.distance),
                    fov: fov.unwrap_or(default.fov),
                    target: target.map_or(default.target, |own| DVec3::from(own) - self.origin),
                };
                self.check_orbit(&orbit)?;
                self.camera = orbit.camera(self.up, SIDE, SIDE);
                self.set_size(*width, *height)
            }
        }
    }

    pub(super) fn default_orbit(&self) -> Orbit {
        match self.model.kind() {
            Kind::Splats(cloud) => Orbit::around(cloud),
            Kind::Field(field) => framing(field.sampling().bounds),
        }
    }

    fn check_orbit(&self, orbit: &Orbit) -> Result<(), SceneError> {
        let checks = [
            (
                "camera.elevation",
                orbit.elevation.to_string(),
                orbit.elevation.abs() < 89.9,
                "above -89.9 and below 89.9 degrees",
            ),
            (
                "camera.distance",
                orbit.distance.to_string(),
                (1.0 / FAR..=FAR).contains(&orbit.distance),
                "1e-9 to 1e9",
            ),
            (
                "camera.fov",
                orbit.fov.to_string(),
                (0.1..179.0).contains(&orbit.fov),
                "0.1 to 179 degrees",
            ),
            (
                "camera.azimuth",
                orbit.azimuth.to_string(),
                orbit.azimuth.is_finite(),
                "a number of degrees",
            ),
            (
                "camera.target",
                format!("{:?}", orbit.target.to_array()),
                orbit.target.to_array().iter().all(|v| v.abs() <= FAR),
                "numbers from -1e9 to 1e9",
            ),
        ];
        for (field, value, right, expected) in checks {
            if !right {
                return Err(self.value(field, value, expected));
            }
        }
        Ok(())
    }

    /// Sets the camera and background to those of camera `index` of a camera file.
    ///
    /// # Errors
    /// The file is invalid, it does not have this camera, or the background does not fit the
    /// model's colour format.
    pub fn set_camera_file(&mut self, path: &Path, index: usize) -> Result<(), SceneError> {
        let mut notes = Notes::default();
        let cameras = camera_file::read(path, &mut notes)?;
        self.notes.extend(notes.of_file(path));
        self.follow(cameras.iter().map(|c| c.camera).collect(), index, path)?;
        self.set_background("camera.background", cameras[index].background)
    }

    /// Sets the camera to one of a file's; the following ones become the scene's path.
    fn follow(
        &mut self,
        mut cameras: Vec<Camera>,
        index: usize,
        file: &Path,
    ) -> Result<(), SceneError> {
        let Some(camera) = cameras.get(index).copied() else {
            let expected = camera_file::indices(cameras.len(), file);
            return Err(self.value("camera.index", index.to_string(), &expected));
        };
        self.motion = None;
        // Cameras are of the file's world, the model from its own origin on.
        let there = DAffine3::from_translation(self.origin);
        let from_origin = |own: Camera| Camera {
            world_to_camera: own.world_to_camera * there,
            ..own
        };
        if self.origin == DVec3::ZERO {
            self.camera = camera;
            self.path = cameras.split_off(index);
            return Ok(());
        }
        self.camera = from_origin(camera);
        self.path = cameras.drain(index..).map(from_origin).collect();
        Ok(())
    }

    /// Sets the size of the picture and of those on a path. If only one side is given, each keeps
    /// its aspect ratio.
    ///
    /// # Errors
    /// A side is 0 or above 16,384 pixels.
    pub fn set_size(&mut self, width: Option<u32>, height: Option<u32>) -> Result<(), SceneError> {
        let resized = |camera: &Camera| self.resized(camera, width, height);
        let path: Result<Vec<Camera>, SceneError> = self.path.iter().map(resized).collect();
        (self.camera, self.path) = (resized(&self.camera)?, path?);
        Ok(())
    }

    fn resized(
        &self,
        camera: &Camera,
        width: Option<u32>,
        height: Option<u32>,
    ) -> Result<Camera, SceneError> {
        let [w, h] = [camera.width, camera.height];
        let scaled = |side: u32, from: u32, to: u32| {
            let exact = f64::from(side) * f64::from(to) / f64::from(from);
            (exact.round() as u32).max(1)
        };
        let size = match (width, height) {
            (None, None) => return Ok(*camera),
            (Some(width), Some(height)) => [width, height],
            (Some(width), None) => [width, scaled(width, w, h)],
            (None, Some(height)) => [scaled(height, h, w), height],
        };
        for (field, side) in ["width", "height"].into_iter().zip(size) {
            if !(1..=MAX_SIDE).contains(&side) {
                let expected = format!("1 to {MAX_SIDE} pixels");
                return Err(self.value(field, side.to_string(), &expected));
            }
        }
        Ok(camera.resized(size[0], size[1]))
    }

    /// Codes saturate, so a value outside the format would become another colour.
    pub(super) fn set_background(
        &mut self,
        field: &'static str,
        rgb: [f32; 3],
    ) -> Result<(), SceneError> {
        let held = match self.model.kind() {
            Kind::Splats(_) => 0.0..=COLOUR.value(COLOUR.max()),
            _ => -VOXEL_BACKGROUND..=VOXEL_BACKGROUND,
        };
        // Not a number is in no range.
        if !rgb.iter().all(|v| held.contains(&f64::from(*v))) {
            let expected = format!("numbers from {} to {}", held.start(), held.end());
            return Err(self.value(field, format!("{rgb:?}"), &expected));
        }
        self.background = rgb;
        Ok(())
    }
}
