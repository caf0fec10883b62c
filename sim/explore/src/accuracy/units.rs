//! Errors of a configuration's unit operations.

use std::cell::{OnceCell, RefCell};
use std::collections::HashMap;
use std::rc::Rc;

use potamoi_formats::config::{Config, Sums};
use potamoi_formats::units::OpCode;
use potamoi_reference::bounds::VectorBounds;
use potamoi_reference::exact_exponential::ExactExponential;
use potamoi_reference::exponential::ReferenceExponential;
use potamoi_reference::gathering_unit::Reducer;
use potamoi_reference::logistic::{Logistic, LogisticReference, logistic_budget};
use potamoi_reference::weights::{FRACTION_BITS, trilinear};
use potamoi_reference::widths::budget;
use potamoi_scene::Scene;
use potamoi_units::vector_unit::error_bound;
use schemars::JsonSchema;
use serde::Serialize;

/// Samples for operations with operands wider than 16 bits.
const SAMPLES: u32 = 1 << 16;
/// Fraction bits of the widest feature, the unit of gathering errors.
const FEATURE_FRAC: i32 = 15;

/// Error of a unit's operation, in units of the last place (ulp).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct UnitError {
    /// Largest magnitude.
    pub max_ulp: f64,
    /// Mean magnitude.
    pub mean_ulp: f64,
    /// Bound by formula.
    pub bound_ulp: f64,
    /// Bound by analysis of the netlist, where that is known.
    pub netlist_ulp: Option<f64>,
}

impl UnitError {
    fn of(errors: impl Iterator<Item = f64>, bound_ulp: f64) -> Self {
        let (mut max_ulp, mut sum, mut count) = (0f64, 0.0, 0.0);
        for error in errors {
            max_ulp = max_ulp.max(error.abs());
            sum += error.abs();
            count += 1.0;
        }
        Self {
            max_ulp,
            mean_ulp: sum / count,
            bound_ulp,
            netlist_ulp: None,
        }
    }

    /// The smaller of both bounds.
    #[must_use]
    pub fn bound(&self) -> f64 {
        self.netlist_ulp
            .unwrap_or(f64::INFINITY)
            .min(self.bound_ulp)
    }
}

/// Errors of the operations that a scene is rendered with.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct UnitErrors {
    /// exp(-u), in ulp of the result, over all 16-bit operands.
    pub exponential: Option<UnitError>,
    /// 1 - exp(-s) of 65,536 depths below 8, rounded to its operand, in ulp of the result; for rays
    /// with opacities.
    pub one_minus_exp: Option<UnitError>,
    /// 1 / (1 + exp(-x)), in ulp of the result, over all operands from -16 to 16; where a ray's
    /// colours or opacities use it.
    pub sigmoid: Option<UnitError>,
    /// ln(1 + exp(x)), with the same operands and unit.
    pub softplus: Option<UnitError>,
    /// Interpolation of eight coded values from -1 to 1 against the unrounded result, in ulp of a
    /// 16-bit feature, at 65,536 places; where features are interpolated.
    pub gathering: Option<UnitError>,
}

/// Results that take long, computed once per model.
#[derive(Debug, Default)]
pub(super) struct UnitErrorCache {
    /// Operations that the model is rendered with.
    operations: OnceCell<Vec<OpCode>>,
    /// Bounds by analysis of netlists.
    bounds: RefCell<HashMap<String, Option<f64>>>,
    /// References to 120 bits, by fraction bits of operands.
    logistic: RefCell<HashMap<u32, Option<Rc<LogisticReference>>>>,
}

impl UnitErrorCache {
    /// Netlist bound of an operation; `None` if it is not built or the unit is invalid.
    fn bound(&self, config: &Config, op: OpCode) -> Option<f64> {
        let key = format!("{op:?} {:?} {:?}", config.vu.ops, config.vu.exp);
        let known = self.bounds.borrow().get(&key).copied();
        known.unwrap_or_else(|| {
            let found = error_bound(config, op).ok().flatten();
            let found = found.map(|bound| bound.ulp);
            self.bounds.borrow_mut().insert(key, found);
            found
        })
    }

    fn takes(&self, scene: &Scene, config: &Config, op: OpCode) -> bool {
        let all = || scene.operations(config).unwrap_or_default();
        config.vu.ops.contains(&op) && self.operations.get_or_init(all).contains(&op)
    }

    /// Reference of sigmoid and softplus for operands of so many fraction bits; `None` where they
    /// do not exist.
    fn logistic(&self, frac_bits: u32) -> Option<Rc<LogisticReference>> {
        let mut known = self.logistic.borrow_mut();
        let found = || {
            let is_known = LogisticReference::BITS.contains(&frac_bits);
            let own = is_known.then(|| LogisticReference::new(frac_bits).ok())?;
            own.map(Rc::new)
        };
        known.entry(frac_bits).or_insert_with(found).clone()
    }

