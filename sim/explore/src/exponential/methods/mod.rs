//! Comparison of exponential methods: error over all inputs against clocks per result.

mod blocks;
mod forms;
mod others;
mod peers;

use schemars::JsonSchema;
use serde::Serialize;

use super::price::{ExponentialPrice, Pricing};
use crate::ExploreError;

/// Input unit of U3.13: `u` is a code over 2^13, and the result `exp(-u)` is in units of 2^-16.
const INPUT_UNIT: f64 = 1.0 / 8192.0;
const OUTPUT_UNIT: f64 = 65536.0;
/// Largest error of a faithful result, in ulp.
const FAITHFUL: f64 = 1.0;

/// Exponential methods, and the cheapest of the faithful ones: those with an error below an ulp.
/// Only synthesised methods can be the cheapest.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct Methods {
    /// Forms of the engine, and alternatives to it.
    pub methods: Vec<Method>,
    /// Published methods of others.
    pub peers: Vec<Peer>,
    /// Prices of the forms as blocks by themselves.
    pub prices: Vec<ExponentialPrice>,
    /// Name of the faithful method with the fewest clocks, then the least energy.
    pub cheapest_faithful: Option<String>,
    /// Name of the faithful method with the least area.
    pub smallest_faithful: Option<String>,
    /// Name of the faithful method with the least energy.
    pub thriftiest_faithful: Option<String>,
}

/// A form of the engine, or an alternative to it.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct Method {
    /// Description of the form.
    pub name: String,
    /// Family: shared by forms that differ in one number only.
    pub family: &'static str,
    /// Clocks from one vector to the next; with early termination the mean over all inputs, each
    /// lane on its own.
    pub clocks: f64,
    /// Largest error magnitude, in ulp of U0.16.
    pub max_ulp: f64,
    /// Mean error magnitude, in ulp.
    pub mean_ulp: f64,
    /// Error bound by formula, in ulp; `None` for methods that are not built.
    pub bound_ulp: Option<f64>,
    /// Error bound by analysis of the netlist, in ulp.
    pub netlist_ulp: Option<f64>,
    /// Whether results never rise with the input.
    pub monotone: bool,
    /// Area of the paper's vector unit with this method at 12 nm, in square millimetres; `None`
    /// where it is neither synthesised nor covered by formulas.
    pub area_mm2: Option<f64>,
    /// Energy of the unit per exponential at full utilisation, in picojoules; `None` in the same
    /// cases.
    pub energy_pj: Option<f64>,
}

/// A published method of others, measured on the same inputs and rounded to the same output.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct Peer {
    /// Its name.
    pub name: &'static str,
    /// Largest error magnitude, in ulp of U0.16.
    pub max_ulp: f64,
}

impl Methods {
    /// Compares all methods over all 65,536 inputs of U3.13 against a reference of 120 bits. Built
    /// methods run through their reference unit.
    ///
    /// # Errors
    /// A netlist that cannot be analysed, or what comes with the program cannot be read.
    pub fn compare() -> Result<Self, ExploreError> {
        let (methods, peers) = (
            forms::forms()?.into_iter().chain(others::others()?),
            peers::peers()?,
        );
        let methods: Vec<Method> = methods.collect();
        let pricing = Pricing::open()?;
        let prices = blocks::blocks();
        let prices = prices.iter().map(|exp| pricing.of(exp));
        let known = |of: Option<f64>| of.unwrap_or(f64::INFINITY);
        let (area, energy) = (
            |m: &Method| known(m.area_mm2),
            |m: &Method| known(m.energy_pj),
        );
        Ok(Self {
            cheapest_faithful: least(&methods, &|m| m.clocks, &energy),
            smallest_faithful: least(&methods, &area, &|m| m.clocks),
            thriftiest_faithful: least(&methods, &energy, &|m| m.clocks),
            methods,
            peers,
            prices: prices.collect::<Result<_, _>>()?,
        })
    }
}

/// Name of the faithful method with the least of one measure, and among equals of another.
fn least(
    methods: &[Method],
    of: &dyn Fn(&Method) -> f64,
    then: &dyn Fn(&Method) -> f64,
) -> Option<String> {
    let synthesised = methods.iter().filter(|m| m.energy_pj.is_some());
    let faithful = synthesised.filter(|m| m.max_ulp < FAITHFUL);
    let own = faithful.min_by(|a, b| of(a).total_cmp(&of(b)).then(then(a).total_cmp(&then(b))))?;
    Some(own.name.clone())
}
