//! From a name to a scene.

use std::path::Path;
use std::str::FromStr as _;

use glam::DVec3;
use potamoi_formats::record::COLOUR;

use super::description::{CameraDescription, Description, ModelDescription, RenderDescription};
use super::transforms::PathFrame;
use super::{
    BUILTIN, Kind, Model, NGP, NGP_MVOXEL, Orbit, Scene, SceneError, camera_file, colmap, lantern,
    transforms,
};
use crate::camera::Camera;
use crate::fields::dvgo::Dvgo;
use crate::fields::ngp::Ngp;
use crate::fields::tensorf::Tensorf;
use crate::fields::{AnyField, HashUnit};
use crate::splats::compact::{self, Compact};
use crate::splats::{Order, Profile, files};
use crate::voxels::Halo;

/// Pixels a side of a picture whose size nobody gave.
pub(super) const SIDE: u32 = 400;
/// Voxel edges from sample to sample unless a description says otherwise.
const STEP: f64 = 0.5;
/// The largest picture side, in pixels.
const MAX_SIDE: u32 = 1 << 14;
/// The largest background of voxels in magnitude, which their accumulator holds.
const VOXEL_BACKGROUND: f64 = 7.999;
/// The farthest that an orbit may be from its target, or a target from the
/// origin; poses past it lose their rotation to rounding.
const FAR: f64 = 1e9;

/// An orbit that frames a box.
fn framing(bounds: [DVec3; 2]) -> Orbit {
    let size = bounds[1] - bounds[0];
    let fov = 45.0f64;
    Orbit {
        azimuth: 30.0,
        elevation: 15.0,
        distance: size.length() / 2.0 / (fov / 2.0).to_radians().sin(),
        fov,
        target: bounds[0] + size / 2.0,
    }
}

fn cameras_of(frames: &[PathFrame]) -> Vec<Camera> {
    frames.iter().map(|f| f.camera).collect()
}

/// The endings of files that are scenes.
fn endings() -> String {
    format!(
        ".{}, .{}, .tar, .th, .ingp, .msgpack or .toml",
        files::ENDINGS.join(", ."),
        compact::ENDING
    )
}

impl Scene {
    /// Opens a scene: a built-in name, with a colon and a representation if it is
    /// known exactly, a splat model of any format of [`files`] or of [`compact`],
    /// a field, or a `.toml` description. Bare splats are seen from
    /// [`Orbit::around`] them, y down as 3DGS trains, by the rules of `inria` on
    /// black.
    ///
    /// # Errors
    /// No such scene, or a file that cannot be used.
    pub fn open(name: &str) -> Result<Self, SceneError> {
        if let Some(scene) = Self::builtin(name) {
            return scene;
        }
        let path = Path::new(name);
        if files::is_splats(path) {
            return Self::model_file(path);
        }
        let ending = path.extension().map(|e| e.to_string_lossy().to_lowercase());
        match ending.as_deref() {
            Some("toml") => Self::described(path),
            Some(compact::ENDING) => Self::compact(path),
            Some("tar") => Self::dvgo(path),
            Some("th") => Self::tensorf(path),
            Some("ingp" | "msgpack") => Self::ngp(path, None),
            Some(other) if path.exists() => Err(SceneError::Ending {
                path: path.to_owned(),
                ending: format!(".{other}"),
                expected: endings(),
            }),
            _ => Err(Self::unknown(name)),
        }
    }

    pub(super) fn unknown(name: &str) -> SceneError {
        SceneError::Unknown {
            name: name.to_owned(),
            builtin: BUILTIN.join(", "),
            endings: endings(),
        }
    }

    /// A model as it is seen unless something else is said.
    pub(super) fn of(
        name: &str,
        model: Model,
        camera: Camera,
        up: DVec3,
        background: [f32; 3],
    ) -> Self {
        Self {
            name: name.to_owned(),
            model,
            camera,
            path: vec![],
            up,
            background,
            profile: Profile::Inria,
            order: Order::Exact,
            group_tiles: None,
            group_side: None,
            halo: Halo::Shared,
            step: STEP,
            truth: None,
        }
    }

    fn model_file(path: &Path) -> Result<Self, SceneError> {
        Ok(Self::splats(path, Model::Splats(files::read(path)?)))
    }

    fn compact(path: &Path) -> Result<Self, SceneError> {
        let model = Box::new(Compact::load(path)?);
        Ok(Self::splats(path, Model::Compact(model)))
    }

