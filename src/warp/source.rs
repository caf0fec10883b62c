//! What is warped: a scene, or an image sequence.

use std::fmt;
use std::path::PathBuf;

use clap::{Args, ValueEnum};
use potamoi_analytic::Analytic;
use potamoi_base::camera::Camera;
use potamoi_base::picture::Picture;
use potamoi_base::record::Notes;
use potamoi_scene::{ExactDepth, Images, Scene};
use potamoi_warp::mesh;
use potamoi_warp::{Geometry, ReferenceFrom, Renderer};

use crate::failure::Failure;
use crate::scene::SceneArgs;

/// Where depth is from.
#[derive(Debug, Args)]
pub(super) struct DepthArgs {
    /// Where depth is from; several side by side [default: given for image sequences, else model]
    #[arg(long, value_name = "FROM,...", value_enum, value_delimiter = ',')]
    depth: Vec<DepthFrom>,
    /// Cells along the longest side of the mesh of a model's surface; several side by side
    #[arg(
        long,
        value_name = "N,...",
        value_delimiter = ',',
        default_value = "256"
    )]
    mesh_cells: Vec<u32>,
    /// Mesh that depth is taken from, .obj or .ply [default: as --depth says]
    #[arg(long, value_name = "FILE", conflicts_with = "depth")]
    mesh: Option<PathBuf>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum DepthFrom {
    /// The model's rendering: where its light is taken, on average
    Model,
    /// What comes with the images, or what is known of an analytic scene
    Given,
    /// The model's surface as a mesh, rasterised
    Mesh,
}

/// One place that depth is from.
#[derive(Debug)]
pub(super) enum Depth {
    Model,
    Given,
    /// Of so many cells along the longest side.
    Mesh(u32),
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

impl DepthArgs {
    pub(super) fn choices(&self, source: &Source) -> Vec<Depth> {
        if let Some(file) = &self.mesh {
            return vec![Depth::File(file.clone())];
        }
        let usual = [source.usual_depth()];
        let wanted = match self.depth.is_empty() {
            true => &usual[..],
            false => &self.depth,
        };
        let mut choices = vec![];
        for depth in wanted {
            match depth {
                DepthFrom::Model => choices.push(Depth::Model),
                DepthFrom::Given => choices.push(Depth::Given),
                DepthFrom::Mesh => choices.extend(self.mesh_cells.iter().copied().map(Depth::Mesh)),
            }
        }
        choices
    }
}

pub(super) enum Source {
    Scene(Box<Scene>),
    Images(Images),
}

impl Source {
    pub(super) fn open(args: &SceneArgs, name: &str) -> Result<Self, Failure> {
        match Images::open(name)? {
            Some(_) if args.looks_otherwise() || args.axes().is_some() => {
                Err(Failure::Usage(format!(
                    "--scene {}: an image sequence has cameras and a size of its own: leave out \
                 --camera, --width, --height and --axes",
                    name
                )))
            }
            Some(images) => Ok(Self::Images(images)),
            None => Ok(Self::Scene(Box::new(args.open_named(name)?))),
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
        matches!(self, Self::Scene(scene) if scene.path_length().is_none())
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

    const fn usual_depth(&self) -> DepthFrom {
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

    /// What tells depth; `notes` takes what its file says that is not used.
    pub(super) fn geometry(
        &self,
        depth: &Depth,
        notes: &mut Notes,
    ) -> Result<Option<Box<dyn Geometry + '_>>, Failure> {
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
                None => Err(Failure::Usage(format!(
                    "--depth given: {} comes without depth: choose model or mesh",
                    scene.name()
                ))),
            },
            (Depth::Mesh(cells), Self::Scene(scene)) => Ok(Some(Box::new(
                potamoi_scene::surface::of_scene(scene, *cells)?,
            ))),
            (Depth::Mesh(_), Self::Images(images)) => Err(Failure::Usage(format!(
                "--depth mesh: {} has no model to take a surface of: choose given, or name a file \
                 with --mesh",
                images.name()
            ))),
        }
    }

    /// The analytic scene that it is of, if any.
    pub(super) fn analytic(&self) -> Option<Analytic> {
        match self {
            Self::Scene(scene) => scene.analytic(),
            Self::Images(_) => None,
        }
    }

    /// What a model's file leaves open, and frames in which nothing is in view.
    pub(super) fn left_open(&self, path: &[Camera]) -> Vec<String> {
        match self {
            Self::Scene(scene) => scene.left_open_along(path),
            Self::Images(images) => images.left_open(),
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
