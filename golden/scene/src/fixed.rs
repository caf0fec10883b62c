//! Fixed-point rendering of any scene through the units.

use potamoi_formats::config::{
    Config, ExpBase, ExpOutput, RitPairs, SplatOpacity, SuConfig, presets_that,
};
use potamoi_formats::record::RECORD_CHANNELS;
use potamoi_formats::rit::Vertices;
use potamoi_formats::units::OpCode;

use super::render::{FrameCounts, Rendered, SplatCounts};
use super::{Model, Scene, SceneError};
use potamoi_base::effects::Effect;
use potamoi_base::mask::Mask;
use potamoi_fields::{self as fields, Field, FixedField, WithEarlyTermination};
use potamoi_gaussians::Cloud;
use potamoi_march::streams::UnitStreams;
use potamoi_reference::AblatedUnits;
use potamoi_reference::Units;
use potamoi_splats::{self as splats, Cells, TileLimits};

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

    /// The splat unit that composites frames of splats; `None` where the vector unit does. Without its
    /// exponential there is no cut, so that the vector unit composites.
    pub(super) fn splat_unit<'c>(&self, config: &'c Config) -> Option<&'c SuConfig> {
        let su = config.su.as_ref();
        su.filter(|_| !self.choices.leaves_out(Effect::Exponential))
    }

    /// How opacities enter alphas: as the splat unit asks, or as factors on the vector unit.
    pub(super) fn opacity(&self, config: &Config) -> SplatOpacity {
        let own = self.splat_unit(config);
        own.map_or(SplatOpacity::Multiplied, |su| su.opacity)
    }

    /// Limits by which (tile, Gaussian) pairs are left out, if the configuration asks for it and its
    /// exponential allows for it. Nothing is left out where the arithmetic is not the configuration's.
    pub(super) fn tile_limits(&self, config: &Config) -> Option<TileLimits> {
        let asked = config.rit.pairs == RitPairs::ThatMayCount;
        if !asked || AblatedUnits::is_asked_for(self.choices) {
            return None;
        }
        let rules = self.profile.rules().with(&self.precision);
        TileLimits::new(&config.vu.exp, &rules, self.opacity(config))
    }

    /// Why no (tile, Gaussian) pair of splats is left out although the configuration asks for it; `None`
    /// where it does not ask, or pairs are left out.
    #[must_use]
    pub fn keeps_all_pairs(&self, config: &Config) -> Option<&'static str> {
        let asked = config.rit.pairs == RitPairs::ThatMayCount && self.cloud().is_some();
        if !asked || self.tile_limits(config).is_some() {
            return None;
        }
        Some(if AblatedUnits::is_asked_for(self.choices) {
            "an effect of the arithmetic is left out or forced, so that other pixels count"
        } else {
            "of this exponential no power is known to count nowhere: vu.exp needs base = \"e\", \
             output = \"alpha\" and an input of at most 20 bits"
        })
    }

    /// Options of the splat renderer for a configuration.
    #[must_use]
    pub fn splat_options(&self, config: &Config) -> splats::FixedOptions {
        let rows = config.mvoxel_capacity(Vertices::One, RECORD_CHANNELS) as usize;
        let su = self.splat_unit(config);
        splats::FixedOptions {
            schedule: splats::ScheduleOptions {
                rows,
                group_tiles: self.group_tiles.or(su.map(SuConfig::group_tiles)),
                cells: Cells {
                    merge: self.merges_cells(rows),
                    ..self.cells
                },
                limits: self.tile_limits(config),
                opacity: self.opacity(config),
            },
            background: self.background,
            order: self.order,
            unit_streams: UnitStreams::of(config),
            unit: match su {
                Some(_) => splats::CompositingUnit::SplatUnit,
                None => splats::CompositingUnit::VectorUnit,
            },
            log_decisions: true,
            widths: splats::Widths {
                power: config.vu.exp.input.frac_bits(),
                exponential: config.vu.exp.output_bits,
                form: config.vu.operand_widths(OpCode::SquareSum)[0],
            },
            work: self.splat_work(),
            ..splats::FixedOptions::default()
        }
    }

    /// Bytes of the reorder buffer, which lies in the feature buffer of the system: records that wait for
    /// their turn in depth order. None of a field, and none in approximate order.
    #[must_use]
    pub fn reorder_bytes(&self) -> u64 {
        match (self.model(), self.order) {
            (Model::Splats(_), splats::Order::Exact) => {
                let records = splats::FixedOptions::default().hold_records;
                (records * RECORD_CHANNELS * 2) as u64
            }
            _ => 0,
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
        let within = match options.unit {
            splats::CompositingUnit::SplatUnit => Some(frame.stats.splat_unit.within_exact_limit),
            splats::CompositingUnit::VectorUnit => None,
        };
        let clear = 1 << splats::TRANSMITTANCE.frac_bits();
        let covered: Vec<bool> = frame.transmittance.iter().map(|t| *t < clear).collect();
        Ok(Rendered {
            picture: frame.picture,
            counts: FrameCounts {
                rays: only.map_or(covered.len(), Mask::count) as u64,
                samples: 0,
                sample_outcomes: None,
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
                    pair_test: frame.stats.pair_test,
                    pairs_evaluated: frame.stats.evaluated,
                    exponentials: frame.stats.exponentials,
                    within_exact_limit: within,
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

    /// A field of the configuration with which the scene cannot be rendered.
    fn refused(
        &self,
        field: &'static str,
        value: String,
        expected: String,
    ) -> Result<(), SceneError> {
        Err(SceneError::Config {
            scene: self.name.clone(),
            field,
            value,
            expected,
        })
    }

    /// Checks that the vector unit's operands hold what compositing multiplies.
    fn operands_hold_splats(&self, config: &Config) -> Result<(), SceneError> {
        let Some(own) = config.vu.operands.as_ref() else {
            return Ok(());
        };
        if self.splat_unit(config).is_some() {
            return Ok(());
        }
        let exp = &config.vu.exp;
        let [a, b] = splats::Widths::least_factors(exp.output_bits);
        let [of_a, of_b] = own.multiply;
        if of_a < a || of_b < b {
            return self.refused(
                "vu.operands.multiply",
                format!("[{of_a}, {of_b}]"),
                format!(
                    "at least [{a}, {b}]: a transmittance of 21 bits, and a complement of 17 bits or an \
                     exponential of {}, each with a sign",
                    exp.output_bits
                ),
            );
        }
        let least = splats::Widths::least_form(exp.input.frac_bits(), exp.input.max());
        if own.square_sum < least {
            return self.refused(
                "vu.operands.square_sum",
                own.square_sum.to_string(),
                format!(
                    "at least {least}: a form that is held within its bits must make the largest \
                     argument of the exponential, {}",
                    exp.input
                ),
            );
        }
        Ok(())
    }

    /// Checks that records fit: they take 16-bit codes and a fixed number of channels.
    fn check_splats(&self, config: &Config) -> Result<(), SceneError> {
        if config.gu.feature_bits != 16 {
            let bits = config.gu.feature_bits.to_string();
            return self.refused(
                "gu.feature_bits",
                bits,
                "16: splat records are 16-bit codes".to_owned(),
            );
        }
        let exp = &config.vu.exp;
        if exp.input.int_bits() < 3 {
            let expected = "three or more integer bits: exp(-8) is the first that is skipped";
            let input = exp.input.to_string();
            return self.refused("vu.exp.input", input, expected.to_owned());
        }
        if !(8..=24).contains(&exp.output_bits) {
            let expected = "8 to 24 bits of opacity".to_owned();
            return self.refused("vu.exp.output_bits", exp.output_bits.to_string(), expected);
        }
        if let (Some(su), Some([columns, rows])) = (&config.su, self.group_tiles)
            && u64::from(columns) * u64::from(rows) > su.tiles.into()
        {
            let expected = format!(
                "{} or more, for render.group_tiles = [{columns}, {rows}]; or smaller ray groups",
                (u64::from(columns) * u64::from(rows)).next_power_of_two()
            );
            return self.refused("su.tiles", su.tiles.to_string(), expected);
        }
        let segments = config.segments(RECORD_CHANNELS);
        if segments > config.gu.segments as usize {
            let expected = format!(
                "{segments} or more: a splat record's {RECORD_CHANNELS} channels take that many \
                 with gu.banks = {}",
                config.gu.banks
            );
            return self.refused("gu.segments", config.gu.segments.to_string(), expected);
        }
        self.composites_splats(config)?;
        self.operands_hold_splats(config)
    }

    /// Refuses a configuration whose gathering unit takes no single ids, or whose vector unit lacks an
    /// operation of splats where no splat unit composites.
    fn composites_splats(&self, config: &Config) -> Result<(), SceneError> {
        let able = || presets_that(|own| gathers_records(own) && missing_op(own).is_none());
        if !gathers_records(config) {
            let expected = format!("\"both\" or \"unstructured\", for single ids{}", able());
            return self.refused("gu.modes", "\"structured\"".to_owned(), expected);
        }
        let missing = match self.splat_unit(config) {
            Some(_) => None,
            None => missing_vector_op(config),
        };
        let Some(op) = missing else { return Ok(()) };
        let expected = format!(
            "\"{}\" among the operations, or a splat unit ([su]){}",
            op.name(),
            able()
        );
        self.refused("vu.ops", OpCode::list(&config.vu.ops), expected)
    }
}

/// Whether the gathering unit takes single ids, as records need.
fn gathers_records(config: &Config) -> bool {
    config.supported_vertices().contains(&Vertices::One)
}

/// An operation of splats that the vector unit lacks.
fn missing_vector_op(config: &Config) -> Option<OpCode> {
    let wanted = [OpCode::SquareSum, OpCode::Exp, OpCode::Multiply];
    wanted.into_iter().find(|op| !config.vu.ops.contains(op))
}

/// As [`missing_vector_op`], of a configuration whose splat unit composites.
fn missing_op(config: &Config) -> Option<OpCode> {
    match config.su {
        Some(_) => None,
        None => missing_vector_op(config),
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
