//! Scenes: built-in ones, model files and scene descriptions.
//!
//! ```
//! use potamoi_scene::Scene;
//!
//! let mut scene = Scene::open("garden")?;
//! scene.set_size(Some(16), Some(12))?;
//! let rendered = scene.render_float()?;
//! assert_eq!((rendered.picture.width, rendered.picture.height), (16, 12));
//! # Ok::<(), potamoi_scene::SceneError>(())
//! ```

mod bound;
mod built_models;
mod builtin;
pub mod camera_file;
mod camera_path;
mod camera_setup;
pub mod characterise;
pub mod colmap;
pub mod compact_3dgs;
mod converged;
#[cfg(test)]
mod damaged_camera_files;
mod description;
mod effects;
mod empty_frames;
mod error;
mod exact_depth;
pub mod file_formats;
pub mod files_read;
mod fixed;
pub mod garden;
mod identity;
mod image_sequence;
mod lens_keys;
mod load;
mod memory_behaviour;
pub mod model_facts;
mod orbit;
mod picture_files;
mod ready_models;
mod recorded_motion;
mod render;
mod render_options;
mod scene_list;
pub mod surface;
#[cfg(test)]
mod tests;
pub mod trace;
pub mod trajectory;
pub mod transforms;
mod unverified_parts;
mod warp_renderer;

pub use builtin::BUILTIN;
pub use converged::{Converged, Halvings};
pub use error::SceneError;
pub use exact_depth::ExactDepth;
pub use image_sequence::Images;
pub use memory_behaviour::Characterised;
pub use orbit::Orbit;
pub use ready_models::{Representation, cloud as laid_splats};
pub use render::{FrameCounts, Rendered, SplatCounts};
pub use scene_list::scenes_named;

use std::sync::Arc;

use glam::DVec3;

use crate::compact_3dgs::Compact;
use crate::model_facts::Cache;
use crate::trajectory::Motion;
use potamoi_analytic::Analytic;
use potamoi_base::camera::Camera;
use potamoi_base::effects::Choices;
use potamoi_base::file_keys::Notes;
use potamoi_base::precision::{Models, Precision};
use potamoi_fields::{AnyField, Field, Size};
use potamoi_gaussians::{Axes, Cloud, Facts};
use potamoi_march::tiling::Halo;
use potamoi_splats::{Cells, Order, Profile};

/// What a scene shows.
#[derive(Debug, Clone, PartialEq)]
pub enum Model {
    /// 3D Gaussians.
    Splats(Cloud),
    /// 3D Gaussians coloured by a neural field, which is evaluated anew for every camera.
    Compact(Box<Compact>),
    /// A radiance field.
    Field(AnyField),
}

/// A model by its renderer.
pub enum Kind<'a> {
    /// Gaussians; with camera-dependent colours, the Gaussians without them.
    Splats(&'a Cloud),
    /// A field.
    Field(&'a dyn Field),
}

impl Model {
    /// The algorithm, by its usual name.
    #[must_use]
    pub fn algorithm(&self) -> &'static str {
        match (self, self.kind()) {
            (Self::Compact(_), _) => "Compact-3DGS",
            (_, Kind::Splats(_)) => "3DGS",
            (_, Kind::Field(field)) => field.algorithm().name,
        }
    }

    /// Table size in the configuration of the algorithm's authors, if one number states it. The
    /// colours of Compact-3DGS have 2^19 entries a level.
    #[must_use]
    pub fn full_size(&self) -> Option<Size> {
        match (self, self.kind()) {
            (Self::Compact(_), _) => Some(Size::Entries(1 << 19)),
            (_, Kind::Splats(_)) => None,
            (_, Kind::Field(field)) => field.algorithm().full_size,
        }
    }

    /// Whether its step is measured in voxel edges, so that [`Scene::set_step`] changes it.
    #[must_use]
    pub fn has_step(&self) -> bool {
        match self.kind() {
            Kind::Splats(_) => false,
            Kind::Field(field) => field.stepped().is_some(),
        }
    }

    /// The preset whose units support it.
    #[must_use]
    pub fn preset(&self) -> &'static str {
        match (self, self.kind()) {
            (Self::Compact(_), _) => "fields",
            (_, Kind::Splats(_)) => "paper",
            (_, Kind::Field(field)) => field.algorithm().preset,
        }
    }

    /// The numbers of a precision that its renderer honours.
    #[must_use]
    pub fn numbers(&self) -> Models {
        match self.kind() {
            Kind::Splats(_) => Models::Splats,
            Kind::Field(field) if field.stored().is_some() => Models::Voxels,
            Kind::Field(_) => Models::Fields,
        }
    }

    /// The model by its renderer.
    #[must_use]
    pub fn kind(&self) -> Kind<'_> {
        match self {
            Self::Splats(cloud) => Kind::Splats(cloud),
            Self::Compact(model) => Kind::Splats(model.gaussians()),
            Self::Field(field) => Kind::Field(&**field),
        }
    }
}

