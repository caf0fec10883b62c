//! Arguments of the warping source and its depth.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use potamoi_explore::warping::{Depth, Source};
use potamoi_scene::Images;

use crate::args::Common;
use crate::failure::Failure;
use crate::scene::SceneArgs;

/// Where depth is from.
#[derive(Debug, Args)]
pub(super) struct DepthArgs {
    /// Source of depth; several are compared side by side [default: given for image sequences, else
    /// model]
    #[arg(long, value_name = "FROM,...", value_enum, value_delimiter = ',')]
    depth: Vec<DepthFrom>,
    /// Cells along the longest side of the mesh of a model's surface; several are compared side by
    /// side
    #[arg(
        long,
        value_name = "N,...",
        value_delimiter = ',',
        default_value = "256"
    )]
    mesh_cells: Vec<u32>,
    /// Mesh file as the source of depth, .obj or .ply [default: set by --depth]
    #[arg(long, value_name = "FILE", conflicts_with = "depth")]
    mesh: Option<PathBuf>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum DepthFrom {
    /// Rendered by the model: the mean depth of its samples, weighted by their light
    Model,
    /// Depth maps of the images, or the exact depth of an analytic scene
    Given,
    /// Rasterised from a mesh of the model's surface
    Mesh,
}

impl DepthArgs {
    pub(super) fn choices(&self, source: &Source) -> Vec<Depth> {
        if let Some(file) = &self.mesh {
            return vec![Depth::File(file.clone())];
        }
        if self.depth.is_empty() {
            return vec![source.usual_depth()];
        }
        let mut choices = vec![];
        for depth in &self.depth {
            match depth {
                DepthFrom::Model => choices.push(Depth::Model),
                DepthFrom::Given => choices.push(Depth::Given),
                DepthFrom::Mesh => choices.extend(self.mesh_cells.iter().copied().map(Depth::Mesh)),
            }
        }
        choices
    }
}

/// Opens a scene or an image sequence.
pub(super) fn open(args: &SceneArgs, name: &str) -> Result<Source, Failure> {
    match Images::open(name)? {
        Some(_) if args.looks_otherwise() || args.axes().is_some() => Err(Failure::Usage(format!(
            "--scene {name}: an image sequence has cameras and a size of its own: leave out \
             --camera, --width, --height and --axes"
        ))),
        Some(images) => Ok(Source::Images(images)),
        None => Ok(Source::Scene(Box::new(
            args.open_named(name, &Common::default())?,
        ))),
    }
}
