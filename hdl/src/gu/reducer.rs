//! One reducer: a multiply-accumulate for one channel of one port.

use std::sync::Arc;

use num_bigint::BigInt;
use potamoi_formats::config::{Config, Modes, WeightTrust};
use potamoi_formats::fixed::Rounding;

use crate::ir::{IrErrors, Module, ModuleBuilder, Ty};

/// Builds `reducer`: `acc` holds the exact weighted sum of an entry's
/// features; `result` is it rounded once, half-even, by W bits.
///
/// In a unit without structured entries there is nothing to reduce: the
/// feature is registered, at the same latency.
///
/// # Errors
/// The netlist's own checks; the range analysis proves the accumulator.
pub(super) fn reducer(config: &Config) -> Result<Arc<Module>, IrErrors> {
    let gu = &config.gu;
    let (features, weights) = (gu.feature_bits, gu.weight_bits);
    let mut m = ModuleBuilder::new("reducer");
    let valid = m.input("valid", Ty::bit(), "a feature is given");
    let feature = m.input("feature", Ty::s(features), "");
    if gu.modes == Modes::Unstructured {
        m.doc("Registers a feature: single ids need no reduction.");
        let held = m.reg("held", Ty::s(features), 0);
        m.set_next_if(held, valid, feature);
        let result = m.as_unsigned(held);
        m.output("result", result, "one cycle later");
        return m.finish();
    }
    m.doc("Multiply-accumulate of one channel over an entry's vertices, rounded once.");
    let first = m.input("first", Ty::bit(), "vertex 0: starts a new sum");
    let weight = m.input("weight", Ty::u(weights + 1), &format!("U1.{weights}"));
    let acc_bits = config.accumulator_bits();
    let acc = m.reg("acc", Ty::s(acc_bits), 0);
    let weight_signed = m.extend(weight, weights + 2);
    let weight_signed = m.as_signed(weight_signed);
    let weight_signed = m.name(weight_signed, "weight_signed");
    let product = m.mul(feature, weight_signed);
    let product = m.name(product, "product");
    // A product fits the sum's bits: the weight is at most 2^W, or the sum has four more.
    let term = if product.width() > acc_bits {
        m.truncate(product, acc_bits)
    } else {
        m.extend(product, acc_bits)
    };
    let term = if gu.modes == Modes::Both {
        let skip = m.input("skip", Ty::bit(), "a single id: the feature is the result");
        let no_fraction = m.lit(0, Ty::u(weights));
        let feature_bits = m.as_unsigned(feature);
        let whole = m.cat(&[feature_bits, no_fraction]);
        let whole = m.as_signed(whole);
        let whole = m.extend(whole, acc_bits);
        m.mux(skip, whole, term)
    } else {
        term
    };
    let term = m.name(term, "term");
    let sum = m.add(acc, term);
    let sum = m.name(sum, "sum");
    let next = m.mux(first, term, sum);
    m.set_next_if(acc, valid, next);
    let total = BigInt::from(1) << weights;
    match gu.weights {
        WeightTrust::Trusted => {
            m.weighted_accumulator(acc, feature, total, "trusted weights sum to 2^W")
        }
        WeightTrust::Any => m.accumulator(acc, term, 8, "an entry has at most 8 vertices"),
    }
    let rounded = m.round(acc, weights, Rounding::HalfEven);
    let rounded = m.name(rounded, "rounded");
    let held = m.saturate(rounded, Ty::s(features));
    let result = m.as_unsigned(held);
    m.output("result", result, "the sum so far, rounded and saturated");
    m.finish()
}
