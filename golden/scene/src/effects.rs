//! Effects that a scene's data needs, and their overrides.

use potamoi_formats::config::Config;
use potamoi_formats::units::OpCode;

use super::{Kind, Model, Scene, SceneError};
use crate::model_facts::ModelFacts;
use potamoi_base::effects::{Choices, Effect};
use potamoi_base::precision::Precision;
use potamoi_base::sh;
use potamoi_fields::{Field, FieldWork, FloatOptions};
use potamoi_gaussians::Cloud;
use potamoi_march::{Head, TRANSMITTANCE};
use potamoi_reference::bounds::VectorBounds;
use potamoi_splats::{Octree, Partition, Sorting, Work};

/// Upper bound, with a margin, of the loss of transmittance a sample in floating point.
pub(super) const LOST_IN_FLOATS: f64 = 1.0 / (1u64 << 40) as f64;
/// Maximum excess of a splat's alpha over its opacity, at 16 fraction bits: both are rounded, and
/// exponentials are at most 1.
const SPLAT_OPACITY: f64 = 1.0 / (1 << 16) as f64;

impl Model {
    /// Whether the model consists of Gaussians.
    #[must_use]
    pub fn is_splats(&self) -> bool {
        matches!(self.kind(), Kind::Splats(_))
    }
}

impl Scene {
    /// Effects that are forced or left out.
    #[must_use]
    pub const fn choices(&self) -> Choices {
        self.choices
    }

    /// Sets the effects that are forced or left out.
    pub fn set_choices(&mut self, choices: Choices) {
        self.choices = choices;
    }

    /// Facts about the model's data, determined at the first call.
    #[must_use]
    pub fn facts(&self) -> &ModelFacts {
        let rules = self.profile.rules().with(&self.precision);
        let stop = self.precision.stop_below;
        self.found
            .facts(|| ModelFacts::of(&self.model, &rules, stop))
    }

    fn carries_out(&self, effect: Effect, is_called_for: bool) -> bool {
        self.choices.carries_out(effect, is_called_for)
    }

    /// The highest degree of spherical harmonics that is evaluated.
    fn degree(&self) -> usize {
        let facts = self.facts();
        self.choices
            .harmonics(facts.stored_harmonics(), facts.highest_harmonic())
    }

    /// Number of coefficients of a Gaussian's colours that matter but are left out, over three
    /// channels; 0 for other models.
    #[must_use]
    pub fn left_out_coefficients(&self) -> u64 {
        let of = |degree: usize| 3 * (degree as u64 + 1).pow(2);
        match *self.model {
            Model::Splats(_) => {
                of(self.facts().highest_harmonic()).saturating_sub(of(self.degree()))
            }
            _ => 0,
        }
    }

    /// Whether rays can terminate early, if roundings reduce the transmittance by `lost` a sample.
    pub(super) fn stops(&self, lost: f64) -> bool {
        let can_stop = self.facts().thickness.can_stop(lost);
        self.carries_out(Effect::EarlyTermination, can_stop)
    }

    /// Upper bound of the loss of transmittance a sample by roundings in a configuration's units:
    /// the excess of an opacity, and one unit of the transmittance. 0 for fields that compute
    /// their densities, for which no bound is known.
    ///
    /// # Errors
    /// The configuration does not fit the field.
    pub fn lost_a_sample(&self, config: &Config) -> Result<f64, SceneError> {
        Ok(match self.model.kind() {
            Kind::Splats(_) => self.lost_a_splat(),
            Kind::Field(field) => match field.stored() {
                Some(stored) => {
                    let vector = VectorBounds::by_formula(&config.vu.exp);
                    stored.opacity_off(config, &vector)? + self.transmittance_unit()
                }
                None => 0.0,
            },
        })
    }

    /// The bound for a Gaussian, which does not depend on the configuration.
    fn lost_a_splat(&self) -> f64 {
        SPLAT_OPACITY + self.transmittance_unit()
    }

    /// Fraction bits of transmittances.
    pub(super) fn transmittance_bits(&self) -> u32 {
        let bits = self.precision.transmittance_bits;
        bits.unwrap_or(TRANSMITTANCE.frac_bits())
    }

    fn transmittance_unit(&self) -> f64 {
        2f64.powi(-(self.transmittance_bits() as i32))
    }

    fn sorting(&self) -> Sorting {
        match () {
            () if self.choices.leaves_out(Effect::Sorting) => Sorting::Never,
            () if self.choices.forces(Effect::Sorting) => Sorting::Always,
            () => Sorting::IfNeeded,
        }
    }

    /// As [`Scene::splat_work`] where the model's facts are known, and otherwise all that is not left
    /// out, with the same bits: facts take longer to find than one frame saves by them.
    pub(super) fn splat_work_of_one_frame(&self, cloud: &Cloud) -> Work {
        if self.found.has_facts() {
            return self.splat_work();
        }
        let stored = cloud.degree();
        Work {
            degree: self.choices.harmonics(stored, stored),
            sorting: self.sorting(),
            stops: self.carries_out(Effect::EarlyTermination, true),
            precision: self.precision,
        }
    }

