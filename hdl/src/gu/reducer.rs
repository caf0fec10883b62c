//! The reducers: a multiply-accumulate for one channel of one port, over an
//! entry's vertices one after the other, or over all eight of a cell at once.

use std::sync::Arc;

use num_bigint::BigInt;
use potamoi_formats::config::{Config, Modes, Sums, WeightTrust};
use potamoi_formats::fixed::Rounding;
use potamoi_formats::rit::MAX_VERTICES;

use crate::ir::{IrErrors, Module, ModuleBuilder, Signal, Ty};
use crate::parts::tree_sum;

/// Builds `reducer`: `acc` holds the exact weighted sum of an entry's
/// features; `result` is it rounded once, half-even, by W bits, or as it is.
///
/// In a unit without structured entries there is nothing to reduce: the
/// feature is registered, at the same latency. Where products are registered,
/// `sum` and `first` come a cycle after `valid`.
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
        let mut held = m.reg("held", Ty::s(features), 0);
        m.set_next_if(held, valid, feature);
        if config.registers_products() {
            let sum = m.input("sum", Ty::bit(), "the feature is held a second time");
            let again = m.reg("held_again", Ty::s(features), 0);
            m.set_next_if(again, sum, held);
            held = again;
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
    let (term, summed) = if config.registers_products() {
        let held = m.reg("held_term", term.ty(), 0);
        m.set_next_if(held, valid, term);
        (held, m.input("sum", Ty::bit(), "the term is summed up"))
    } else {
        (term, valid)
    };
    let total_so_far = m.add(acc, term);
    let total_so_far = m.name(total_so_far, "total_so_far");
    let next = m.mux(first, term, total_so_far);
    m.set_next_if(acc, summed, next);
    let total = BigInt::from(1) << weights;
    match gu.weights {
        WeightTrust::Trusted => {
            m.weighted_accumulator(acc, feature, total, "trusted weights sum to 2^W")
        }
        WeightTrust::Any => m.accumulator(acc, term, 8, "an entry has at most 8 vertices"),
    }
    if gu.sums == Sums::Exact {
        let result = m.as_unsigned(acc);
        m.output("result", result, "the sum so far, in units of 2^-W");
        return m.finish();
    }
    let result = rounded_once(&mut m, config, acc);
    m.output("result", result, "the sum so far, rounded and saturated");
    m.finish()
}

/// Builds `cell_reducer`: the weighted sum of all eight vertices of a cell at once.
/// Products are registered with `valid`, their sum with `sum`.
///
/// # Errors
/// The netlist's own checks.
pub(super) fn cell_reducer(config: &Config) -> Result<Arc<Module>, IrErrors> {
    let gu = &config.gu;
    let (features, weights) = (gu.feature_bits, gu.weight_bits);
    let mut m = ModuleBuilder::new("cell_reducer");
    m.doc("Weighted sum of one channel over the eight vertices of a cell, rounded once.");
    let valid = m.input("valid", Ty::bit(), "features and weights are given");
    let sum = m.input("sum", Ty::bit(), "the products are summed up");
    // Eight products of any codes.
    let wide = Ty::s(features + weights + 4);
    let mut products = vec![];
    for v in 0..MAX_VERTICES {
        let feature = m.input(&format!("feature{v}"), Ty::s(features), "");
        let doc = format!("U1.{weights}");
        let weight = m.input(&format!("weight{v}"), Ty::u(weights + 1), &doc);
        let weight = m.extend(weight, weights + 2);
        let weight = m.as_signed(weight);
        let product = m.mul(feature, weight);
        let held = m.reg(&format!("product{v}"), product.ty(), 0);
        m.set_next_if(held, valid, product);
        products.push(m.extend(held, wide.width));
    }
    let total = tree_sum(&mut m, &products);
    let acc = m.reg("acc", wide, 0);
    m.set_next_if(acc, sum, total);
    let result = rounded_once(&mut m, config, acc);
    m.output("result", result, "the sum, rounded and saturated");
    m.finish()
}

/// A sum rounded half-even by W bits.
fn rounded_once(m: &mut ModuleBuilder, config: &Config, acc: Signal) -> Signal {
    let gu = &config.gu;
    let rounded = m.round(acc, gu.weight_bits, Rounding::HalfEven);
    let rounded = m.name(rounded, "rounded");
    let held = m.saturate(rounded, Ty::s(gu.feature_bits));
    m.as_unsigned(held)
}
