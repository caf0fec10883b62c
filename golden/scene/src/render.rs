//! Rendering of any scene in floating point, and rendered frames.

use std::borrow::Cow;
use std::collections::BTreeMap;

use potamoi_formats::units::OpCode;
use schemars::JsonSchema;
use serde::Serialize;

use super::{Kind, Model, Scene, SceneError};
use potamoi_analytic::Analytic;
use potamoi_base::camera::Camera;
use potamoi_base::picture::Picture;
use potamoi_fields as fields;
use potamoi_gaussians::Cloud;
use potamoi_march::SampleOutcomes;
use potamoi_march::streams::Streams;
use potamoi_splats::{self as splats, Decisions, Flips, Octree, PairTest, Partition};

/// Maximum number of pixels in a picture.
const MAX_PIXELS: u64 = 1 << 26;

/// Work of the units for a frame, as the renderer counts it.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, JsonSchema)]
pub struct FrameCounts {
    /// Rays of fields; pixels of splats.
    pub rays: u64,
    /// Samples along rays, whether gathered or not; 0 for splats.
    pub samples: u64,
    /// Gathered samples by what they change; `None` for splats.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sample_outcomes: Option<SampleOutcomes>,
    /// MVoxels gathered, over all ray groups.
    pub mvoxels: u64,
    /// Feature vectors that the gathering unit returned, one for each RIT entry that has all its
    /// vertices.
    pub feature_vectors: u64,
    /// Elements that the vector unit returned, by operation.
    pub elements: BTreeMap<OpCode, u64>,
    /// Bytes by stream.
    pub streams: Streams,
    /// MVoxel bytes that were fetched row by row: of tables that do not stream, and of splat
    /// MVoxels of which a ray group uses little.
    pub scattered_bytes: u64,
    /// The first table of a field, counted from 1, from which on most samples are gathered row by
    /// row, and the number of tables.
    pub reverts: Option<[usize; 2]>,
    /// Counts of splats.
    pub splats: Option<SplatCounts>,
}

/// Statistics of splats: sorting, compositing, reorder buffer and saturation.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, JsonSchema)]
pub struct SplatCounts {
    /// Number of Gaussians in the model.
    pub gaussians: u64,
    /// Gaussians that touch a tile.
    pub visible: u64,
    /// (tile, Gaussian) pairs that are listed.
    pub pairs: u64,
    /// Pairs of the profile's list that were tested, and those that were left out; `None` where none is
    /// tested.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pair_test: Option<PairTest>,
    /// (pixel, Gaussian) pairs whose power is computed, whether they count or not.
    pub pairs_evaluated: u64,
    /// (pixel, Gaussian) pairs whose exponential is computed: all of them without a splat unit, those
    /// that the stored limits keep with one.
    pub exponentials: u64,
    /// With a splat unit, the pairs within the exact limit of their opacity: those that draw or stop
    /// a pixel, and no others, if the exponential never rises.
    pub within_exact_limit: Option<u64>,
    /// (pixel, Gaussian) pairs that contribute to a pixel.
    pub pairs_drawn: u64,
    /// (pixel, Gaussian) pairs at which a pixel terminates early: they count, and are not drawn.
    pub pairs_stopped: u64,
    /// Peak number of records in the reorder buffer, in exact order.
    pub records_held: u64,
    /// Peak number of their (tile, Gaussian) entries.
    pub entries_held: u64,
    /// Records written to memory and read back because the reorder buffer was full.
    pub records_spilled: u64,
    /// The (tile, Gaussian) entries of spilled records.
    pub entries_spilled: u64,
    /// Entries that reached their tile after one of a higher rank, in approximate order.
    pub inversions: u64,
    /// Record values that saturated.
    pub saturated: u64,
}

impl FrameCounts {
    /// Adds the counts of a ray-marched frame.
    pub(super) fn add(&mut self, stats: potamoi_march::FixedStats) {
        self.rays += stats.rays;
        self.samples += stats.samples;
        let earlier = self.sample_outcomes.unwrap_or_default();
        self.sample_outcomes = Some(earlier + stats.outcomes);
        self.mvoxels += stats.tasks;
        self.feature_vectors += stats.entries - stats.split_entries;
        self.streams = self.streams + stats.streams;
        self.scattered_bytes += stats.scattered_bytes;
        let tables = stats.orders.len();
        self.reverts = stats.reverts_from().map(|first| [first, tables]);
        for (op, elements) in stats.vector_elements {
            *self.elements.entry(op).or_default() += elements;
        }
    }
}

