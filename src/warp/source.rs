//! What is warped: a scene, or an image sequence.

use std::path::Path;

use clap::ValueEnum;
use potamoi_golden::camera::Camera;
use potamoi_golden::mesh;
use potamoi_golden::picture::Picture;
use potamoi_golden::scene::{ExactDepth, Images, Scene};
use potamoi_golden::warp::{Geometry, ReferenceFrom, Renderer};

use crate::failure::Failure;
use crate::scene::SceneArgs;

/// Where depth is from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum DepthFrom {
    /// The model's rendering: where its light is taken, on average
    Model,
    /// What comes with the images, or what is known of an analytic scene
    Given,
    /// The model's surface as a mesh, rasterised
    Mesh,
}

impl DepthFrom {
    pub(super) const fn name(self) -> &'static str {
        match self {
            Self::Model => "model",
            Self::Given => "given",
            Self::Mesh => "mesh",
        }
    }
}

pub(super) enum Source {
    Scene(Box<Scene>),
    Images(Images),
}

impl Source {
    pub(super) fn open(args: &SceneArgs) -> Result<Self, Failure> {
        match Images::open(args.name())? {
            Some(_) if args.looks_otherwise() => Err(Failure::Usage(format!(
                "--scene {}: an image sequence has cameras and a size of its own: leave out \
                 --camera, --width and --height",
                args.name()
            ))),
            Some(images) => Ok(Self::Images(images)),
            None => Ok(Self::Scene(Box::new(args.open()?))),
        }
    }

    pub(super) fn name(&self) -> &str {
        match self {
            Self::Scene(scene) => scene.name(),
            Self::Images(images) => images.name(),
        }
    }

    pub(super) fn renderer(&self) -> &dyn Renderer {
        match self {
            Self::Scene(scene) => &**scene,
            Self::Images(images) => images,
        }
    }

    /// Whether frames are a time apart that `--fps` chooses.
    pub(super) fn is_timed(&self) -> bool {
        matches!(self, Self::Scene(scene) if scene.has_own_way())
    }

    /// So many frames; where none were asked for, `usual` of a built-in way and
    /// all of a file, but not more.
    pub(super) fn path(
        &self,
        fps: f64,
        frames: Option<u32>,
        usual: u32,
    ) -> Result<Vec<Camera>, Failure> {
        Ok(match self {
            Self::Scene(scene) => {
                let all = scene.path_length();
                let frames = frames.unwrap_or_else(|| all.map_or(usual, |all| usual.min(all)));
                scene.path(fps, frames)?
            }
            Self::Images(images) => images.path(frames.map_or(images.len(), |f| f as usize))?,
        })
    }

    pub(super) const fn usual_depth(&self) -> DepthFrom {
        match self {
            Self::Scene(_) => DepthFrom::Model,
            Self::Images(_) => DepthFrom::Given,
        }
    }

    /// Image sequences have no frames off their path.
    pub(super) const fn usual_reference(&self) -> ReferenceFrom {
        match self {
            Self::Scene(_) => ReferenceFrom::Predicted,
            Self::Images(_) => ReferenceFrom::Centre,
        }
    }

    pub(super) fn geometry(
        &self,
        depth: DepthFrom,
        file: Option<&Path>,
        cells: u32,
    ) -> Result<Option<Box<dyn Geometry + '_>>, Failure> {
        if let Some(file) = file {
            return Ok(Some(Box::new(mesh::read(file)?)));
        }
        match (depth, self) {
            (DepthFrom::Model, _) => Ok(None),
            (DepthFrom::Given, Self::Images(images)) => Ok(Some(Box::new(images.clone()))),
            (DepthFrom::Given, Self::Scene(scene)) => match scene.analytic() {
                Some(analytic) => Ok(Some(Box::new(ExactDepth(analytic)))),
                None => Err(Failure::Usage(format!(
                    "--depth given: {} comes without depth: choose model or mesh",
                    scene.name()
                ))),
            },
            (DepthFrom::Mesh, Self::Scene(scene)) => {
                Ok(Some(Box::new(mesh::of_scene(scene, cells)?)))
            }
            (DepthFrom::Mesh, Self::Images(images)) => Err(Failure::Usage(format!(
                "--depth mesh: {} has no model to take a surface of: choose given, or name a file \
                 with --mesh",
                images.name()
            ))),
        }
    }

    /// What is really there, where it is known.
    pub(super) fn truth(&self, camera: &Camera) -> Result<Option<Picture>, Failure> {
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
