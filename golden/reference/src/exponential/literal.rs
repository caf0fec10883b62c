//! The recurrence as the paper prints it.

use potamoi_formats::config::{Engine, ExpConfig};

use super::form::{Form, Raw};
use crate::logarithms::ln_one_plus_power;

/// The constants of a literal engine.
#[derive(Debug, Clone)]
pub(super) struct Literal {
    engine: Engine,
    steps: Vec<(u32, i64)>,
}

impl Literal {
    pub(super) fn new(config: &ExpConfig) -> Self {
        let mut engine = config.engine();
        engine.accumulator_bits = engine.accumulator_bits.min(40);
        engine.constant_bits = engine.constant_bits.min(40);
        let bits = engine.constant_bits;
        let steps = 0..config.iterations.min(31);
        Self {
            engine,
            steps: steps.map(|i| (i, ln_one_plus_power(i, bits))).collect(),
        }
    }
}

impl Form for Literal {
    fn power(&self, value: i64, _far: bool) -> Raw {
        self.signed_power(-value)
    }

    fn signed_power(&self, value: i64) -> Raw {
        let mut remain = value;
        let mut accumulator = 1i64 << self.engine.accumulator_bits;
        for &(i, c) in &self.steps {
            if remain >= c {
                remain -= c;
                accumulator += accumulator >> i;
            }
        }
        Raw {
            accumulator,
            remain,
            exponent: 0,
        }
    }

    fn is_bare(&self) -> bool {
        true
    }
}
