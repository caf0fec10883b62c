//! Area, period and energy of units without synthesis, by formulas fitted to the grid.
//!
//! Area and energy are sums over modules, each a sum of terms in the configuration's numbers. The
//! period is the largest of such sums, one for each module in which paths end. Coefficients
//! minimise the squares of relative errors. Errors are measured by cross-validation: at each point
//! of the grid with formulas fitted without it.

mod composed;
mod estimate;
mod exponential;
mod formulas;
mod left_out;
mod solve;
mod terms;
#[cfg(test)]
mod tests;

pub use composed::{CompositionErrors, Ratio};
pub use estimate::{EnergiesOf, Estimate, EstimatedModule, ScaledEstimate, Work};
pub use exponential::{ExponentialFigures, Origin};
pub use formulas::Formula;
pub use left_out::{LeftOut, PointErrors, Spread};
pub use solve::Addend;

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::OnceLock;

use potamoi_formats::config::Config;

use super::grid::{Family, Grid, GridPoint, is_exponential, is_same_unit};
use super::{SynthError, UnitKind};
use formulas::Formulas;
use terms::active_banks;

/// The grid of synth/grid-asap7.json.
const CHECKED_IN: &str = include_str!("../../../../synth/grid-asap7.json");
/// Synthesised units that no formula covers, in the same cells.
const FORMS: &str = include_str!("../../../../synth/forms-asap7.json");

/// Formulas for each family of units, and synthesised single units.
#[derive(Debug)]
pub struct Fit {
    grid: Grid,
    families: BTreeMap<Family, Formulas>,
    forms: Vec<GridPoint>,
    /// Exponentials by themselves, which no other figure is taken from.
    exponentials: Vec<GridPoint>,
    composition_errors: OnceLock<CompositionErrors>,
}

impl Fit {
    /// Fitted to the grid that comes with the program: ASAP7, 7 nm.
    ///
    /// # Errors
    /// The grid cannot be read or fitted.
    pub fn checked_in() -> Result<Self, SynthError> {
        let path = Path::new("synth/forms-asap7.json");
        Self::new(Grid::parse(CHECKED_IN, Path::new("synth/grid-asap7.json"))?)?
            .with_forms(Grid::parse(FORMS, path)?, path)
    }

    /// Fitted to a grid.
    ///
    /// # Errors
    /// A family has too few points, or a point lacks a module.
    pub fn new(grid: Grid) -> Result<Self, SynthError> {
        let mut families = BTreeMap::new();
        for family in Family::ALL {
            let points: Vec<_> = grid.of(family).collect();
            families.insert(family, Formulas::fit(family, &points)?);
        }
        Ok(Self {
            grid,
            families,
            forms: vec![],
            exponentials: vec![],
            composition_errors: OnceLock::new(),
        })
    }

    /// Adds synthesised single units.
    ///
    /// # Errors
    /// They use other cells.
    pub(crate) fn with_forms(mut self, forms: Grid, path: &Path) -> Result<Self, SynthError> {
        if forms.library != self.grid.library {
            return Err(SynthError::Parameters {
                path: path.to_owned(),
                why: format!(
                    "it is of {}, the grid of {}: expected the same cells",
                    forms.library.name, self.grid.library.name
                ),
                remedy: "potamoi synth --forms FILE",
            });
        }
        for point in forms.points {
            let is_alone = is_exponential(&point.config()?);
            match is_alone {
                true => self.exponentials.push(point),
                false => self.forms.push(point),
            }
        }
        self.composition_errors = OnceLock::new();
        Ok(self)
    }

    /// The synthesised unit for a configuration that no formula covers.
    fn form(&self, config: &Config, unit: UnitKind) -> Result<Option<&GridPoint>, SynthError> {
        for point in self.forms.iter().filter(|p| p.family.unit() == unit) {
            if is_same_unit(&point.config()?, config, unit) {
                return Ok(Some(point));
            }
        }
        Ok(None)
    }

    /// A synthesised unit at an operating point. For a gathering unit with other channels, its
    /// energy is scaled by the ratio that formulas give for the paper's unit.
    fn as_synthesised(&self, point: &GridPoint, work: Work) -> Result<Estimate, SynthError> {
        let own = Estimate::of(point, work);
        if point.family.unit() == UnitKind::Vector {
            return Ok(own);
        }
        let seen = Work {
            channels: point.activity.channels,
            ..work
        };
        let paper = Config::paper();
        let at = |work| self.estimate(&paper, UnitKind::Gathering, work);
        Ok(own.times(&at(work)?, &at(seen)?))
    }

