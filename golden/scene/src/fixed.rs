//! Fixed-point rendering of any scene through the units.

use potamoi_formats::config::{Config, ExpBase, ExpOutput};
use potamoi_formats::record::RECORD_CHANNELS;
use potamoi_formats::rit::Vertices;

use super::render::{FrameCounts, Rendered, SplatCounts};
use super::{Model, Scene, SceneError};
use potamoi_base::mask::Mask;
use potamoi_fields::{self as fields, Field, FixedField, WithEarlyTermination};
use potamoi_march::streams::UnitStreams;
use potamoi_reference::AblatedUnits;
use potamoi_reference::Units;
use potamoi_splats::{self as splats, Cells, Cloud};

impl Scene {
    /// Renders in the hardware's formats: every gather and every vector operation goes through
    /// `units`, which must be those of `config`.
    ///
    /// # Errors
    /// The configuration cannot hold the scene, the camera or an option is out of range, or a unit
    /// fails.
    pub fn render_fixed(
        &self,
        config: &Config,
        units: &mut dyn Units,
    ) -> Result<Rendered, SceneError> {
        self.render_chosen(config, None, units)
    }

    /// As [`Scene::render_fixed`], but renders only the pixels of a mask, bit for bit as in the
    /// whole frame; the others are background.
    ///
    /// # Errors
    /// Those of [`Scene::render_fixed`], or the mask does not have the camera's size.
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
            if !AblatedUnits::is_asked_for(self.choices) {
                return self.through(config, only, units);
            }
            let mut altered = AblatedUnits::new(units, config, self.choices);
            self.through(config, only, &mut altered)
        });
        rendered.map_err(|e| e.of(&self.name))
    }

    /// Checks that the exponential has base e and alpha output: operands are prepared for
    /// `exp(-u)`, and results are read as its codes.
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
        match self.model() {
            Model::Splats(cloud) => self.splats_fixed(cloud, config, only, units),
            Model::Compact(model) => {
                let eye = self.camera.position();
                let (cloud, stats) = model.seen_in_codes(eye, config, self.field_work(), units)?;
                let mut rendered = self.splats_fixed(&cloud, config, only, units)?;
                rendered.counts.add(stats);
                Ok(rendered)
            }
            Model::Field(field) => self.field_fixed(&**field, config, only, units),
        }
    }

    /// Options of the splat renderer for a configuration.
    #[must_use]
    pub fn splat_options(&self, config: &Config) -> splats::FixedOptions {
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

    fn field_fixed(
        &self,
        field: &dyn Field,
        config: &Config,
        only: Option<&Mask>,
        units: &mut dyn Units,
    ) -> Result<Rendered, SceneError> {
        let options = fields::FixedOptions {
            background: self.background,
            group_side: self.group_side,
            terminate: self.stops(self.lost_a_sample(config)?),
            transmittance_bits: self.transmittance_bits(),
            work: self.field_work(),
            ..fields::FixedOptions::default()
        };
        let field = self.stopping(field);
        let made = FixedField::with_halo(&field, config, self.halo)?;
        let frame = made.render_masked(&self.camera, &options, only, units)?;
        Ok(rendered(frame))
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
                    pairs_evaluated: frame.stats.evaluated,
                    pairs_drawn: frame.stats.drawn,
                    pairs_stopped: frame.stats.stopped,
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

    /// A field with the scene's early-termination threshold.
    pub(super) fn stopping<'a>(&self, field: &'a dyn Field) -> WithEarlyTermination<'a> {
        WithEarlyTermination::new(field, self.precision.stop_below)
    }

    /// Checks that records fit: they take 16-bit codes and a fixed number of channels.
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

fn rendered(frame: potamoi_march::FixedFrame) -> Rendered {
    let clear = 1 << potamoi_march::TRANSMITTANCE.frac_bits();
    let mut counts = FrameCounts::default();
    counts.add(frame.stats);
    Rendered {
        picture: frame.picture,
        covered: frame.transmittance.iter().map(|t| *t < clear).collect(),
        counts,
        decisions: None,
    }
}
