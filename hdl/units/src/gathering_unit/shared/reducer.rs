//! The reducer: a multiply-accumulate for one channel of one port, over an
//! entry's vertices one after the other.

use std::sync::Arc;

use num_bigint::BigInt;
use potamoi_formats::config::{Config, Modes, Sums, WeightTrust};
use potamoi_formats::fixed::Rounding;
use potamoi_netlist::{IrErrors, Module, ModuleBuilder, Signal, Ty};

/// Names of the enables of a product's stages, after `valid`.
pub(crate) const LATER: [&str; 3] = ["halves", "product", "sum"];

/// Builds `reducer`: `acc` holds the exact weighted sum of an entry's
/// features; `result` is it rounded once, half-even, by W bits, or as it is. A
/// single id has the weight 1.
///
/// In a unit without structured entries there is nothing to reduce: a
/// `feature_register` holds the feature, at the same latency.
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
    let enables = enables(&mut m, config);
    let feature = m.input("feature", Ty::s(features), "");
    if gu.modes == Modes::Unstructured {
        m.doc("Registers a feature: single ids need no reduction.");
        let mut held = feature;
        for (i, enable) in enables.into_iter().enumerate() {
            let reg = m.reg(&format!("held{i}"), Ty::s(features), 0);
            m.set_next_if(reg, enable, held);
            held = reg;
        }
        let result = m.as_unsigned(held);
        m.output("result", result, "the feature");
        return m.finish();
    }
    m.doc("Multiply-accumulate of one channel over an entry's vertices, rounded once.");
    let first = m.input("first", Ty::bit(), "the term of vertex 0: starts a new sum");
    let weight = m.input("weight", Ty::u(weights + 1), &format!("U1.{weights}"));
    let acc_bits = config.accumulator_bits();
    let acc = m.reg("acc", Ty::s(acc_bits), 0);
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
    m.set_next_if(acc, enables[enables.len() - 1], next);
    if gu.weights == WeightTrust::Trusted && config.product_stages() == 0 {
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
        return m.finish();
    }
    let result = rounded_once(&mut m, config, acc);
    m.output("result", result, "the sum so far, rounded and saturated");
    m.finish()
}

/// Enables of the register stages up to the sum.
pub(crate) fn enables(m: &mut ModuleBuilder, config: &Config) -> Vec<Signal> {
    let mut all = vec![m.input("valid", Ty::bit(), "features and weights are given")];
    let later = &LATER[LATER.len() - config.product_stages() as usize..];
    for name in later {
        all.push(m.input(name, Ty::bit(), "the next stage takes over"));
    }
    all
}

/// A feature times a weight, as it is, registered, or behind three register stages:
/// the operands, so that they reach many reducers in a cycle of their own, then the
/// product with each half of the weight, then their sum.
pub(crate) fn product(
    m: &mut ModuleBuilder,
    of: &str,
    (feature, weight): (Signal, Signal),
    enables: &[Signal],
) -> Signal {
    let times = |m: &mut ModuleBuilder, feature: Signal, part: Signal| {
        let part = m.extend(part, part.width() + 1);
        let part = m.as_signed(part);
        m.mul(feature, part)
    };
    let hold = |m: &mut ModuleBuilder, name: &str, value: Signal, enable: Signal| {
        let reg = m.reg(&format!("{name}{of}"), value.ty(), 0);
        m.set_next_if(reg, enable, value);
        reg
    };
    match enables {
        [valid, multiplied, taken, _] => {
            let feature = hold(m, "held_feature", feature, *valid);
            let weight = hold(m, "held_weight", weight, *valid);
            let bits = weight.width();
            let low = m.slice(weight, 0, bits / 2);
            let high = m.slice(weight, bits / 2, bits - bits / 2);
            let (low, high) = (times(m, feature, low), times(m, feature, high));
            let low = hold(m, "product_of_low_bits", low, *multiplied);
            let high = hold(m, "product_of_high_bits", high, *multiplied);
            let ty = Ty::s(feature.width() + bits + 1);
            let high = m.extend(high, ty.width);
            let high = m.shl_const(high, bits / 2);
            let low = m.extend(low, ty.width);
            let high = m.truncate(high, ty.width);
            let both = m.add(low, high);
            hold(m, "held_product", both, *taken)
        }
        [valid, _] => {
            let product = times(m, feature, weight);
            hold(m, "held_product", product, *valid)
        }
        _ => {
            let product = times(m, feature, weight);
            m.name(product, &format!("product{of}"))
        }
    }
}

/// A sum rounded half-even by W bits.
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
    use potamoi_netlist::{Interval, Machine};

    /// Over all features and weights: a sum of eight products keeps every bit, and what comes
    /// out is half a unit off at most; sums that are left as they are, not at all.
    #[test]
    fn one_rounding_drops_bits_and_nothing_else() {
        for (sums, expected) in [(Sums::Rounded, 0.5), (Sums::Exact, 0.0)] {
            let mut config = Config::default();
            config.gu.sums = sums;
            let module = reducer(&config).unwrap();
            let mut machine = Machine::new(&module, &["acc", "result"], &[]).unwrap();
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