    /// Bounds of the operations that a scene uses: the smaller of netlist and formula.
    pub(super) fn vector_bounds(&self, scene: &Scene, config: &Config) -> VectorBounds {
        let formula = VectorBounds::by_formula(&config.vu.exp);
        let known = |op| self.bound(config, op).unwrap_or(f64::INFINITY);
        let one_minus_exp = match has_rays(scene, config) {
            true => known(OpCode::OneMinusExp),
            false => f64::INFINITY,
        };
        let logistic = |op| match self.takes(scene, config, op) {
            true => known(op),
            false => f64::INFINITY,
        };
        let netlist = VectorBounds {
            sigmoid: logistic(OpCode::Sigmoid),
            softplus: logistic(OpCode::Softplus),
            ..VectorBounds::of_powers(known(OpCode::Exp), one_minus_exp)
        };
        formula.and(netlist)
    }
}

fn has_rays(scene: &Scene, config: &Config) -> bool {
    !scene.model().is_splats() && config.vu.ops.contains(&OpCode::OneMinusExp)
}

impl UnitErrors {
    pub(super) fn of(scene: &Scene, config: &Config, known: &UnitErrorCache) -> Self {
        let interpolates = scene.facts().tables.iter().any(|t| t.vertices == 8);
        Self {
            exponential: exponential(config, known),
            one_minus_exp: has_rays(scene, config).then(|| one_minus_exp(config, known)),
            sigmoid: logistic(scene, config, known, Logistic::Sigmoid),
            softplus: logistic(scene, config, known, Logistic::Softplus),
            gathering: interpolates.then(|| gathering(config)),
        }
    }

