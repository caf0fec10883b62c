//! Sums split along an axis of a cell, in one stage or two.

use potamoi_formats::compact::FRACTION_BITS;
use potamoi_formats::fixed::Rounding;

use super::rit_reader::Read;
use super::rit_shape::Shape;
use crate::ir::{ModuleBuilder, Signal, Ty};

/// Stages that values pass: their names, and when they are filled.
pub(super) type Stages = [(&'static str, Signal)];

/// Registers a value in each of the stages.
pub(super) fn carry(
    m: &mut ModuleBuilder,
    port: u32,
    stages: &Stages,
    name: &str,
    mut value: Signal,
) -> Signal {
    for (stage, fill) in stages {
        let reg = m.reg(&format!("{stage}_{name}{port}"), value.ty(), 0);
        m.set_next_if(reg, *fill, value);
        value = reg;
    }
    value
}

/// Stages behind E in which weights are made: where pipelined, G and H hold products.
pub(super) struct WeightStages {
    /// To F.
    pub(super) to_f: Vec<(&'static str, Signal)>,
    /// To P's inputs.
    pub(super) to_p: Vec<(&'static str, Signal)>,
}

impl WeightStages {
    pub(super) fn of(read: &Read) -> Self {
        match read.fills[..] {
            [_, g, f, h, _] => Self {
                to_f: vec![("g", g), ("f", f)],
                to_p: vec![("h", h)],
            },
            _ => Self {
                to_f: vec![("f", read.fills[1])],
                to_p: vec![],
            },
        }
    }

    /// Those of them that hold the product along y.
    pub(super) fn of_y(&self) -> &Stages {
        &self.to_f[..self.to_f.len() - 1]
    }

    /// The stage that holds the sums after y.
    pub(super) fn f(&self) -> &Stages {
        &self.to_f[self.to_f.len() - 1..]
    }
}

/// 1 split along the last axis: no multiplier.
pub(super) fn first_split(
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

/// A sum and its product with a fraction, not rounded.
pub(super) struct Product {
    sum: Signal,
    product: Signal,
    /// The fraction is 1.
    one: Signal,
}

impl Product {
    pub(super) fn of(m: &mut ModuleBuilder, name: &str, sum: Signal, fraction: Signal) -> Self {
        let top = FRACTION_BITS - 1;
        let (one, part) = (m.bit(fraction, top), m.slice(fraction, 0, top));
        let product = m.mul(sum, part);
        Self {
            sum,
            product: m.name(product, &format!("product_{name}")),
            one,
        }
    }

    /// Registers it in each of the stages.
    pub(super) fn carry(
        self,
        m: &mut ModuleBuilder,
        port: u32,
        stages: &Stages,
        axis: &str,
    ) -> Self {
        let mut through =
            |name: &str, value| carry(m, port, stages, &format!("{name}_{axis}"), value);
        Self {
            sum: through("whole", self.sum),
            product: through("product", self.product),
            one: through("one", self.one),
        }
    }

    /// The sum in two parts, the product rounded half up.
    pub(super) fn split(self, m: &mut ModuleBuilder, name: &str) -> (Signal, Signal) {
        let rounded = m.round(self.product, FRACTION_BITS - 1, Rounding::HalfUp);
        let rounded = m.truncate(rounded, self.sum.width());
        let rounded = m.name(rounded, &format!("rounded_{name}"));
        let high = m.mux(self.one, self.sum, rounded);
        let high = m.name(high, &format!("high_{name}"));
        let low = m.sub(self.sum, high);
        (m.name(low, &format!("low_{name}")), high)
    }
}
