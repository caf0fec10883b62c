//! Effects that a scene and a camera path need, with evidence.

use potamoi_formats::config::Config;
use potamoi_formats::record::RECORD_CHANNELS;
use potamoi_formats::rit::Vertices;

use super::evidence::EvidenceInputs;
use super::surroundings::Surroundings;
use super::{PathVisibility, is_still};
use potamoi_base::camera::Camera;
use potamoi_base::effects::Effect;
use potamoi_scene::{Kind, Scene, SceneError};
use potamoi_splats::{Schedule, Sorting, View, Work, is_in_order};
use potamoi_warp::Renderer as _;

/// Whether an effect is needed.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Finding {
    /// The effect.
    pub effect: Effect,
    /// Whether the scene and the path can need it.
    pub is_called_for: bool,
    /// The evidence, with numbers.
    pub evidence: String,
}

/// The findings for a scene along a path.
#[derive(Debug, Clone, PartialEq)]
pub struct Analysis {
    /// Findings in the order of [`Effect::ALL`].
    pub findings: Vec<Finding>,
    /// What the cameras see.
    pub seen: PathVisibility,
}

impl Analysis {
    /// Analyses a scene's data and what the cameras of a path see of it, for a configuration.
    /// Nothing is rendered.
    ///
    /// # Errors
    /// The configuration cannot hold the scene, or a camera is invalid.
    pub fn of(
        scene: &Scene,
        path: &[Camera],
        config: &Config,
        around: Surroundings,
    ) -> Result<Self, SceneError> {
        let facts = scene.facts();
        let mut seen = PathVisibility::moved(path);
        let rows = config.mvoxel_capacity(Vertices::One, RECORD_CHANNELS) as usize;
        let mut before: Option<&Camera> = None;
        let mut last = PathVisibility::default();
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
        let known = EvidenceInputs {
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

    /// Whether an effect is needed.
    #[must_use]
    pub fn calls_for(&self, effect: Effect) -> bool {
        let found = self.findings.iter().find(|f| f.effect == effect);
        found.is_some_and(|f| f.is_called_for)
    }

    /// The evidence that an effect is or is not needed.
    #[must_use]
    pub fn evidence(&self, effect: Effect) -> &str {
        let found = self.findings.iter().find(|f| f.effect == effect);
        found.map_or("", |f| &f.evidence)
    }
}

/// What a camera sees, determined without rendering.
fn seen_by(scene: &Scene, camera: &Camera, config: &Config) -> Result<PathVisibility, SceneError> {
    let mut seen = PathVisibility::default();
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

/// Number of empty cells and of all cells: of voxels, or of a field's grid that marks empty space.
fn void_cells(scene: &Scene, config: &Config) -> Result<Option<[u64; 2]>, SceneError> {
    Ok(match scene.model().kind() {
        Kind::Field(field) => match field.stored() {
            Some(stored) => Some(stored.void_cells(config)?),
            None => field.void(),
        },
        Kind::Splats(_) => None,
    })
}
