//! The reducer: a multiply-accumulate unit for one channel of one port, over an entry's vertices in
//! sequence.

use std::sync::Arc;

use num_bigint::BigInt;
use potamoi_formats::config::{Config, Modes, Sums, WeightTrust};
use potamoi_formats::fixed::Rounding;
use potamoi_formats::timing::ReducerStage;
use potamoi_netlist::{IrErrors, Module, ModuleBuilder, Signal, Ty};

use crate::data_checks::{Held, held_without_enable};

/// Enable of each built stage, first to last.
pub(crate) struct Enables(Vec<(ReducerStage, Signal)>);

impl Enables {
    /// Declares the ports: `valid` for the first stage, and one named after each other stage.
    pub(crate) fn declare(m: &mut ModuleBuilder, config: &Config) -> Self {
        let stages = config.reducer_pipeline();
        let ports = stages.stages().enumerate().map(|(at, stage)| {
            let enable = match at {
                0 => m.input("valid", Ty::bit(), "features and weights are given"),
                _ => m.input(stage_name(stage), Ty::bit(), "the next stage takes over"),
            };
            (stage, enable)
        });
        Self(ports.collect())
    }

    /// The enable of a stage; `None` where it is not built.
    pub(crate) fn of(&self, stage: ReducerStage) -> Option<Signal> {
        let mut all = self.0.iter();
        all.find(|(own, _)| *own == stage)
            .map(|(_, enable)| *enable)
    }

    fn all(&self) -> impl Iterator<Item = Signal> + '_ {
        self.0.iter().map(|(_, enable)| *enable)
    }

    /// Checks of the registers of the stages; those of products have a name that ends on one of `of`.
    pub(crate) fn checks(&self, m: &mut ModuleBuilder, of: &[String]) {
        let mut held = vec![];
        for (at, (stage, _)) in self.0.iter().enumerate() {
            let enable = if at == 0 { "valid" } else { stage_name(*stage) };
            let names: &[&str] = match stage {
                ReducerStage::Operands => &["held_feature", "held_weight"],
                ReducerStage::PartialProducts => &["product_of_low_bits", "product_of_high_bits"],
                ReducerStage::Product => &["held_product"],
                ReducerStage::Sum => {
                    let register = "acc".to_owned();
                    held.push(Held { register, enable });
                    continue;
                }
            };
            for name in names {
                let registers = of.iter().map(|of| format!("{name}{of}"));
                held.extend(registers.map(|register| Held { register, enable }));
            }
        }
        held_without_enable(m, &held);
    }
}

/// The name of a stage's enable, of all but the first one.
pub(crate) const fn stage_name(stage: ReducerStage) -> &'static str {
    match stage {
        ReducerStage::Operands => "operands",
        ReducerStage::PartialProducts => "halves",
        ReducerStage::Product => "product",
        ReducerStage::Sum => "sum",
    }
}

/// Builds `reducer`. `acc` holds the exact weighted sum of an entry's features. `result` is this
/// sum, rounded once, half to even, by W bits, or unrounded. A single id has weight 1.
///
/// In a unit without structured entries there is nothing to reduce: a `feature_register` holds the
/// feature, with the same latency.
///
/// # Errors
/// The netlist's own checks; the range analysis proves the accumulator.
pub(crate) fn reducer(config: &Config) -> Result<Arc<Module>, IrErrors> {
    let gu = &config.gu;
    let (features, weights) = (gu.feature_bits, gu.weight_bits);
    let mut m = ModuleBuilder::new(match gu.modes {
        Modes::Unstructured => "feature_register",
        _ => "reducer",
    });
    let enables = Enables::declare(&mut m, config);
    let feature = m.input("feature", Ty::s(features), "");
    if gu.modes == Modes::Unstructured {
        m.doc("Registers a feature: single ids need no reduction.");
        let mut held = feature;
        for (i, enable) in enables.all().enumerate() {
            let reg = m.data_reg(&format!("held{i}"), Ty::s(features));
            m.set_next_if(reg, enable, held);
            held = reg;
        }
        let result = m.as_unsigned(held);
        m.output("result", result, "the feature");
        let held = enables.0.iter().enumerate().map(|(at, (stage, _))| Held {
            register: format!("held{at}"),
            enable: if at == 0 { "valid" } else { stage_name(*stage) },
        });
        held_without_enable(&mut m, &held.collect::<Vec<_>>());
        return m.finish();
    }
    m.doc("Multiply-accumulate of one channel over an entry's vertices, rounded once.");
    let first = m.input("first", Ty::bit(), "the term of vertex 0: starts a new sum");
    let weight = m.input("weight", Ty::u(weights + 1), &format!("U1.{weights}"));
    let acc_bits = config.accumulator_bits();
    let acc = m.data_reg("acc", Ty::s(acc_bits));
    let product = product(&mut m, "", (feature, weight), &enables);
    // A product fits the sum's bits: the weight is at most 2^W, or the sum has four more.
    let term = if product.width() > acc_bits {
        m.truncate(product, acc_bits)
    } else {
        m.extend(product, acc_bits)
    };
    let term = m.name(term, "term");
    let total_so_far = m.add(acc, term);
    let total_so_far = m.name(total_so_far, "total_so_far");
    let next = m.mux(first, term, total_so_far);
    if let Some(enable) = enables.of(ReducerStage::Sum) {
        m.set_next_if(acc, enable, next);
    }
    if gu.weights == WeightTrust::Trusted && enables.of(ReducerStage::Product).is_none() {
        let total = BigInt::from(1) << weights;
        m.weighted_accumulator(acc, feature, total, "trusted weights sum to 2^W");
    } else {
        m.accumulator(acc, term, 8, "an entry has at most 8 vertices");
    }
    if gu.sums == Sums::Exact {
        // Trusted weights keep it below 2^31.
        let sum = m.truncate(acc, acc_bits.min(32));
        let result = m.as_unsigned(sum);
        m.output("result", result, "the sum so far, in units of 2^-W");
        enables.checks(&mut m, &[String::new()]);
        return m.finish();
    }
    let result = rounded_once(&mut m, config, acc);
    m.output("result", result, "the sum so far, rounded and saturated");
    enables.checks(&mut m, &[String::new()]);
    m.finish()
}