    /// The grid of the fit.
    #[must_use]
    pub const fn grid(&self) -> &Grid {
        &self.grid
    }

    /// The family of a configuration's unit.
    ///
    /// # Errors
    /// None fits: the unit differs from the grid's in more than numbers; the fields are named.
    pub fn family(&self, config: &Config, unit: UnitKind) -> Result<Family, SynthError> {
        let found = Family::of(config, unit);
        found
            .map(|(family, _)| family)
            .map_err(|fields| SynthError::NotFitted { unit, fields })
    }

    /// Mean operating point of the family's netlists with as many segments a sample as this
    /// configuration has.
    #[must_use]
    pub fn usual_work(&self, family: Family, config: &Config) -> Work {
        let segments = |banks: u32, channels: u64| channels.div_ceil(banks.into());
        let points = || self.grid.of(family);
        let channels = points().next().map_or(0, |p| p.activity.channels);
        let own = segments(config.gu.banks, channels);
        let busy = |is_alike: &dyn Fn(&GridPoint) -> bool| {
            let alike = points().filter(|p| is_alike(p));
            let alike: Vec<f64> = alike.map(|p| Work::of(&p.activity).busy).collect();
            let mean = alike.iter().sum::<f64>() / alike.len() as f64;
            (!alike.is_empty()).then_some(mean)
        };
        let alike = busy(&|p| {
            let other = p.config();
            other.is_ok_and(|other| segments(other.gu.banks, channels) == own)
        });
        Work {
            busy: alike.or_else(|| busy(&|_| true)).unwrap_or(0.0),
            channels,
        }
    }

    /// Workload of a family's energies.
    #[must_use]
    pub fn energies_of(&self, family: Family) -> Option<EnergiesOf> {
        let mut points = self.grid.of(family);
        points.next().map(|p| EnergiesOf::new(&p.activity))
    }

    /// Estimates a unit at the grid's node and an operating point, by formulas or from its own
    /// synthesis.
    ///
    /// # Errors
    /// The unit differs from the grid's in more than numbers and was not synthesised; the fields
    /// are named.
    pub fn estimate(
        &self,
        config: &Config,
        unit: UnitKind,
        work: Work,
    ) -> Result<Estimate, SynthError> {
        let (family, beyond) = match Family::of(config, unit) {
            Ok(found) => found,
            Err(fields) => {
                return match self.form(config, unit)? {
                    Some(point) => self.as_synthesised(point, work),
                    None => Err(SynthError::NotFitted { unit, fields }),
                };
            }
        };
        let mut estimate = self.families[&family].at(config, work);
        estimate.beyond = beyond;
        if unit == UnitKind::Gathering {
            estimate
                .beyond
                .extend(self.beyond_work(family, config, work)?);
        }
        Ok(estimate)
    }

    /// Notes where more or fewer banks are at work than in any point.
    fn beyond_work(
        &self,
        family: Family,
        config: &Config,
        work: Work,
    ) -> Result<Option<String>, SynthError> {
        let mut all = vec![];
        for point in self.grid.of(family) {
            all.push(active_banks(&point.config()?, point.activity.channels));
        }
        let own = active_banks(config, work.channels);
        let least = all.iter().copied().fold(f64::INFINITY, f64::min);
        let most = all.iter().copied().fold(0.0, f64::max);
        let is_within = (least..=most).contains(&own);
        Ok((!is_within).then(|| {
            format!(
                "{own:.1} banks at work in the mean segment, the grid has {least:.1} to {most:.1}"
            )
        }))
    }

    /// Energy of a flip-flop's clock pin in units of a family, in picojoules a cycle.
    #[must_use]
    pub fn flop_pj(&self, family: Family) -> f64 {
        self.families[&family].flop_pj()
    }

    /// Formulas of a family.
    #[must_use]
    pub fn formulas(&self, family: Family) -> Vec<Formula> {
        self.families[&family].written()
    }

    /// Cross-validates the formulas of a family: errors at each of its points, fitted to the
    /// others.
    ///
    /// # Errors
    /// As [`Fit::new`].
    pub fn left_out(&self, family: Family) -> Result<LeftOut, SynthError> {
        let points: Vec<&GridPoint> = self.grid.of(family).collect();
        LeftOut::measure(family, &points)
    }
}
