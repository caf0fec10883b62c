//! Sources of warping: a scene, or an image sequence.

use std::fmt;
use std::path::PathBuf;

use potamoi_analytic::Analytic;
use potamoi_base::camera::Camera;
use potamoi_base::file_keys::Notes;
use potamoi_base::picture::Picture;
use potamoi_scene::{ExactDepth, Images, Scene};
use potamoi_warp::mesh;
use potamoi_warp::{Geometry, ReferenceFrom, Renderer};

use crate::ExploreError;

/// Source of depth.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Depth {
    /// The model's rendering: the mean depth at which light is absorbed.
    Model,
    /// Depth given with the images, or known from an analytic scene.
    Given,
    /// The model's surface as a rasterised mesh, with so many cells along the longest side.
    Mesh(u32),
    /// A mesh from a file.
    File(PathBuf),
}

impl fmt::Display for Depth {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Model => f.write_str("model"),
            Self::Given => f.write_str("given"),
            Self::Mesh(cells) => write!(f, "mesh {cells}"),
            Self::File(path) => write!(f, "{}", path.display()),
        }
    }
}

/// Source of warping.
pub enum Source {
    /// A scene, whose model renders the remaining pixels.
    Scene(Box<Scene>),
    /// Images with cameras and depth, used in place of renderings.
    Images(Images),
}

impl Source {
    /// Its name.
    #[must_use]
    pub fn name(&self) -> &str {
        match self {
            Self::Scene(scene) => scene.name(),
            Self::Images(images) => images.name(),
        }
    }

    /// Renderer of its frames.
    #[must_use]
    pub fn renderer(&self) -> &dyn Renderer {
        match self {
            Self::Scene(scene) => &**scene,
            Self::Images(images) => images,
        }
    }

    /// Whether the frame rate can be chosen.
    #[must_use]
    pub fn is_timed(&self) -> bool {
        matches!(self, Self::Scene(scene) if scene.follows_fps())
    }

    /// The rate of its path for a command's rate `fps`; `None` for frames without times.
    #[must_use]
    pub fn rate(&self, fps: f64) -> Option<f64> {
        match self {
            Self::Scene(scene) => scene.path_rate(fps),
            Self::Images(_) => None,
        }
    }

    /// Number of frames of its path at `fps` frames a second, where it ends.
    #[must_use]
    pub fn length(&self, fps: f64) -> Option<u32> {
        match self {
            Self::Scene(scene) => scene.path_length(fps),
            Self::Images(images) => images.len().try_into().ok(),
        }
    }

    /// The scene on its own path, if its camera follows a recorded motion.
    #[must_use]
    pub fn without_motion(&self) -> Option<Self> {
        match self {
            Self::Scene(scene) if scene.has_motion() => {
                Some(Self::Scene(Box::new(scene.without_motion())))
            }
            _ => None,
        }
    }

    /// Cameras of `frames` frames. Without a number, `usual` for a built-in path and all for a
    /// file, but not more.
    ///
    /// # Errors
    /// More frames than a file has, or an invalid rate.
    pub fn path(
        &self,
        fps: f64,
        frames: Option<u32>,
        usual: u32,
    ) -> Result<Vec<Camera>, ExploreError> {
        Ok(match self {
            Self::Scene(scene) => {
                let all = scene.path_length(fps);
                let frames = frames.unwrap_or_else(|| all.map_or(usual, |all| usual.min(all)));
                scene.path(fps, frames)?
            }
            Self::Images(images) => images.path(frames.map_or(images.len(), |f| f as usize))?,
        })
    }

    /// Default source of depth.
    #[must_use]
    pub const fn usual_depth(&self) -> Depth {
        match self {
            Self::Scene(_) => Depth::Model,
            Self::Images(_) => Depth::Given,
        }
    }

    /// Default origin of references: image sequences have no frames off their path.
    #[must_use]
    pub const fn usual_reference(&self) -> ReferenceFrom {
        match self {
            Self::Scene(_) => ReferenceFrom::Predicted,
            Self::Images(_) => ReferenceFrom::Centre,
        }
    }

    /// Geometry that supplies depth; `None` where that is the rendering. `notes` receives unused
    /// parts of its file.
    ///
    /// # Errors
    /// A mesh that cannot be read or made, or depth that the source lacks.
    pub fn geometry(
        &self,
        depth: &Depth,
        notes: &mut Notes,
    ) -> Result<Option<Box<dyn Geometry + '_>>, ExploreError> {
        match (depth, self) {
            (Depth::File(file), _) => {
                let (mesh, said) = mesh::read(file)?;
                notes.extend(said.of_file(file));
                Ok(Some(Box::new(mesh)))
            }
            (Depth::Model, _) => Ok(None),
            (Depth::Given, Self::Images(images)) => Ok(Some(Box::new(images.clone()))),
            (Depth::Given, Self::Scene(scene)) => match scene.analytic() {
                Some(analytic) => Ok(Some(Box::new(ExactDepth(analytic)))),
                None => Err(ExploreError::Refused(format!(
                    "--depth given: {} comes without depth: choose model or mesh",
                    scene.name()
                ))),
            },
            (Depth::Mesh(cells), Self::Scene(scene)) => Ok(Some(Box::new(
                potamoi_scene::surface::of_scene(scene, *cells)?,
            ))),
            (Depth::Mesh(_), Self::Images(images)) => Err(ExploreError::Refused(format!(
                "--depth mesh: {} has no model to take a surface of: choose given, or name a file \
                 with --mesh",
                images.name()
            ))),
        }
    }

    /// Its analytic scene, if any.
    #[must_use]
    pub fn analytic(&self) -> Option<Analytic> {
        match self {
            Self::Scene(scene) => scene.analytic(),
            Self::Images(_) => None,
        }
    }

    /// Items that the model's file leaves open, and frames with an empty view.
    #[must_use]
    pub fn left_open(&self, path: &[Camera]) -> Vec<String> {
        match self {
            Self::Scene(scene) => scene.left_open_along(path),
            Self::Images(images) => images.left_open(),
        }
    }

    /// Ground truth, where it is known.
    ///
    /// # Errors
    /// A camera that the scene cannot be seen by.
    pub fn truth(&self, camera: &Camera) -> Result<Option<Picture>, ExploreError> {
        let Self::Scene(scene) = self else {
            return Ok(None);
        };
        if scene.analytic().is_none() {
            return Ok(None);
        }
        let mut there = (**scene).clone();
        there.set_camera(*camera);
        Ok(Some(there.render_truth()?.picture))
    }
}
