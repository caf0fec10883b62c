//! Hard cases of numerics: inputs on which the obvious form of a computation fails.
//!
//! In each case the obvious form and ours take the same rounded inputs. Both are compared with exact
//! integers or numbers of 256 bits, and ours must keep a bound that follows from the formats.
//! [`measure`] does this with the formats, the exponential and the units of any configuration;
//! [`of_scene`] looks for the same hardness in a user's scene.
//!
//! The table in docs/explanation/hard-cases.md is made by the tests. Verilog and system of the same cases
//! are in the root package's tests/hard_cases.

mod accumulators;
mod compositing;
mod covariance;
mod exact;
mod exponential;
mod fog;
mod hashing;
mod ordering;
pub mod pictures;
mod projection;
mod sampling;
mod scene;
#[cfg(test)]
mod search;
mod splat_unit;
#[cfg(test)]
mod table;
mod warping;

use std::borrow::Cow;
use std::error::Error;

use potamoi_formats::config::{Config, ExpBase, ExpConfig, ExpForm, ExpOutput, Modes};
use potamoi_formats::rit::Vertices;
use potamoi_formats::units::OpCode;
use potamoi_reference::ReferenceUnits;
use potamoi_scene::{Rendered, Scene, SceneError};
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::Serialize;

pub use scene::{CheckState, SceneCases, SceneCheck, of_scene};

/// A hard case under a configuration.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct HardCase {
    /// Name of the case.
    pub name: &'static str,
    /// Part of the computation that it belongs to.
    pub part: &'static str,
    /// What was found.
    #[serde(flatten)]
    pub found: Found,
}

/// What was found of a case under a configuration.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
#[serde(tag = "state", rename_all = "kebab-case")]
pub enum Found {
    /// Both forms were measured.
    Measured(Measured),
    /// The configuration does not have what the case is about.
    DoesNotApply {
        /// The reason.
        reason: String,
    },
    /// The case applies, and its inputs could not be computed: it fails.
    NotComputed {
        /// The error.
        reason: String,
    },
}

/// Errors of the obvious form and of ours, in one unit.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Measured {
    /// The obvious form.
    pub naive: String,
    /// Its largest error; `None` where it gives no number.
    pub naive_error: Option<f64>,
    /// Our largest error; `None` where we give no number.
    pub error: Option<f64>,
    /// Upper bound of our error.
    pub bound: f64,
    /// Origin of the bound.
    pub derivation: String,
    /// Unit of the errors.
    pub unit: String,
    /// Whether our error is within the bound.
    pub passes: bool,
    /// Whether the obvious form leaves the bound. Where it does not, the case is not hard for this
    /// configuration.
    pub is_hard: bool,
}

impl HardCase {
    /// Whether the case fails: our form leaves its bound, or could not be computed.
    #[must_use]
    pub const fn fails(&self) -> bool {
        match &self.found {
            Found::Measured(own) => !own.passes,
            Found::DoesNotApply { .. } => false,
            Found::NotComputed { .. } => true,
        }
    }
}

impl From<Case> for Measured {
    fn from(case: Case) -> Self {
        let (naive, ours) = (case.fails.0, case.ours.0);
        let number = |v: f64| v.is_finite().then_some(v);
        Self {
            naive: case.naive.into_owned(),
            naive_error: number(naive),
            error: number(ours),
            bound: case.bound,
            derivation: case.from.into_owned(),
            unit: case.unit.into_owned(),
            passes: ours <= case.bound,
            is_hard: naive > case.bound,
        }
    }
}

/// Measures every case with the number formats, the exponential and the units of a configuration.
#[must_use]
pub fn measure(config: &Config) -> Vec<HardCase> {
    all()
        .into_par_iter()
        .map(|own| HardCase {
            name: own.name,
            part: own.part,
            found: match (own.measure)(config) {
                Ok(case) => Found::Measured(case.into()),
                Err(Stop::DoesNotApply(reason)) => Found::DoesNotApply { reason },
                Err(Stop::NotComputed(reason)) => Found::NotComputed { reason },
            },
        })
        .collect()
}

/// A case of this list.
struct Listed {
    name: &'static str,
    part: &'static str,
    /// Settings beside the paper's with which the case is tested and shown, as TOML.
    #[cfg_attr(not(test), expect(dead_code, reason = "of tests and the book's table"))]
    shown: &'static str,
    measure: fn(&Config) -> Measuring,
}

fn all() -> Vec<Listed> {
    let parts = [
        exponential::all(),
        fog::all(),
        compositing::all(),
        splat_unit::all(),
        covariance::all(),
        projection::all(),
        ordering::all(),
        sampling::all(),
        hashing::all(),
        accumulators::all(),
        warping::all(),
    ];
    parts.into_iter().flatten().collect()
}

/// Errors of both forms, in one unit.
#[derive(Debug, Clone, PartialEq)]
struct Case {
    /// The obvious form.
    naive: Cow<'static, str>,
    /// Unit of the errors.
    unit: Cow<'static, str>,
    /// Error of the obvious form; infinite if its result is NaN.
    fails: Worst,
    /// Upper bound of our error.
    bound: f64,
    /// Origin of the bound.
    from: Cow<'static, str>,
    /// Our error.
    ours: Worst,
}

