//! Reducer of the parity organisation, for all eight vertices of a cell at once.

use std::sync::Arc;

use potamoi_formats::config::Config;
use potamoi_formats::rit::MAX_VERTICES;
use potamoi_formats::timing::ReducerStage;
use potamoi_netlist::{IrErrors, Module, ModuleBuilder, Ty};

use crate::circuits::tree_sum;
use crate::gathering_unit::shared::reducer::{Enables, product, rounded_once};

/// Builds `cell_reducer`, the weighted sum of all eight vertices of a cell.
///
/// # Errors
/// The netlist's own checks.
pub(crate) fn cell_reducer(config: &Config) -> Result<Arc<Module>, IrErrors> {
    let gu = &config.gu;
    let (features, weights) = (gu.feature_bits, gu.weight_bits);
    let mut m = ModuleBuilder::new("cell_reducer");
    m.doc("Weighted sum of one channel over the eight vertices of a cell, rounded once.");
    let enables = Enables::declare(&mut m, config);
    let wide = Ty::s(config.accumulator_bits());
    let mut products = vec![];
    for v in 0..MAX_VERTICES {
        let feature = m.input(&format!("feature{v}"), Ty::s(features), "");
        let doc = format!("U1.{weights}");
        let weight = m.input(&format!("weight{v}"), Ty::u(weights + 1), &doc);
        let product = product(&mut m, &v.to_string(), (feature, weight), &enables);
        products.push(m.extend(product, wide.width));
    }
    let total = tree_sum(&mut m, &products);
    let acc = m.data_reg("acc", wide);
    if let Some(enable) = enables.of(ReducerStage::Sum) {
        m.set_next_if(acc, enable, total);
    }
    let result = rounded_once(&mut m, config, acc);
    m.output("result", result, "the sum, rounded and saturated");
    let vertices: Vec<String> = (0..MAX_VERTICES).map(|v| v.to_string()).collect();
    enables.checks(&mut m, &vertices);
    m.finish()
}
