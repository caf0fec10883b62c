//! Rendering of any scene, in floating point or through units.

use std::borrow::Cow;
use std::collections::BTreeMap;

use potamoi_formats::config::{Config, ExpBase, ExpOutput};
use potamoi_formats::record::RECORD_CHANNELS;
use potamoi_formats::rit::Vertices;
use potamoi_formats::units::OpCode;
use serde::Serialize;

use super::{Kind, Model, Scene, SceneError};
use crate::analytic::Analytic;
use crate::camera::Camera;
use crate::effects::{Altered, Effect};
use crate::fields::{self, Field, FixedField};
use crate::mask::Mask;
use crate::picture::Picture;
use crate::splats::{self, Cells, Cloud, Decisions, Flips, Octree, Partition};
use crate::streams::{Streams, UnitStreams};
use crate::units::Units;
use crate::voxels::{self, Facing, Halo, MVoxels, Placement, Volume};

/// The most pixels of a picture.
const MAX_PIXELS: u64 = 1 << 26;

/// Bits of opacities of 64-bit floating point that its rounding leaves.
pub(super) const FLOAT_BITS: u32 = 48;

/// What the units did for a frame, by the renderer's own count.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize)]
pub struct FrameCounts {
    /// Rays of fields; pixels of splats.
    pub rays: u64,
    /// Samples along rays, gathered or not; none of splats.
    pub samples: u64,
    /// MVoxels gathered, over all ray groups.
    pub mvoxels: u64,
    /// Feature vectors out of the gathering unit, one a RIT entry that has all
    /// its vertices.
    pub feature_vectors: u64,
    /// Elements out of the vector unit, by operation.
    pub elements: BTreeMap<OpCode, u64>,
    /// Bytes, stream by stream.
    pub streams: Streams,
    /// Of the bytes of MVoxels, those that were fetched row by row: of tables that
    /// do not stream, and of splats' MVoxels of which a ray group uses little.
    pub scattered_bytes: u64,
    /// The first table of a field, from 1, from which on most samples are gathered
    /// row by row, and how many tables there are.
    pub reverts: Option<[usize; 2]>,
    /// Of splats alone.
    pub splats: Option<SplatCounts>,
}

/// What the order of splats took and what their records could not hold.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct SplatCounts {
    /// Gaussians of the model.
    pub gaussians: u64,
    /// Those that touch a tile.
    pub visible: u64,
    /// (tile, Gaussian) pairs.
    pub pairs: u64,
    /// The most records held back at once, in exact order.
    pub records_held: u64,
    /// The most (tile, Gaussian) entries of them.
    pub entries_held: u64,
    /// Records that went to memory and came back because more were held than
    /// fit on chip.
    pub records_spilled: u64,
    /// The (tile, Gaussian) entries of those records.
    pub entries_spilled: u64,
    /// Entries that arrived at their tile after one of a higher rank, in
    /// approximate order.
    pub inversions: u64,
    /// Values of records held at a limit of their format.
    pub saturated: u64,
}

impl FrameCounts {
    /// Adds what was gathered and computed of vertices.
    fn add(&mut self, stats: voxels::FixedStats) {
        self.rays += stats.rays;
        self.samples += stats.samples;
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
    /// The picture, background included.
    pub picture: Picture,
    /// Whether anything was drawn at a pixel.
    pub covered: Vec<bool>,
    /// What the units did; nothing in floating point.
    pub counts: FrameCounts,
    decisions: Option<Decisions>,
}

impl Rendered {
    /// Skips and stops in which two renderings of splats differ.
    #[must_use]
    pub fn flips(&self, other: &Self) -> Option<Flips> {
        self.decisions.as_ref()?.flips(other.decisions.as_ref()?)
    }
}

impl Scene {
    /// Renders in 64-bit floating point.
    ///
    /// # Errors
    /// A camera or an option that is not sensible.
    pub fn render_float(&self) -> Result<Rendered, SceneError> {
        self.floating().map_err(|e| e.of(&self.name))
    }