    pub(super) fn splat_work(&self) -> Work {
        Work {
            degree: match *self.model {
                // A camera's colours have none.
                Model::Compact(_) => sh::MAX_DEGREE,
                _ => self.degree(),
            },
            sorting: self.sorting(),
            stops: self.stops(self.lost_a_splat()),
            precision: self.precision,
        }
    }

    /// Options of a field in floating point. Stored densities leave out what the hardware leaves
    /// out; other fields are rendered in full.
    pub(super) fn float_options(&self, field: &dyn Field) -> FloatOptions {
        let in_full = field.stored().is_none();
        FloatOptions {
            background: self.background,
            terminate: in_full || self.stops(LOST_IN_FLOATS),
            directions: in_full || self.degree() > 0,
            ..FloatOptions::default()
        }
    }

    /// Checks that a precision does not ask for more than the model has.
    pub(super) fn has_what_is_asked_for(&self, precision: &Precision) -> Result<(), SceneError> {
        let all = self.facts().hashed_tables();
        match precision.hashed_levels {
            Some(levels) if levels as usize > all => {
                let expected = format!("at most {all}, the hashed levels of the model");
                Err(self.value("render.hashed_levels", levels.to_string(), &expected))
            }
            _ => Ok(()),
        }
    }

    pub(super) fn field_work(&self) -> FieldWork {
        let facts = self.facts();
        let harmonics = |degree| match self.model.kind() {
            Kind::Field(field) => field.stored().map(|own| own.direction_codes(degree)),
            Kind::Splats(_) => None,
        };
        let sees = self.carries_out(Effect::ViewMlp, facts.sees_directions());
        let direction_codes = match (facts.perceptron, facts.harmonics) {
            (Some(_), _) if !sees => 0,
            (_, Some(_)) => {
                let degree = self.degree();
                harmonics(degree).unwrap_or_else(|| sh::coefficients(degree))
            }
            _ => usize::MAX,
        };
        // Cells of a tree without a node have nothing to gather.
        let has_nodes = facts.tables.iter().all(|table| table.vertices == 1);
        FieldWork {
            direction_codes,
            hashed: match self.precision.hashed_levels {
                _ if self.choices.leaves_out(Effect::HashLevels) => 0,
                Some(levels) => levels as usize,
                None => usize::MAX,
            },
            void_test: has_nodes || !self.choices.leaves_out(Effect::VoidTest),
        }
    }

    /// Number of splat cells before and after merging, with MVoxels of `rows` rows.
    #[must_use]
    pub fn merged_cells(&self, rows: usize) -> Option<[usize; 2]> {
        let Kind::Splats(cloud) = self.model.kind() else {
            return None;
        };
        let halvings = self.cells.halvings;
        Some(self.found.merging((rows, halvings), || {
            let partition = Partition::halved(cloud, rows, halvings);
            let tree = Octree::merge(cloud, &partition, rows);
            [tree.cells().len(), tree.points().len()]
        }))
    }

    /// Whether cells of splats are merged.
    pub(super) fn merges_cells(&self, rows: usize) -> bool {
        let can_merge =
            || matches!(self.merged_cells(rows), Some([cells, merged]) if merged < cells);
        let effect = Effect::OctreeMerging;
        // Looking is no less work than merging, but once.
        self.cells.merge
            && !self.choices.leaves_out(effect)
            && (self.choices.forces(effect) || can_merge())
    }

    /// Operations of the vector unit that frames of the scene need.
    ///
    /// # Errors
    /// The scene cannot be rendered with this configuration.
    pub fn operations(&self, config: &Config) -> Result<Vec<OpCode>, SceneError> {
        let of = |head: &dyn Head| [head.operations(), vec![OpCode::Multiply]].concat();
        // The splat unit computes what it composites.
        let splats = match self.splat_unit(config) {
            None => vec![OpCode::SquareSum, OpCode::Exp, OpCode::Multiply],
            Some(_) => vec![],
        };
        let found = match self.model() {
            Model::Splats(_) => Ok(splats),
            Model::Compact(_) => Ok([splats, vec![OpCode::Relu]].concat()),
            Model::Field(field) => {
                let coded = field.coded(config);
                coded
                    .map(|coded| of(&*coded.head))
                    .map_err(SceneError::from)
            }
        };
        found.map_err(|e: SceneError| e.of(&self.name))
    }

    /// The Gaussians of a splat model.
    pub fn cloud(&self) -> Option<&Cloud> {
        match self.model.kind() {
            Kind::Splats(cloud) => Some(cloud),
            _ => None,
        }
    }
}

impl Scene {
    /// The same scene with another model.
    #[must_use]
    pub fn with_model(self, model: Model) -> Self {
        Self {
            model: model.into(),
            found: crate::model_facts::Cache::default(),
            truth: None,
            ..self
        }
    }
}
