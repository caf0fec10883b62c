//! Splits of sums along an axis of a cell, in one stage or two.

use potamoi_formats::compact::FRACTION_BITS;
use potamoi_formats::fixed::Rounding;
use potamoi_formats::timing::RitStage;
use potamoi_netlist::{ModuleBuilder, Signal, Ty};

use super::rit_reader::{Filled, Read};
use super::rit_shape::Shape;

/// Registers a value in each of the stages.
pub(crate) fn carry(
    m: &mut ModuleBuilder,
    port: u32,
    stages: &[Filled],
    name: &str,
    value: Signal,
) -> Signal {
    carry_named(m, stages, &format!("{name}{port}"), value)
}

/// As [`carry`], for a value without a port, or with the port in its name.
pub(crate) fn carry_named(
    m: &mut ModuleBuilder,
    stages: &[Filled],
    name: &str,
    mut value: Signal,
) -> Signal {
    for (stage, fill) in stages {
        let reg = m.data_reg(&format!("{stage}_{name}"), value.ty());
        m.set_next_if(reg, *fill, value);
        value = reg;
    }
    value
}

/// Stages after E in which weights are computed.
pub(crate) struct WeightStages {
    /// G, where it is built: the product along y.
    pub(crate) product_y: Vec<Filled>,
    /// F: the part after y.
    pub(crate) part_y: Vec<Filled>,
    /// G and F.
    pub(crate) to_part_y: Vec<Filled>,
    /// H, where it is built: the product along x.
    pub(crate) product_x: Vec<Filled>,
}

impl WeightStages {
    pub(crate) fn of(read: &Read) -> Self {
        Self {
            product_y: read.stages([RitStage::ProductY]),
            part_y: read.stages([RitStage::PartY]),
            to_part_y: read.stages([RitStage::ProductY, RitStage::PartY]),
            product_x: read.stages([RitStage::ProductX]),
        }
    }
}

/// 1 split along the last axis: no multiplier.
pub(crate) fn first_split(
    m: &mut ModuleBuilder,
    shape: &Shape,
    name: &str,
    fraction: Signal,
) -> (Signal, Signal) {
    let w = shape.weight_bits;
    let top = FRACTION_BITS - 1;
    let (one, part) = (m.bit(fraction, top), m.slice(fraction, 0, top));
    // A fraction above 1 counts as 1.
    let below = m.not(one);
    let mask = m.repeat(below, top);
    let part = m.and(part, mask);
    let fraction = m.cat(&[one, part]);
    let high = if w >= top {
        let zeros = (w > top).then(|| m.lit(0, Ty::u(w - top)));
        let parts: Vec<_> = [Some(fraction), zeros].into_iter().flatten().collect();
        m.cat(&parts)
    } else {
        let rounded = m.round(fraction, top - w, Rounding::HalfUp);
        m.truncate(rounded, w + 1)
    };
    let high = m.name(high, &format!("high_{name}"));
    let one = m.lit(1u32 << w, Ty::u(w + 1));
    let low = m.sub(one, high);
    (m.name(low, &format!("low_{name}")), high)
}

/// Whether a fraction is 1, which its truncated product does not show.
pub(crate) fn is_one(m: &mut ModuleBuilder, fraction: Signal) -> Signal {
    m.bit(fraction, FRACTION_BITS - 1)
}

/// A sum, and its unrounded product with a fraction below 1.
pub(crate) struct Product {
    sum: Signal,
    product: Signal,
    /// Bits of the product below those of the sum.
    below: u32,
}

impl Product {
    pub(crate) fn of(m: &mut ModuleBuilder, name: &str, sum: Signal, fraction: Signal) -> Self {
        let below = FRACTION_BITS - 1;
        let part = m.slice(fraction, 0, below);
        let product = m.mul(sum, part);
        Self {
            sum,
            product: m.name(product, &format!("product_{name}")),
            below,
        }
    }

    /// Registers it in each stage, with the bits needed for rounding half up.
    pub(crate) fn carry(self, m: &mut ModuleBuilder, stages: &[Filled], name: &str) -> Self {
        if stages.is_empty() {
            return self;
        }
        let from = self.below - 1;
        let product = m.slice(self.product, from, self.product.width() - from);
        Self {
            sum: carry_named(m, stages, &format!("whole_{name}"), self.sum),
            product: carry_named(m, stages, &format!("product_{name}"), product),
            below: 1,
        }
    }

    /// Splits the sum at the product, rounded half up; the second part is the whole sum where the
    /// fraction is `one`.
    pub(crate) fn split(self, m: &mut ModuleBuilder, name: &str, one: Signal) -> (Signal, Signal) {
        let rounded = m.round(self.product, self.below, Rounding::HalfUp);
        let rounded = m.truncate(rounded, self.sum.width());
        let rounded = m.name(rounded, &format!("rounded_{name}"));
        let high = m.mux(one, self.sum, rounded);
        let high = m.name(high, &format!("high_{name}"));
        let low = m.sub(self.sum, high);
        (m.name(low, &format!("low_{name}")), high)
    }
}