    fn floating(&self) -> Result<Rendered, SceneError> {
        match self.model.kind() {
            Kind::Splats(cloud) => {
                let options = splats::FloatOptions {
                    background: self.background,
                    log_decisions: true,
                    depth: false,
                    work: self.splat_work(),
                };
                let frame = splats::render_float(
                    &self.seen_from(cloud, &self.camera),
                    &self.camera,
                    self.profile,
                    &options,
                )?;
                Ok(Rendered {
                    decisions: frame.decisions,
                    ..floated(frame.picture, &frame.transmittance)
                })
            }
            Kind::Voxels(grid) => {
                let options = voxels::FloatOptions {
                    step: self.step,
                    background: self.background,
                    terminate: self.stops(FLOAT_BITS),
                    stop_below: self.voxel_options().stop_below,
                    directions: self.voxel_directions(),
                };
                let frame = voxels::render_float(grid, &self.camera, &options)?;
                Ok(floated(frame.picture, &frame.transmittance))
            }
            Kind::Field(field) => {
                let frame = fields::render_float(field, &self.camera, self.background)?;
                Ok(floated(frame.picture, &frame.transmittance))
            }
        }
    }

    /// The merged partition of splats into MVoxels of at most `rows` Gaussians;
    /// nothing for other models.
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

    /// Renders the analytic field that a built-in model was sampled from: what
    /// every picture of the model is an approximation of.
    ///
    /// # Errors
    /// A model without such a field, or a picture of more than 2^26 pixels.
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

    /// Renders in the hardware's formats: every gather and every vector
    /// operation goes through `units`, which are those of `config`.
    ///
    /// # Errors
    /// A configuration that cannot hold the scene, a camera or an option that is
    /// not sensible, or a unit that fails.
    pub fn render_fixed(
        &self,
        config: &Config,
        units: &mut dyn Units,
    ) -> Result<Rendered, SceneError> {
        self.render_chosen(config, None, units)
    }

    /// The same of some pixels, the others being background; their bits are those of the whole
    /// frame.
    ///
    /// # Errors
    /// As [`Scene::render_fixed`], and for a mask of another size than the camera's.
    pub fn render_fixed_masked(
        &self,
        config: &Config,
        only: &Mask,
        units: &mut dyn Units,
    ) -> Result<Rendered, SceneError> {
        self.render_chosen(config, Some(only), units)
    }

    fn render_chosen(
        &self,
        config: &Config,
        only: Option<&Mask>,
        units: &mut dyn Units,
    ) -> Result<Rendered, SceneError> {
        let rendered = self.powers_of_e(config).and_then(|()| {
            if !Altered::is_asked_for(self.choices) {
                return self.through(config, only, units);
            }
            let mut altered = Altered::new(units, config, self.choices);
            self.through(config, only, &mut altered)
        });
        rendered.map_err(|e| e.of(&self.name))
    }

    /// Operands are made for `exp(-u)`, results read as its code.
    fn powers_of_e(&self, config: &Config) -> Result<(), SceneError> {
        let exp = &config.vu.exp;
        let (field, value, expected) = if exp.base != ExpBase::E {
            ("vu.exp.base", "two", "\"e\"")
        } else if exp.output != ExpOutput::Alpha {
            ("vu.exp.output", "general", "\"alpha\"")
        } else {
            return Ok(());
        };
        Err(SceneError::Config {
            scene: self.name.clone(),
            field,
            value: value.to_owned(),
            expected: expected.to_owned(),
        })
    }