    /// Gaussians as 3DGS trains them, y down, over black, seen from
    /// [`Scene::default_orbit`].
    fn splats(path: &Path, model: Model) -> Self {
        Self::file(path, model, DVec3::NEG_Y, [0.0; 3])
    }

    /// A checkpoint over white, on which such models of objects are trained.
    fn dvgo(path: &Path) -> Result<Self, SceneError> {
        let model = Model::Dvgo(Box::new(Dvgo::load(path, STEP)?));
        Ok(Self::framed(path, model, [1.0; 3]))
    }

    /// The same of a checkpoint of TensoRF, whose samples are as far apart as it
    /// says.
    fn tensorf(path: &Path) -> Result<Self, SceneError> {
        let model = Model::Tensorf(Box::new(Tensorf::load(path)?));
        Ok(Self::framed(path, model, [1.0; 3]))
    }

    /// A snapshot, over black. A `unit` has to be what it was fitted with: it says
    /// which vertices share an entry.
    fn ngp(path: &Path, unit: Option<HashUnit>) -> Result<Self, SceneError> {
        let snapshot = Ngp::load(path)?;
        let fitted = snapshot.hash_unit();
        if let Some(unit) = unit.filter(|unit| *unit != fitted) {
            return Err(SceneError::Value {
                scene: path.display().to_string(),
                field: "model.hash_unit",
                value: unit.name().to_owned(),
                expected: format!(
                    "{} or left out: it changes which vertices share an entry, and this \
                     snapshot was fitted with {0}; tools/fit ngp-mvoxel fits the other",
                    fitted.name()
                ),
            });
        }
        let kind = match fitted {
            HashUnit::Vertex => NGP,
            HashUnit::MVoxel => NGP_MVOXEL,
        };
        let field = AnyField::new(kind, snapshot);
        Ok(Self::framed(path, Model::Field(field), [0.0; 3]))
    }

    /// A field in the world of `transforms.json`, z up, seen from
    /// [`Scene::default_orbit`].
    fn framed(path: &Path, model: Model, background: [f32; 3]) -> Self {
        Self::file(path, model, DVec3::Z, background)
    }

    fn file(path: &Path, model: Model, up: DVec3, background: [f32; 3]) -> Self {
        let name = path.display().to_string();
        let camera = lantern::camera(SIDE, SIDE);
        let mut scene = Self::of(&name, model, camera, up, background);
        scene.camera = scene.default_orbit().camera(scene.up, SIDE, SIDE);
        scene
    }

    fn described(path: &Path) -> Result<Self, SceneError> {
        let description = Description::read(path)?;
        let folder = path.parent().unwrap_or(Path::new(""));
        let mut scene = match &description.model {
            ModelDescription::Builtin {
                name,
                representation,
            } => Self::represented(name, name, representation.as_deref())?,
            ModelDescription::Splats { path } => Self::model_file(&folder.join(path))?,
            ModelDescription::Compact3dgs { path } => Self::compact(&folder.join(path))?,
            ModelDescription::Ngp { path, hash_unit } => Self::ngp(&folder.join(path), *hash_unit)?,
            ModelDescription::Dvgo { path } => Self::dvgo(&folder.join(path))?,
            ModelDescription::Tensorf { path } => Self::tensorf(&folder.join(path))?,
        };
        scene.name = path.display().to_string();
        scene.look(&description.camera, folder)?;
        scene.rules(&description.render)?;
        Ok(scene)
    }

