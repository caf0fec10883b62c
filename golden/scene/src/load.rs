//! Loading of scenes by name.

use std::path::Path;
use std::sync::Arc;

use glam::DVec3;
use rayon::prelude::*;

use super::builtin::SIDE;
use super::description::{Description, ModelDescription};
use super::{BUILTIN, Model, Scene, SceneError};
use crate::compact_3dgs::{self, Compact};
use crate::model_facts::Cache;
use potamoi_analytic::lantern;
use potamoi_base::camera::Camera;
use potamoi_base::effects::Choices;
use potamoi_base::file_keys::{Notes, told};
use potamoi_base::precision::Precision;
use potamoi_fields::{FieldFile, FileOptions, LoadedField, algorithms};
use potamoi_gaussians::{Axes, files};
use potamoi_march::tiling::Halo;
use potamoi_splats::{Order, Profile};

/// Default step in voxel edges.
pub(super) const STEP: f64 = 0.5;
/// Extensions of scene files.
fn endings() -> String {
    let fields = algorithms::files().flat_map(|file| file.endings);
    let all = files::endings().into_iter().chain([compact_3dgs::ENDING]);
    let all: Vec<String> = all
        .chain(fields.copied())
        .map(|e| format!(".{e}"))
        .collect();
    format!("{} or .toml", all.join(", "))
}

/// The largest coordinate of a Gaussian's centre in a file. Default cameras stand several extents
/// away, which must fit 32-bit floats.
const MAX_CENTRE: f32 = 1e30;
/// Maximum length of a path in bytes, set by the operating system.
const LONGEST_PATH: usize = 4095;
/// Coordinates that a thread checks at a time.
const BLOCK: usize = 1 << 14;

impl Scene {
    /// Opens a scene: a built-in name, with a colon and a representation for analytic scenes; a
    /// splat model of any format of [`files`] or of Compact-3DGS; a field; or a `.toml`
    /// description. Bare splats are seen from [`crate::Orbit::around`] them, y down as in 3DGS training,
    /// by the rules of `inria` on black.
    ///
    /// # Errors
    /// There is no such scene, or the file is invalid or not supported.
    pub fn open(name: &str) -> Result<Self, SceneError> {
        Self::open_in(name, None)
    }

    /// As [`Scene::open`], for splats whose axes differ from those of their file or format. The
    /// model is converted, cameras are not.
    ///
    /// # Errors
    /// Those of [`Scene::open`], or the name is not that of a splat file.
    pub fn open_in(name: &str, axes: Option<Axes>) -> Result<Self, SceneError> {
        Self::open_by(name, axes, true)
    }

    /// As [`Scene::open_in`], seen from camera `index` of a camera file.
    ///
    /// # Errors
    /// Those of [`Scene::open_in`] and of [`Scene::set_camera_file`].
    pub fn open_seen_from(
        name: &str,
        axes: Option<Axes>,
        cameras: &Path,
        index: usize,
    ) -> Result<Self, SceneError> {
        let mut scene = Self::open_by(name, axes, false)?;
        scene.set_camera_file(cameras, index)?;
        Ok(scene)
    }

    /// A splat model of a file is seen whole, or not yet: finding where from takes time.
    fn open_by(name: &str, axes: Option<Axes>, is_seen: bool) -> Result<Self, SceneError> {
        let scene = Self::opened(name, axes, is_seen).map_err(|e| e.of(name))?;
        match axes {
            Some(axes) if scene.axes != Some(axes) => {
                let expected = "it left out: it is for files of splats";
                Err(scene.value("axes", axes.to_string(), expected))
            }
            _ => Ok(scene),
        }
    }

    fn opened(name: &str, axes: Option<Axes>, is_seen: bool) -> Result<Self, SceneError> {
        if let Some(scene) = Self::builtin(name) {
            return scene;
        }
        let path = Path::new(name);
        if let Some(why) = potamoi_base::memory::too_large(path) {
            return Err(SceneError::Memory {
                path: path.to_owned(),
                why,
            });
        }
        if files::is_splats(path) {
            return Self::model_file(path, axes, None, is_seen);
        }
        let ending = path.extension().map(|e| e.to_string_lossy().to_lowercase());
        match ending.as_deref() {
            Some("toml") => Self::described(path, axes),
            Some(compact_3dgs::ENDING) => Self::compact(path, axes, is_seen),
            other => match other.and_then(algorithms::file_of_ending) {
                Some(file) => Self::field_file(path, file, &FileOptions::default()),
                None if path.exists() => Err(SceneError::Ending {
                    path: path.to_owned(),
                    kind: match other {
                        _ if path.is_dir() => {
                            "folders but those of SOG, with `meta.json` or `lod-meta.json`,"
                                .to_owned()
                        }
                        Some(other) => format!("files that end in `.{}`", told(other)),
                        None => "files without an ending".to_owned(),
                    },
                    expected: endings(),
                }),
                None => Err(Self::unknown(name)),
            },
        }
    }

    pub(super) fn unknown(name: &str) -> SceneError {
        SceneError::Unknown {
            name: told(name),
            builtin: BUILTIN.join(", "),
            endings: endings(),
        }
    }

    /// A scene from a model in memory, with default options. `up` is the vertical axis for paths
    /// around it, `background` is linear RGB.
    #[must_use]
    pub fn of(
        name: &str,
        model: impl Into<Arc<Model>>,
        camera: Camera,
        up: DVec3,
        background: [f32; 3],
    ) -> Self {
        Self {
            name: name.to_owned(),
            model: model.into(),
            camera,
            path: vec![],
            motion: None,
            up,
            background,
            profile: Profile::Inria,
            order: Order::Exact,
            group_tiles: None,
            group_side: None,
            halo: Halo::Shared,
            cells: potamoi_splats::Cells::MERGED,
            step: STEP,
            from_file: false,
            axes: None,
            origin: DVec3::ZERO,
            file_facts: None,
            notes: Notes::default(),
            truth: None,
            choices: Choices::default(),
            precision: Precision::default(),
            found: Cache::default(),
        }
    }

