//! Which effects a scene and a camera path call for, and the evidence.

use potamoi_formats::config::Config;
use potamoi_formats::record::RECORD_CHANNELS;
use potamoi_formats::rit::Vertices;

use super::evidence::Known;
use super::surroundings::Surroundings;
use super::{Seen, is_still};
use potamoi_base::camera::Camera;
use potamoi_base::effects::Effect;
use potamoi_fields::voxels::MVoxels;
use potamoi_scene::{Kind, Scene, SceneError};
use potamoi_splats::{Schedule, Sorting, View, Work, is_in_order};
use potamoi_warp::Renderer as _;

/// An effect, and whether it is called for.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Finding {
    /// The effect.
    pub effect: Effect,
    /// Whether the scene and the path can need it.
    pub is_called_for: bool,
    /// What in the data says so, with numbers.
    pub evidence: String,
}

/// Every effect of a scene along a path.
#[derive(Debug, Clone, PartialEq)]
pub struct Analysis {
    /// Effects, as in [`Effect::ALL`].
    pub findings: Vec<Finding>,
    /// What the cameras see.
    pub seen: Seen,
}

impl Analysis {
    /// Looks at a scene's data and at what cameras of a path see of it in a configuration.
    /// Nothing is rendered.
    ///
    /// # Errors
    /// A configuration that cannot hold the scene, or a camera that cannot be used.
    pub fn of(
        scene: &Scene,
        path: &[Camera],
        config: &Config,
        around: Surroundings,
    ) -> Result<Self, SceneError> {
        let facts = scene.facts();
        let mut seen = Seen::moved(path);
        let rows = config.mvoxel_capacity(Vertices::One, RECORD_CHANNELS) as usize;
        let mut before: Option<&Camera> = None;
        let mut last = Seen::default();
        for camera in path {
            // What stands still shows the same again.
            if before != Some(camera) {
                last = seen_by(scene, camera, config)?;
            }
            before = Some(camera);
            seen.in_view += last.in_view;
            seen.met += last.met;
            seen.unsorted += last.unsorted;
            seen.fetched_bytes += last.fetched_bytes;
        }
        let known = Known {
            scene,
            facts,
            seen,
            config,
            around,
            is_still: is_still(path),
            void: void_cells(scene, config)?,
            merged: scene.merged_cells(rows).filter(|_| scene.cells().merge),
        };
        let findings = Effect::ALL.map(|effect| {
            let (is_called_for, evidence) = known.finding(effect);
            Finding {
                effect,
                is_called_for,
                evidence,
            }
        });
        Ok(Self {
            findings: findings.to_vec(),
            seen,
        })
    }

    /// Whether an effect is called for.
    #[must_use]
    pub fn calls_for(&self, effect: Effect) -> bool {
        let found = self.findings.iter().find(|f| f.effect == effect);
        found.is_some_and(|f| f.is_called_for)
    }

    /// What says that an effect is called for, or is not.
    #[must_use]
    pub fn evidence(&self, effect: Effect) -> &str {
        let found = self.findings.iter().find(|f| f.effect == effect);
        found.map_or("", |f| &f.evidence)
    }
}

/// What a camera sees, without rendering it.
fn seen_by(scene: &Scene, camera: &Camera, config: &Config) -> Result<Seen, SceneError> {
    let mut seen = Seen::default();
    let Some(cloud) = scene.cloud() else {
        if let Some(bounds) = scene.bounds() {
            seen.cross(camera, bounds);
        }
        return Ok(seen);
    };
    seen.unsorted = usize::from(!is_in_order(cloud, camera, scene.profile())?);
    // Where they lie, whatever their colours.
    let work = Work {
        degree: 0,
        sorting: Sorting::IfNeeded,
        stops: false,
        precision: scene.precision(),
    };
    let view = View::by(cloud, camera, scene.profile(), &work)?;
    seen.met = view.entries() as u64;
    seen.in_view = usize::from(seen.met > 0);
    let schedule = Schedule::new(cloud, &view, &scene.splat_options(config).schedule)?;
    let groups = (0..schedule.groups()).filter_map(|number| schedule.group(number));
    seen.fetched_bytes = groups.map(|group| group.scattered_bytes()).sum();
    Ok(seen)
}

/// Cells of voxels in which nothing is, and all; of other fields those of the grid that says
/// so.
fn void_cells(scene: &Scene, config: &Config) -> Result<Option<[u64; 2]>, SceneError> {
    Ok(match scene.model().kind() {
        Kind::Voxels(grid) => Some(MVoxels::new(grid, config)?.void_cells()),
        Kind::Field(field) => field.void(),
        Kind::Splats(_) => None,
    })
}
