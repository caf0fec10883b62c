//! The recurrence as the paper prints it.

use potamoi_formats::config::{Engine, ExpConfig};

use super::c_header::table;
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

    fn c_power(&self) -> String {
        let logs: Vec<_> = self.steps.iter().map(|&(_, c)| c).collect();
        format!(
            r"    /* ln(1 + 2^-i), i = 0, 1, ..: {bits} fraction bits, to nearest. */
{logs}
    int64_t remain = -value;
    int i;
    accumulator = INT64_C({one});
    exponent = 0;
    for (i = 0; i < {count}; i++) {{
        if (remain >= logs[i]) {{
            remain -= logs[i];
            accumulator += accumulator >> i; /* towards zero */
        }}
    }}
",
            bits = self.engine.constant_bits,
            count = logs.len(),
            logs = table("int64_t", "logs", &logs),
            one = 1i64 << self.engine.accumulator_bits,
        )
    }
}