/// Why a case was not measured.
#[derive(Debug)]
enum Stop {
    DoesNotApply(String),
    NotComputed(String),
}

impl<E: Error> From<E> for Stop {
    fn from(error: E) -> Self {
        Self::NotComputed(error.to_string())
    }
}

type Measuring = Result<Case, Stop>;

/// A case that does not apply, with the reason.
fn unless(applies: bool, reason: impl FnOnce() -> String) -> Result<(), Stop> {
    match applies {
        true => Ok(()),
        false => Err(Stop::DoesNotApply(reason())),
    }
}

/// Checks that a case has what makes it hard.
fn ensure(is_so: bool, what: impl FnOnce() -> String) -> Result<(), Stop> {
    match is_so {
        true => Ok(()),
        false => Err(Stop::NotComputed(what())),
    }
}

/// Checks that the vector unit has an operation.
fn computes(config: &Config, op: OpCode) -> Result<(), Stop> {
    unless(config.vu.ops.contains(&op), || {
        format!("vu.ops has no {}", op.name())
    })
}

/// The exponential, if its results are codes of `exp(-u)` or `2^-u`.
fn codes_of_powers(config: &Config) -> Result<&ExpConfig, Stop> {
    computes(config, OpCode::Exp)?;
    let exp = &config.vu.exp;
    unless(exp.form != ExpForm::Literal, || {
        "vu.exp.form = \"literal\" has other operands and results, shown by the case of negative \
         powers"
            .to_owned()
    })?;
    unless(exp.output == ExpOutput::Alpha, || {
        "vu.exp.output = \"general\" has an exponent beside the mantissa, and operands of both signs"
            .to_owned()
    })?;
    Ok(exp)
}

/// Checks that the exponential has base e.
fn base_e(exp: &ExpConfig) -> Result<(), Stop> {
    unless(exp.base == ExpBase::E, || {
        "vu.exp.base = \"two\" needs no multiple of ln 2, and renderers need \"e\"".to_owned()
    })
}

/// Checks that the gathering unit takes entries of eight vertices.
fn eight_vertices(config: &Config) -> Result<(), Stop> {
    let has =
        config.gu.vertices.contains(&Vertices::Eight) && config.gu.modes != Modes::Unstructured;
    unless(has, || {
        "the gathering unit takes no entries of eight vertices (gu.modes, gu.vertices)".to_owned()
    })
}

/// A scene in a configuration's formats. Where the configuration cannot render it, its refusal is the
/// reason why the case does not apply.
fn rendered(scene: &Scene, config: &Config) -> Result<Rendered, Stop> {
    if let Err(error) = crate::Hardware::of(scene, config) {
        return Err(Stop::DoesNotApply(error.to_string()));
    }
    match scene.render_fixed(config, &mut ReferenceUnits::new(config)) {
        Err(error @ SceneError::Config { .. }) => Err(Stop::DoesNotApply(error.to_string())),
        other => Ok(other?),
    }
}

/// Runs on one thread; on those that there are, if no other can be had.
fn in_pool_of_one<T: Send>(run: impl FnOnce() -> T + Send) -> T {
    match rayon::ThreadPoolBuilder::new().num_threads(1).build() {
        Ok(pool) => pool.install(run),
        Err(_) => run(),
    }
}

/// The largest error seen.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Worst(f64);

impl Worst {
    /// Adds an error; NaN counts as infinite.
    fn see(&mut self, error: f64) {
        let error = error.abs();
        self.0 = self
            .0
            .max(if error.is_nan() { f64::INFINITY } else { error });
    }

    /// Counts wrong results.
    fn count(&mut self, wrong: bool) {
        self.0 += f64::from(u8::from(wrong));
    }

    /// The largest of some errors.
    fn of(errors: impl IntoIterator<Item = f64>) -> Self {
        let mut worst = Self::default();
        errors.into_iter().for_each(|e| worst.see(e));
        worst
    }
}

/// Defines a file's cases: `all` of them, and a test for each. A case is a function, its name, and the
/// settings with which it is tested.
macro_rules! cases {
    ($part:literal; $($function:ident, $name:literal, $shown:expr;)+) => {
        pub(super) fn all() -> Vec<crate::hard_cases::Listed> {
            vec![$(crate::hard_cases::Listed {
                name: $name,
                part: $part,
                shown: $shown,
                measure: $function,
            }),+]
        }

        #[cfg(test)]
        mod holds {
            $(#[test]
            fn $function() {
                crate::hard_cases::table::holds($name);
            })+
        }
    };
}
use cases;

/// A fixed sequence of pseudo-random numbers, 0 to 1.
struct Draws(u64);

impl Draws {
    fn next(&mut self) -> f64 {
        // Knuth's multiplier; the high bits are good.
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        (self.0 >> 11) as f64 / 2f64.powi(53)
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.next()
    }
}