/// A rendered frame.
#[derive(Debug, Clone, PartialEq)]
pub struct Rendered {
    /// The picture, including the background.
    pub picture: Picture,
    /// Whether a pixel is covered by anything.
    pub covered: Vec<bool>,
    /// Work of the units; zero in floating point.
    pub counts: FrameCounts,
    pub(super) decisions: Option<Decisions>,
}

impl Rendered {
    /// Numbers of skips and stops that differ between two renderings of splats; `None` unless both
    /// kept their decisions.
    #[must_use]
    pub fn flips(&self, other: &Self) -> Option<Flips> {
        self.decisions.as_ref()?.flips(other.decisions.as_ref()?)
    }
}

impl Scene {
    /// Renders in 64-bit floating point, with the decisions that [`Rendered::flips`] compares.
    ///
    /// # Errors
    /// The camera or an option is out of range.
    pub fn render_float(&self) -> Result<Rendered, SceneError> {
        self.floating(true).map_err(|e| e.of(&self.name))
    }

    /// As [`Scene::render_float`], without decisions: the same picture, sooner.
    ///
    /// # Errors
    /// Those of [`Scene::render_float`].
    pub fn render_float_picture(&self) -> Result<Rendered, SceneError> {
        self.floating(false).map_err(|e| e.of(&self.name))
    }

    fn floating(&self, log_decisions: bool) -> Result<Rendered, SceneError> {
        match self.model.kind() {
            Kind::Splats(cloud) => {
                let cloud = self.seen_from(cloud, &self.camera);
                let options = splats::FloatOptions {
                    background: self.background,
                    log_decisions,
                    work: self.splat_work_of_one_frame(&cloud),
                    ..splats::FloatOptions::default()
                };
                let frame = splats::render_float(&cloud, &self.camera, self.profile, &options)?;
                Ok(Rendered {
                    decisions: frame.decisions,
                    ..floated(frame.picture, &frame.transmittance)
                })
            }
            Kind::Field(field) => {
                let options = self.float_options(field);
                let field = self.stopping(field);
                let frame = fields::render_masked(&field, &self.camera, &options, None)?;
                Ok(floated(frame.picture, &frame.transmittance))
            }
        }
    }

    /// The Gaussians with the colours that a camera sees.
    pub(super) fn seen_from<'a>(&'a self, cloud: &'a Cloud, camera: &Camera) -> Cow<'a, Cloud> {
        match self.model() {
            Model::Compact(model) => Cow::Owned(model.seen_from(camera.position())),
            _ => Cow::Borrowed(cloud),
        }
    }

    /// The merged partition of splats into MVoxels of at most `rows` Gaussians; `None` for other
    /// models.
    #[must_use]
    pub fn octree(&self, rows: usize) -> Option<Octree> {
        let Kind::Splats(cloud) = self.model.kind() else {
            return None;
        };
        Some(Octree::merge(
            cloud,
            &Partition::halved(cloud, rows, self.cells.halvings),
            rows,
        ))
    }

    /// Renders the ground truth: the analytic field that a built-in model was sampled from.
    ///
    /// # Errors
    /// The model has no such field, or the picture has more than 2^26 pixels.
    pub fn render_truth(&self) -> Result<Rendered, SceneError> {
        let refuse = |field, value: String, expected: String| {
            Err(SceneError::Value {
                scene: self.name.clone(),
                field,
                value,
                expected,
            })
        };
        let Some(analytic) = self.truth else {
            let expected = format!(
                "another: only {} have one",
                Analytic::ALL.map(Analytic::name).join(", ")
            );
            return refuse(
                "ground truth",
                "not known of this model".to_owned(),
                expected,
            );
        };
        let [width, height] = [self.camera.width, self.camera.height];
        if u64::from(width) * u64::from(height) > MAX_PIXELS {
            let expected = format!("at most {MAX_PIXELS} pixels");
            return refuse("width x height", format!("{width} x {height}"), expected);
        }
        let truth = analytic.truth(&self.camera, self.background);
        Ok(floated(truth.picture, &truth.transmittance))
    }
}

fn floated(picture: Picture, transmittance: &[f64]) -> Rendered {
    Rendered {
        picture,
        covered: transmittance.iter().map(|t| *t < 1.0).collect(),
        counts: FrameCounts::default(),
        decisions: None,
    }
}