    fn look(&mut self, camera: &CameraDescription, folder: &Path) -> Result<(), SceneError> {
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
                let frames = transforms::read(&path)?;
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
                let frames = colmap::read(&path)?;
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
                    target: target.map_or(default.target, DVec3::from),
                };
                self.check_orbit(&orbit)?;
                self.camera = orbit.camera(self.up, SIDE, SIDE);
                self.set_size(*width, *height)
            }
        }
    }

    fn default_orbit(&self) -> Orbit {
        match self.model.kind() {
            Kind::Splats(cloud) => Orbit::around(cloud),
            Kind::Field(field) => framing(field.sampling().bounds),
            Kind::Voxels(grid) => {
                let size = DVec3::from(grid.points().map(|p| (p - 1) as f64)) * grid.voxel();
                framing([grid.corner(), grid.corner() + size])
            }
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

    fn rules(&mut self, render: &RenderDescription) -> Result<(), SceneError> {
        if let Some(name) = &render.profile {
            let known = Profile::from_str(name);
            self.profile = known.map_err(|_| {
                let names = Profile::ALL.map(Profile::name).join(", ");
                self.value("render.profile", name.clone(), &names)
            })?;
        }
        if let Some(background) = render.background {
            self.set_background("render.background", background)?;
        }
        if let Some(name) = &render.order {
            self.order = match name.as_str() {
                "exact" => Order::Exact,
                "approximate" => Order::Approximate,
                _ => {
                    let expected = "exact or approximate";
                    return Err(self.value("render.order", name.clone(), expected));
                }
            };
        }
        if let Some(name) = &render.halo {
            self.halo = match name.as_str() {
                "shared" => Halo::Shared,
                "split" => Halo::Split,
                _ => return Err(self.value("render.halo", name.clone(), "shared or split")),
            };
        }
        self.group_tiles = render.group_tiles;
        self.group_side = render.group_side;
        if let Some(step) = render.step {
            self.set_step(step)?;
        }
        let splats = matches!(self.model.kind(), Kind::Splats(_));
        let voxels = matches!(self.model, Model::Voxels(_) | Model::Dvgo(_));
        let interpolated = match self.model.kind() {
            Kind::Splats(_) => false,
            Kind::Voxels(_) => true,
            Kind::Field(field) => field.tables().iter().any(|table| table.vertices() > 1),
        };
        let stepped = voxels || matches!(self.model, Model::Tensorf(_));
        for (field, given, ours, kind) in [
            ("render.profile", render.profile.is_some(), splats, "splats"),
            ("render.order", render.order.is_some(), splats, "splats"),
            (
                "render.group_tiles",
                render.group_tiles.is_some(),
                splats,
                "splats",
            ),
            (
                "render.group_side",
                render.group_side.is_some(),
                !splats,
                "voxels and fields",
            ),
            (
                "render.halo",
                render.halo.is_some(),
                interpolated,
                "voxels and fields that are interpolated",
            ),
            ("render.step", render.step.is_some(), stepped, "voxels"),
        ] {
            if given && !ours {
                let expected = format!("it left out: it is for {kind}");
                return Err(self.value(field, "given".to_owned(), &expected));
            }
        }
        Ok(())
    }

    /// Voxel edges from sample to sample.
    fn set_step(&mut self, step: f64) -> Result<(), SceneError> {
        if !(1.0 / 64.0..=8.0).contains(&step) {
            let expected = "1/64 to 8 voxel edges";
            return Err(self.value("render.step", step.to_string(), expected));
        }
        self.step = step;
        match &mut self.model {
            Model::Dvgo(field) => field.set_step(step),
            Model::Tensorf(field) => field.set_step(step),
            Model::Splats(_) | Model::Compact(_) | Model::Voxels(_) | Model::Field(_) => {}
        }
        Ok(())
    }

    /// Looks through camera `index` of a camera file, over its background.
    ///
    /// # Errors
    /// A file that cannot be used, no such camera in it, or a background that
    /// the model's colour format does not hold.
    pub fn set_camera_file(&mut self, path: &Path, index: usize) -> Result<(), SceneError> {
        let cameras = camera_file::read(path)?;
        self.follow(cameras.iter().map(|c| c.camera).collect(), index, path)?;
        self.set_background("camera.background", cameras[index].background)
    }

    /// Looks through one of a file's cameras; those from it on are the scene's
    /// path.
    fn follow(
        &mut self,
        mut cameras: Vec<Camera>,
        index: usize,
        file: &Path,
    ) -> Result<(), SceneError> {
        let Some(camera) = cameras.get(index).copied() else {
            let expected = format!("0 to {}, as {} has", cameras.len() - 1, file.display());
            return Err(self.value("camera.index", index.to_string(), &expected));
        };
        self.camera = camera;
        self.path = cameras.split_off(index);
        Ok(())
    }

    /// Gives the picture, and those of a path, another size; one side alone
    /// keeps the shape of each.
    ///
    /// # Errors
    /// A side of 0 or above 16,384 pixels.
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

    /// Codes saturate: what a format does not hold would be another colour.
    fn set_background(&mut self, field: &'static str, rgb: [f32; 3]) -> Result<(), SceneError> {
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

    fn value(&self, field: &'static str, value: String, expected: &str) -> SceneError {
        SceneError::Value {
            scene: self.name.clone(),
            field,
            value,
            expected: expected.to_owned(),
        }
    }
}