/// Product of a feature and a weight, after the built pipeline stages.
pub(crate) fn product(
    m: &mut ModuleBuilder,
    of: &str,
    (feature, weight): (Signal, Signal),
    enables: &Enables,
) -> Signal {
    let hold = |m: &mut ModuleBuilder, name: &str, value: Signal, enable: Signal| {
        let reg = m.data_reg(&format!("{name}{of}"), value.ty());
        m.set_next_if(reg, enable, value);
        reg
    };
    let (feature, weight) = match enables.of(ReducerStage::Operands) {
        Some(enable) => (
            hold(m, "held_feature", feature, enable),
            hold(m, "held_weight", weight, enable),
        ),
        None => (feature, weight),
    };
    let product = match enables.of(ReducerStage::PartialProducts) {
        Some(enable) => {
            let bits = weight.width();
            let low = m.slice(weight, 0, bits / 2);
            let high = m.slice(weight, bits / 2, bits - bits / 2);
            let (low, high) = (times(m, feature, low), times(m, feature, high));
            let low = hold(m, "product_of_low_bits", low, enable);
            let high = hold(m, "product_of_high_bits", high, enable);
            let ty = Ty::s(feature.width() + bits + 1);
            let high = m.extend(high, ty.width);
            let high = m.shl_const(high, bits / 2);
            let low = m.extend(low, ty.width);
            let high = m.truncate(high, ty.width);
            m.add(low, high)
        }
        None => times(m, feature, weight),
    };
    match enables.of(ReducerStage::Product) {
        Some(enable) => hold(m, "held_product", product, enable),
        None => m.name(product, &format!("product{of}")),
    }
}

/// Product of a signed feature and an unsigned weight, or a part of one.
fn times(m: &mut ModuleBuilder, feature: Signal, weight: Signal) -> Signal {
    let weight = m.extend(weight, weight.width() + 1);
    let weight = m.as_signed(weight);
    m.mul(feature, weight)
}

/// A sum, rounded half to even by W bits.
pub(crate) fn rounded_once(m: &mut ModuleBuilder, config: &Config, acc: Signal) -> Signal {
    let gu = &config.gu;
    let rounded = m.round(acc, gu.weight_bits, Rounding::HalfEven);
    let rounded = m.name(rounded, "rounded");
    let held = m.saturate(rounded, Ty::s(gu.feature_bits));
    m.as_unsigned(held)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use potamoi_formats::rit::MAX_VERTICES;

    use super::*;
    use potamoi_netlist::{Interval, IntervalInterpreter};

    /// Over all features and weights: a sum of eight products keeps every bit, and what comes
    /// out is half a unit off at most; sums that are left as they are, not at all.
    #[test]
    fn one_rounding_drops_bits_and_nothing_else() {
        for (sums, expected) in [(Sums::Rounded, 0.5), (Sums::Exact, 0.0)] {
            let mut config = Config::default();
            config.gu.sums = sums;
            let module = reducer(&config).unwrap();
            let mut machine = IntervalInterpreter::new(&module, &["acc", "result"], &[]).unwrap();
            let input = |name: &str| machine.find(name).unwrap();
            let [valid, first, feature, weight] =
                ["valid", "first", "feature", "weight"].map(input);
            let acc = machine.find("acc").unwrap();
            machine.set(valid, Interval::new(1, 1));
            machine.set(feature, Interval::all(Ty::s(config.gu.feature_bits)));
            // Eight of them are the weights' 1.
            machine.set(weight, Interval::new(0, 1 << (config.gu.weight_bits - 3)));
            for vertex in 0..MAX_VERTICES {
                let starts = u8::from(vertex == 0);
                machine.set(first, Interval::new(starts, starts));
                machine.settle();
                machine.clock();
            }
            machine.settle();
            let off = |id| machine.off(id).unwrap();
            // The result is the code of a signed value.
            let rounded = machine.find("rounded").unwrap_or(acc);
            for (found, expected) in [(off(acc), 0.0), (off(rounded), expected)] {
                let is_so = (found[1] - expected).abs() + (found[0] + expected).abs() < 1e-9;
                assert!(is_so, "{sums:?}: {found:?}, expected {expected}");
            }
        }
    }
}