    /// Errors by operation; `None` for operations that the scene does not use.
    #[must_use]
    pub fn named(&self) -> [(&'static str, Option<UnitError>); 5] {
        [
            ("exp", self.exponential),
            ("one_minus_exp", self.one_minus_exp),
            ("sigmoid", self.sigmoid),
            ("softplus", self.softplus),
            ("gather", self.gathering),
        ]
    }
}

fn exponential(config: &Config, known: &UnitErrorCache) -> Option<UnitError> {
    let exp = &config.vu.exp;
    if !config.vu.ops.contains(&OpCode::Exp) || exp.input.width() > 16 {
        return None;
    }
    let reference = ExactExponential::in_base(exp.input, exp.base).ok()?;
    let twin = ReferenceExponential::new(exp);
    let error = reference.measure(exp.output_bits, |u| twin.exp(u));
    Some(UnitError {
        max_ulp: error.max_ulp,
        mean_ulp: error.mean,
        bound_ulp: budget(exp),
        netlist_ulp: known.bound(config, OpCode::Exp),
    })
}

/// The n-th element of an equidistributed sequence in 0 to 1, one sequence per prime (Weyl, "Ueber
/// die Gleichverteilung von Zahlen mod. Eins", 1916).
fn even(n: u32, prime: u32) -> f64 {
    (f64::from(n) * f64::from(prime).sqrt()).fract()
}

fn one_minus_exp(config: &Config, known: &UnitErrorCache) -> UnitError {
    let exp = &config.vu.exp;
    let twin = ReferenceExponential::new(exp);
    let bits = exp.one_minus_frac_bits as i32;
    let (code, ulps) = (2f64.powi(bits), 2f64.powi(exp.output_bits as i32));
    let errors = (0..SAMPLES).map(|n| {
        let depth = (f64::from(n) + even(n, 2)) * 8.0 / f64::from(SAMPLES);
        let operand = (depth * code).round().min(8.0 * code - 1.0);
        let found = f64::from(twin.one_minus_exp(operand as i32));
        found + (-depth).exp_m1() * ulps
    });
    // The slope is 1 at most; the last operand below 8 may be a whole unit off. The largest code
    // stands for 1, too.
    let beside = |bound: f64| bound.max(1.0) + ulps / code;
    UnitError {
        netlist_ulp: known.bound(config, OpCode::OneMinusExp).map(beside),
        ..UnitError::of(errors, beside(budget(exp)))
    }
}

fn logistic(
    scene: &Scene,
    config: &Config,
    known: &UnitErrorCache,
    of: Logistic,
) -> Option<UnitError> {
    let exp = &config.vu.exp;
    let op = match of {
        Logistic::Sigmoid => OpCode::Sigmoid,
        Logistic::Softplus => OpCode::Softplus,
    };
    if !known.takes(scene, config, op) {
        return None;
    }
    let reference = known.logistic(exp.input.frac_bits())?;
    let twin = ReferenceExponential::new(exp);
    let error = reference.measure(of, exp.output_bits, |code| match of {
        Logistic::Sigmoid => twin.sigmoid(code),
        Logistic::Softplus => twin.softplus(code),
    });
    Some(UnitError {
        max_ulp: error.max_ulp,
        mean_ulp: error.mean,
        bound_ulp: logistic_budget(of, exp),
        netlist_ulp: known.bound(config, op),
    })
}

fn gathering(config: &Config) -> UnitError {
    let reducer = Reducer::new(config);
    let frac = config.gu.feature_bits.clamp(2, 16) as i32 - 1;
    let one = 2f64.powi(reducer.weight_bits() as i32);
    let (code, unit) = (2f64.powi(frac), 2f64.powi(FEATURE_FRAC));
    let is_exact = config.gu.sums == Sums::Exact;
    let errors = (0..SAMPLES).map(|n| {
        let values = [3, 5, 7, 11, 13, 17, 19, 23].map(|prime| 2.0 * even(n, prime) - 1.0);
        let codes = values.map(|v| (v * code).round().clamp(-code, code - 1.0) as i16);
        let place = [29, 31, 37].map(|prime| (even(n, prime) * 4096.0) as u16);
        let weights = trilinear(place, reducer.weight_bits());
        let sum = reducer.sum(weights.into_iter().zip(codes));
        let found = match is_exact {
            true => sum as f64 / one,
            false => f64::from(reducer.round(sum)),
        };
        let side = |corner: usize, axis: usize| {
            let u = f64::from(place[axis]) / f64::from(1u32 << FRACTION_BITS);
            if corner >> axis & 1 == 1 { u } else { 1.0 - u }
        };
        let exact: f64 = (0..8)
            .map(|c| side(c, 0) * side(c, 1) * side(c, 2) * values[c])
            .sum();
        (found / code - exact) * unit
    });
    // A code is half a unit off, the largest a whole one; so is what comes out. Weights that are split
    // are off by 7 units of theirs together, of which half are above and half below, times what
    // lies between the values.
    let coded = if is_exact { 1.0 } else { 1.5 };
    UnitError::of(errors, (coded / code + 3.5 * 2.0 / one) * unit)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    const FIELDS: &str = include_str!("../../../../configs/fields.toml");

    /// Errors of a scene's units, as the text sets them.
    fn of(scene: &str) -> impl Fn(&str) -> UnitErrors {
        let (scene, known) = (Scene::open(scene).unwrap(), UnitErrorCache::default());
        move |text| UnitErrors::of(&scene, &Config::from_toml(text, "test").unwrap(), &known)
    }

    /// A coarser unit has larger errors, all within their bounds, and each setting changes the
    /// error of its own operation.
    #[test]
    fn errors_are_of_the_operation_that_a_setting_moves() {
        let (lantern, field) = (of("lantern"), of("moons:efficientnerf"));
        let fields = |text: &str| field(&format!("{text}{FIELDS}"));
        let usual = [lantern(""), fields("")];
        let check = |[own, usual]: [UnitErrors; 2], text: &str, which: &str, operations: usize| {
            let both = own.named().into_iter().zip(usual.named());
            let both = both.filter_map(|((name, own), (_, usual))| Some((name, own?, usual?)));
            let both: Vec<_> = both.collect();
            assert_eq!(both.len(), operations, "{both:?}");
            for (name, own, usual) in both {
                assert!(own.max_ulp <= own.bound(), "{text} {name}: {own:?}");
                assert!(
                    own.mean_ulp > 0.0 && own.mean_ulp < own.max_ulp,
                    "{text} {name}"
                );
                let is_moved = own.max_ulp > 1.2 * usual.max_ulp;
                assert_eq!(is_moved, name == which, "{text} {name}: {own:?} {usual:?}");
            }
        };
        for (text, which) in [
            ("vu.exp.one_minus_frac_bits = 12\n", "one_minus_exp"),
            ("gu.weight_bits = 8\n", "gather"),
            ("gu.feature_bits = 10\n", "gather"),
        ] {
            check([lantern(text), usual[0]], text, which, 3);
        }
        let text = "gu.feature_bits = 10\n";
        check([fields(text), usual[1]], text, "none", 4);
        let exact = lantern("gu.sums = \"exact\"").gathering.unwrap();
        assert!(exact.mean_ulp < usual[0].gathering.unwrap().mean_ulp);
        let coarse = lantern("vu.exp.iterations = 8");
        assert!(coarse.exponential.unwrap().max_ulp > 50.0);
        assert!(coarse.one_minus_exp.unwrap().max_ulp > 50.0);
        let text = FIELDS.replace("iterations = 18", "iterations = 8");
        let coarse = field(&text);
        assert!(coarse.sigmoid.unwrap().max_ulp > 50.0);
        assert!(coarse.softplus.unwrap().max_ulp > 20.0);
    }

    /// Splats have records only, without interpolation.
    #[test]
    fn splats_interpolate_nothing() {
        let own = of("garden")("");
        assert!(own.exponential.is_some());
        assert_eq!((own.one_minus_exp, own.gathering), (None, None));
    }
}
