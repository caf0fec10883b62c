//! Which scene a command is about.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use clap::Args;
use potamoi_golden::scene::Scene;

use crate::common::quoted;
use crate::failure::Failure;
use crate::say::say;

#[derive(Debug, Args)]
pub(crate) struct SceneArgs {
    /// Built-in scene (garden, lantern, cairn, vase, lattice, mist, moons, chrome, gallery, city;
    /// each but the first two also as a ready model behind a colon, such as cairn:ngp: voxels,
    /// dvgo, tensorf, ngp, splats, efficientnerf, compact), splat model (.ply, .splat, .spz, .sog),
    /// `Compact-3DGS` model (.npz), checkpoint of `DirectVoxGO` (.tar) or `TensoRF` (.th),
    /// Instant-NGP snapshot (.ingp, .msgpack) or description (.toml)
    #[arg(long, value_name = "SCENE")]
    pub(crate) scene: Option<String>,
    /// Camera file in the OpenCV convention, instead of the scene's camera
    #[arg(long, value_name = "FILE")]
    camera: Option<PathBuf>,
    /// Which camera of the file, from 0
    #[arg(long, value_name = "N", default_value_t = 0, requires = "camera")]
    camera_index: usize,
    /// Pixels a row; the height follows unless given
    #[arg(long, value_name = "PIXELS")]
    width: Option<u32>,
    /// Rows
    #[arg(long, value_name = "PIXELS")]
    height: Option<u32>,
}

/// Says in one line what a run does not check.
pub(crate) fn say_not_checked(list: &[String]) {
    say!("  not checked: {}", list.join("; "));
}

/// The scene of a command that names none.
const DEFAULT: &str = "garden";

impl SceneArgs {
    pub(crate) fn open(&self) -> Result<Scene, Failure> {
        self.open_named(self.name())
    }

    /// The same of another scene.
    pub(crate) fn open_named(&self, name: &str) -> Result<Scene, Failure> {
        let mut scene = Scene::open(name)?;
        if let Some(path) = &self.camera {
            scene.set_camera_file(path, self.camera_index)?;
        }
        scene.set_size(self.width, self.height)?;
        Ok(scene)
    }

    /// Whether a camera or a size is asked for that is not the scene's own.
    pub(crate) const fn looks_otherwise(&self) -> bool {
        self.camera.is_some() || self.width.is_some() || self.height.is_some()
    }

    pub(crate) fn name(&self) -> &str {
        self.scene.as_deref().unwrap_or(DEFAULT)
    }

    /// How the scene is named on a command line.
    pub(crate) fn arguments(&self) -> String {
        let mut text = format!(" --scene {}", quoted(Path::new(self.name())));
        // Writing to a string does not fail.
        if let Some(path) = &self.camera {
            let _ = write!(text, " --camera {}", quoted(path));
        }
        if self.camera_index != 0 {
            let _ = write!(text, " --camera-index {}", self.camera_index);
        }
        for (name, side) in [("width", self.width), ("height", self.height)] {
            if let Some(side) = side {
                let _ = write!(text, " --{name} {side}");
            }
        }
        text
    }
}