    fn through(
        &self,
        config: &Config,
        only: Option<&Mask>,
        units: &mut dyn Units,
    ) -> Result<Rendered, SceneError> {
        match &self.model {
            Model::Splats(cloud) => self.splats_fixed(cloud, config, only, units),
            Model::Compact(model) => {
                let eye = self.camera.position();
                let (cloud, stats) = model.seen_in_codes(eye, config, self.field_work(), units)?;
                let mut rendered = self.splats_fixed(&cloud, config, only, units)?;
                rendered.counts.add(stats);
                Ok(rendered)
            }
            Model::Voxels(grid) => {
                let mvoxels = self.cut(MVoxels::new(grid, config)?);
                let options = voxels::FixedOptions {
                    terminate: self.stops(config.vu.exp.output_bits),
                    skip: self.skip(&mvoxels),
                    ..self.voxel_options()
                };
                let mut head = voxels::stored(grid, &mvoxels, &options)?;
                head.directions = self.voxel_directions();
                let volume = Volume {
                    mvoxels: &mvoxels,
                    placement: Placement::of(grid),
                    head: &head,
                };
                let (camera, options) = (&self.camera, &options);
                let frame = voxels::render_volume_masked(&volume, camera, options, only, units)?;
                Ok(rendered(frame))
            }
            Model::Tensorf(field) => self.render_tables(&**field, config, only, units),
            Model::Field(field) => self.render_tables(&**field, config, only, units),
            Model::Dvgo(field) => {
                let made = field.fixed(config)?;
                let mut mvoxels = self.cut(made.mvoxels().clone());
                if self.choices.leaves_out(Effect::VoidTest) {
                    mvoxels = mvoxels.unmasked();
                }
                let facing = Facing {
                    head: made.head(),
                    kept: self.field_work().direction_codes,
                };
                let volume = Volume {
                    mvoxels: &mvoxels,
                    placement: made.placement(),
                    head: &facing,
                };
                let options = voxels::FixedOptions {
                    terminate: self.stops(config.vu.exp.output_bits),
                    skip: self.skip(&mvoxels),
                    ..self.voxel_options()
                };
                let (camera, options) = (&self.camera, &options);
                let frame = voxels::render_volume_masked(&volume, camera, options, only, units)?;
                Ok(rendered(frame))
            }
        }
    }

    pub(crate) fn splat_options(&self, config: &Config) -> splats::FixedOptions {
        let rows = config.mvoxel_capacity(Vertices::One, RECORD_CHANNELS) as usize;
        splats::FixedOptions {
            schedule: splats::ScheduleOptions {
                rows,
                group_tiles: self.group_tiles,
                cells: Cells {
                    merge: self.merges_cells(rows),
                    ..self.cells
                },
            },
            background: self.background,
            order: self.order,
            unit_streams: UnitStreams::of(config),
            log_decisions: true,
            widths: splats::Widths {
                power: config.vu.exp.input.frac_bits(),
                exponential: config.vu.exp.output_bits,
            },
            work: self.splat_work(),
            ..splats::FixedOptions::default()
        }
    }

    fn cut(&self, shared: MVoxels) -> MVoxels {
        match self.halo {
            Halo::Shared => shared,
            Halo::Split => shared.with_halo(Halo::Split),
        }
    }

    fn render_tables(
        &self,
        field: &dyn Field,
        config: &Config,
        only: Option<&Mask>,
        units: &mut dyn Units,
    ) -> Result<Rendered, SceneError> {
        let options = fields::FixedOptions {
            background: self.background,
            group_side: self.group_side,
            terminate: self.stops(config.vu.exp.output_bits),
            work: self.field_work(),
            ..fields::FixedOptions::default()
        };
        let made = FixedField::with_halo(field, config, self.halo)?;
        let frame = made.render_masked(&self.camera, &options, only, units)?;
        Ok(rendered(frame))
    }

    /// Gaussians in the colours of a camera's side.
    pub(super) fn seen_from<'a>(&'a self, cloud: &'a Cloud, camera: &Camera) -> Cow<'a, Cloud> {
        match &self.model {
            Model::Compact(model) => Cow::Owned(model.seen_from(camera.position())),
            _ => Cow::Borrowed(cloud),
        }
    }

