//! Declared bounds of values, for the range analysis.

use num_bigint::BigInt;

use super::ModuleBuilder;
use crate::node::{Contract, Signal};

impl ModuleBuilder {
    /// Declares the range of an input.
    pub fn assume_range(
        &mut self,
        s: Signal,
        low: impl Into<BigInt>,
        high: impl Into<BigInt>,
        why: &str,
    ) {
        self.module.contracts.push(Contract::Range {
            node: s.id,
            low: low.into(),
            high: high.into(),
            why: why.to_owned(),
        });
    }

    /// Declares that a register holds the sum of at most `most` terms.
    pub fn accumulator(&mut self, reg: Signal, term: Signal, most: u32, why: &str) {
        self.module.contracts.push(Contract::Terms {
            reg: reg.id,
            term: term.id,
            most,
            why: why.to_owned(),
        });
    }

    /// Declares that a register holds features weighted by non-negative codes
    /// that sum to at most `total`.
    pub fn weighted_accumulator(
        &mut self,
        reg: Signal,
        feature: Signal,
        total: impl Into<BigInt>,
        why: &str,
    ) {
        self.module.contracts.push(Contract::Weighted {
            reg: reg.id,
            feature: feature.id,
            total: total.into(),
            why: why.to_owned(),
        });
    }
}