/// A model, a camera and render options.
#[derive(Debug, Clone, PartialEq)]
pub struct Scene {
    name: String,
    /// The model, shared by copies with other options.
    model: Arc<Model>,
    camera: Camera,
    /// The cameras of a camera file, from the chosen one on.
    path: Vec<Camera>,
    /// A recorded motion that the camera follows.
    motion: Option<Motion>,
    /// The vertical axis, for orbits.
    up: DVec3,
    background: [f32; 3],
    profile: Profile,
    order: Order,
    group_tiles: Option<[u32; 2]>,
    group_side: Option<u32>,
    halo: Halo,
    /// The division of splats into MVoxels.
    cells: Cells,
    step: f64,
    /// Whether the model was read from a file.
    from_file: bool,
    /// The requested axes of a splat file, if any.
    axes: Option<Axes>,
    /// Position of the model's origin in the file's world.
    origin: DVec3,
    /// What a splat file says of itself.
    file_facts: Option<Arc<Facts>>,
    /// Unused parts of the files, and assumptions.
    notes: Notes,
    /// The analytic field that a built-in model was sampled from.
    truth: Option<Analytic>,
    /// Effects that are forced or left out.
    choices: Choices,
    /// Thresholds and widths that override the rules'.
    precision: Precision,
    /// Cached facts about the model.
    found: Cache,
}

impl Scene {
    /// The built-in name or the file name.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The model.
    #[must_use]
    pub fn model(&self) -> &Model {
        &self.model
    }

    /// What the file of splats says of itself; `None` for other models.
    #[must_use]
    pub fn file_facts(&self) -> Option<&Facts> {
        self.file_facts.as_deref()
    }

    /// Position of the model's origin in the file's world.
    #[must_use]
    pub const fn origin(&self) -> DVec3 {
        self.origin
    }

    /// The vertical axis.
    #[must_use]
    pub const fn up(&self) -> DVec3 {
        self.up
    }

    /// Unused parts of the files, and assumptions.
    #[must_use]
    pub const fn notes(&self) -> &Notes {
        &self.notes
    }

    /// The camera.
    #[must_use]
    pub const fn camera(&self) -> &Camera {
        &self.camera
    }

    /// Background, linear RGB.
    #[must_use]
    pub const fn background(&self) -> [f32; 3] {
        self.background
    }

    /// The analytic field that the model was sampled from, if any.
    #[must_use]
    pub const fn analytic(&self) -> Option<Analytic> {
        self.truth
    }

    /// Sets the camera.
    pub fn set_camera(&mut self, camera: Camera) {
        self.camera = camera;
    }

    /// Sets the order in which splats are composited.
    pub fn set_order(&mut self, order: Order) {
        self.order = order;
    }

    /// Sets the rule set for splats.
    pub fn set_profile(&mut self, profile: Profile) {
        self.profile = profile;
        self.found = Cache::default();
    }

    /// The division of splats into MVoxels: by default the coarsest grid that fits, merged.
    #[must_use]
    pub const fn cells(&self) -> Cells {
        self.cells
    }

    /// Sets the division of splats into MVoxels.
    pub fn set_cells(&mut self, cells: Cells) {
        self.cells = cells;
    }

    /// The rule set for splats.
    #[must_use]
    pub const fn profile(&self) -> Profile {
        self.profile
    }
}
