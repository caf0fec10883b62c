//! Ways to find an exponential side by side: error over all inputs against clocks a result.

mod forms;
mod others;
mod peers;

use serde::Serialize;

use crate::ExploreError;

/// Inputs of U3.13: `u` is a code over 2^13, `exp(-u)` in units of 2^-16 the result.
const INPUT_UNIT: f64 = 1.0 / 8192.0;
const OUTPUT_UNIT: f64 = 65536.0;
/// Units of the last place below which a result is faithful.
const FAITHFUL: f64 = 1.0;

/// Ways to find an exponential, and which of those that are faithful cost least. Faithful is an
/// error below a unit of the last place; only what was synthesised counts.
#[derive(Debug, Clone, Serialize)]
pub struct Methods {
    /// Forms of the engine, and what could stand in its place.
    pub methods: Vec<Method>,
    /// What others use.
    pub peers: Vec<Peer>,
    /// Faithful with the fewest clocks; of those with the least energy.
    pub cheapest_faithful: Option<String>,
    /// Faithful on the least area.
    pub smallest_faithful: Option<String>,
    /// Faithful with the least energy.
    pub thriftiest_faithful: Option<String>,
}

/// A form of the engine, or of what could stand in its place.
#[derive(Debug, Clone, Serialize)]
pub struct Method {
    /// The form, in words.
    pub name: String,
    /// Forms that differ in a number alone share it.
    pub family: &'static str,
    /// From one vector to the next; with an early out on average over all inputs, each lane
    /// by itself.
    pub clocks: f64,
    /// The largest magnitude of the error, in units of the last place of U0.16.
    pub max_ulp: f64,
    /// Its mean magnitude.
    pub mean_ulp: f64,
    /// What it cannot exceed, by formula; none of what is not built.
    pub bound_ulp: Option<f64>,
    /// The same by analysis of the netlist.
    pub netlist_ulp: Option<f64>,
    /// Whether no larger input has a larger result.
    pub monotone: bool,
    /// Square millimetres of the paper's vector unit with it at 12 nm; none where it was neither
    /// synthesised nor formulas are of it.
    pub area_mm2: Option<f64>,
    /// Picojoules of the unit, at work all the time, for each; likewise.
    pub energy_pj: Option<f64>,
}

/// What others use: measured on the same inputs, rounded to the same output.
#[derive(Debug, Clone, Serialize)]
pub struct Peer {
    /// What it is.
    pub name: &'static str,
    /// The largest magnitude of its error, in units of the last place of U0.16.
    pub max_ulp: f64,
}

impl Methods {
    /// All of them over all 65,536 inputs of U3.13, what is built through its twin, against 120 bits.
    ///
    /// # Errors
    /// A netlist that cannot be analysed, or formulas that cannot be read.
    pub fn compare() -> Result<Self, ExploreError> {
        let (methods, peers) = (
            forms::forms()?.into_iter().chain(others::others()?),
            peers::peers()?,
        );
        let methods: Vec<Method> = methods.collect();
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
        })
    }
}

/// The name of the faithful method with the least of something, and of equal ones then of another.
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