    /// Gaussians with y down as in 3DGS training, unless the file states otherwise, over black,
    /// seen from [`Scene::default_orbit`].
    fn model_file(
        path: &Path,
        axes: Option<Axes>,
        level: Option<usize>,
        is_seen: bool,
    ) -> Result<Self, SceneError> {
        let loaded = files::read_level(path, axes, level)?;
        let up = loaded.up.unwrap_or(DVec3::NEG_Y);
        let coordinates = loaded.cloud.means().as_flattened().par_chunks(BLOCK);
        let far = coordinates.find_map_first(|own| own.iter().find(|v| v.abs() > MAX_CENTRE));
        if let Some(far) = far {
            return Err(SceneError::Value {
                scene: path.display().to_string(),
                field: "centres of Gaussians",
                value: far.to_string(),
                expected: format!("{MAX_CENTRE:e} at most, from where a camera can see them all"),
            });
        }
        let mut scene = Self::file(path, Model::Splats(loaded.cloud), up, [0.0; 3], is_seen);
        (scene.axes, scene.origin, scene.notes) = (axes, loaded.origin, loaded.notes);
        scene.file_facts = Some(loaded.facts.into());
        Ok(scene)
    }

    fn compact(path: &Path, axes: Option<Axes>, is_seen: bool) -> Result<Self, SceneError> {
        let (model, notes) = Compact::load(path, axes)?;
        let model = Model::Compact(Box::new(model));
        let mut scene = Self::file(path, model, DVec3::NEG_Y, [0.0; 3], is_seen);
        (scene.axes, scene.notes) = (axes, notes);
        Ok(scene)
    }

    /// A field in the world of `transforms.json`, z up, seen from [`Scene::default_orbit`].
    pub(super) fn field_file(
        path: &Path,
        file: &FieldFile,
        options: &FileOptions,
    ) -> Result<Self, SceneError> {
        let LoadedField { field, notes } = (file.load)(path, options)?;
        field.sampling().check().map_err(|e| e.of_file(path))?;
        let scene = Self::file(path, Model::Field(field), DVec3::Z, file.background, true);
        Ok(Self { notes, ..scene })
    }

    fn file(path: &Path, model: Model, up: DVec3, background: [f32; 3], is_seen: bool) -> Self {
        let name = path.display().to_string();
        let camera = lantern::camera(SIDE, SIDE);
        let mut scene = Self::of(&name, model, camera, up, background);
        if is_seen {
            scene.camera = scene.default_orbit().camera(scene.up, SIDE, SIDE);
        }
        scene.from_file = true;
        scene
    }

    /// Opens a description. `asked` has precedence over its axes.
    fn described(path: &Path, asked: Option<Axes>) -> Result<Self, SceneError> {
        let description = Description::read(path)?;
        let folder = path.parent().unwrap_or(Path::new(""));
        // The model may be anywhere: what names it is told too.
        let model = |model: &Path| match model.as_os_str().len() {
            0..=LONGEST_PATH => Ok(folder.join(model)),
            bytes => Err(SceneError::Description {
                path: path.to_owned(),
                message: format!(
                    "field `model.path` has {bytes} bytes: expected a path of at most {LONGEST_PATH}"
                ),
            }),
        };
        let named = |error: SceneError| SceneError::Of {
            scene: format!("{}: field `model.path`", path.display()),
            source: Box::new(error),
        };
        let mut scene = match &description.model {
            ModelDescription::Builtin {
                name,
                representation: None,
            } if name.contains(':') => {
                let (scene, representation) = name.split_once(':').unwrap_or((name, ""));
                return Err(SceneError::Description {
                    path: path.to_owned(),
                    message: format!(
                        "field `model.name`: `{name}`: expected a scene alone; write name = \"{scene}\" and \
                         representation = \"{representation}\""
                    ),
                });
            }
            ModelDescription::Builtin {
                name,
                representation,
            } => Self::represented(name, name, representation.as_deref()).map_err(|error| {
                // The description is at fault, and names what is built in alone.
                SceneError::Description {
                    path: path.to_owned(),
                    message: format!("field `model.name`: {error}"),
                }
            })?,
            ModelDescription::Splats { path, axes, level } => {
                Self::model_file(&model(path)?, asked.or(*axes), *level, true).map_err(named)?
            }
            ModelDescription::Compact3dgs { path, axes } => {
                Self::compact(&model(path)?, asked.or(*axes), true).map_err(named)?
            }
            ModelDescription::Field {
                file,
                path,
                options,
            } => Self::field_file(&model(path)?, file, options).map_err(named)?,
            ModelDescription::Images(_) => {
                return Err(SceneError::Description {
                    path: path.to_owned(),
                    message: "field `model.kind`: an image sequence has no model to render: \
                              only `warp` takes one"
                        .to_owned(),
                });
            }
        };
        scene.name = path.display().to_string();
        scene.look(&description.camera, folder)?;
        scene.rules(&description.render)?;
        Ok(scene)
    }

    pub(super) fn value(&self, field: &'static str, value: String, expected: &str) -> SceneError {
        SceneError::Value {
            scene: self.name.clone(),
            field,
            value: told(&value),
            expected: expected.to_owned(),
        }
    }
}