    fn splats_fixed(
        &self,
        cloud: &Cloud,
        config: &Config,
        only: Option<&Mask>,
        units: &mut dyn Units,
    ) -> Result<Rendered, SceneError> {
        self.check_splats(config)?;
        let options = self.splat_options(config);
        let (camera, profile) = (&self.camera, self.profile);
        let frame = splats::render_fixed_masked(cloud, camera, profile, &options, only, units)?;
        let clear = 1 << splats::TRANSMITTANCE.frac_bits();
        let covered: Vec<bool> = frame.transmittance.iter().map(|t| *t < clear).collect();
        Ok(Rendered {
            picture: frame.picture,
            counts: FrameCounts {
                rays: only.map_or(covered.len(), Mask::count) as u64,
                samples: 0,
                mvoxels: frame.stats.tasks,
                feature_vectors: frame.stats.gathers,
                elements: frame.stats.vector_elements,
                streams: frame.stats.streams,
                scattered_bytes: frame.stats.scattered_bytes,
                reverts: None,
                splats: Some(SplatCounts {
                    gaussians: cloud.len() as u64,
                    visible: frame.stats.visible,
                    pairs: frame.stats.gathers,
                    records_held: frame.stats.hold.occupancy,
                    entries_held: frame.stats.hold.entries,
                    records_spilled: frame.stats.hold.spilled,
                    entries_spilled: frame.stats.hold.spilled_entries,
                    inversions: frame.stats.inversions,
                    saturated: frame.stats.saturations.total(),
                }),
            },
            decisions: frame.decisions,
            covered,
        })
    }

    pub(super) fn voxel_options(&self) -> voxels::FixedOptions {
        let own = voxels::FixedOptions::default();
        voxels::FixedOptions {
            step: self.step,
            background: self.background,
            group_side: self.group_side,
            stop_below: self.precision.stop_below.unwrap_or(own.stop_below),
            transmittance_bits: (self.precision.transmittance_bits)
                .unwrap_or(own.transmittance_bits),
            ..own
        }
    }

    /// Records are codes of 16 bits, and take so many channels.
    fn check_splats(&self, config: &Config) -> Result<(), SceneError> {
        let refuse = |field, value: String, expected: String| {
            Err(SceneError::Config {
                scene: self.name.clone(),
                field,
                value,
                expected,
            })
        };
        if config.gu.feature_bits != 16 {
            let bits = config.gu.feature_bits.to_string();
            return refuse(
                "gu.feature_bits",
                bits,
                "16: splat records are 16-bit codes".to_owned(),
            );
        }
        let exp = &config.vu.exp;
        if exp.input.int_bits() < 3 {
            let expected = "three or more integer bits: exp(-8) is the first that is skipped";
            let input = exp.input.to_string();
            return refuse("vu.exp.input", input, expected.to_owned());
        }
        if !(8..=24).contains(&exp.output_bits) {
            let expected = "8 to 24 bits of opacity".to_owned();
            return refuse("vu.exp.output_bits", exp.output_bits.to_string(), expected);
        }
        let segments = config.segments(RECORD_CHANNELS);
        if segments > config.gu.segments as usize {
            let expected = format!(
                "{segments} or more: a splat record's {RECORD_CHANNELS} channels take that many \
                 with gu.banks = {}",
                config.gu.banks
            );
            return refuse("gu.segments", config.gu.segments.to_string(), expected);
        }
        Ok(())
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

fn rendered(frame: voxels::FixedFrame) -> Rendered {
    let clear = 1 << voxels::TRANSMITTANCE.frac_bits();
    let mut counts = FrameCounts::default();
    counts.add(frame.stats);
    Rendered {
        picture: frame.picture,
        covered: frame.transmittance.iter().map(|t| *t < clear).collect(),
        counts,
        decisions: None,
    }
}
