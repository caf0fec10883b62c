//! Compare and subtract on `R_remain`, shift and add on `R_accum`.

use potamoi_formats::config::{Engine, ExpConfig};

use super::c_header::{table, tail};
use super::form::{FAR_BIAS, Form, Raw};
use crate::logarithms::{ln_one_plus_power, multiple_of_ln2};

/// The constants of a restoring engine.
#[derive(Debug, Clone)]
pub(super) struct Restoring {
    engine: Engine,
    tail: bool,
    digits: Vec<i64>,
    steps: Vec<(u32, i64)>,
    start: i64,
    start_far: i64,
    /// With early out: the iterations of a power, by its exponent.
    early: Option<Vec<usize>>,
}

impl Restoring {
    pub(super) fn new(config: &ExpConfig) -> Self {
        let mut engine = config.engine();
        engine.accumulator_bits = engine.accumulator_bits.min(40);
        engine.constant_bits = engine.constant_bits.min(40);
        let (n, wc) = (config.iterations.min(31), engine.constant_bits);
        let centre = if engine.centred && wc > n {
            1 << (wc - n - 1)
        } else {
            0
        };
        let biased = |bias: u32| -> i64 {
            let digits = (0..u32::BITS).filter(|j| bias >> j & 1 == 1);
            digits.map(|j| multiple_of_ln2(j, wc)).sum::<i64>() + centre
        };
        Self {
            engine,
            tail: config.tail,
            digits: (0..engine.digits)
                .rev()
                .map(|j| multiple_of_ln2(j, wc))
                .collect(),
            steps: (1..=n).map(|i| (i, ln_one_plus_power(i, wc))).collect(),
            start: biased(engine.bias),
            start_far: biased(FAR_BIAS),
            early: config.early_out.then(|| {
                let iterations = |k| config.clocks_of(k) * config.iterations_per_clock;
                (0..=FAR_BIAS)
                    .map(|k| iterations(k).saturating_sub(engine.digits) as usize)
                    .collect()
            }),
        }
    }

    fn restore(&self, start: i64, bias: u32) -> Raw {
        let mut remain = start;
        let mut taken = 0;
        for &c in &self.digits {
            taken <<= 1;
            if remain >= c {
                remain -= c;
                taken |= 1;
            }
        }
        let mut accumulator =
            (1i64 << self.engine.accumulator_bits) + i64::from(self.engine.offset);
        let k = (bias as i32 - taken).clamp(0, FAR_BIAS as i32) as usize;
        let count = self.early.as_ref().and_then(|early| early.get(k).copied());
        for &(i, c) in self.steps.iter().take(count.unwrap_or(usize::MAX)) {
            if remain >= c {
                remain -= c;
                accumulator += (accumulator >> i) + (accumulator >> (i - 1) & 1);
            }
        }
        if self.tail {
            let product = i128::from(accumulator) * i128::from(remain);
            accumulator += (product >> self.engine.constant_bits) as i64;
        }
        Raw {
            accumulator,
            remain,
            exponent: taken - bias as i32,
        }
    }
}

impl Form for Restoring {
    fn power(&self, value: i64, far: bool) -> Raw {
        if far {
            self.restore(self.start_far - value, FAR_BIAS)
        } else {
            self.restore(self.start - value, self.engine.bias)
        }
    }

    fn signed_power(&self, value: i64) -> Raw {
        self.restore(self.start + value, self.engine.bias)
    }

    fn c_power(&self) -> String {
        let bits = self.engine.constant_bits;
        let logs: Vec<_> = self.steps.iter().map(|&(_, c)| c).collect();
        let (early, last) = match &self.early {
            None => (String::new(), logs.len().to_string()),
            Some(early) => {
                let counts: Vec<_> = early.iter().map(|&n| n.min(logs.len()) as i64).collect();
                (
                    format!(
                        "    /* Iterations of a power, by minus its exponent. */\n{}\n",
                        table("int", "counts", &counts)
                    ),
                    "counts[exponent < 0 ? -exponent : 0]".to_owned(),
                )
            }
        };
        format!(
            r"    /* Constants have {bits} fraction bits and are rounded to nearest.
       digits: 2^j ln 2, the highest j first; logs: ln(1 + 2^-i), i = 1, 2, .. */
{digits}
{logs}
{early}    int64_t remain = INT64_C({start}) - value;
    int last, i;
    exponent = 0;
    for (i = 0; i < {digit_count}; i++) {{
        exponent *= 2;
        if (remain >= digits[i]) {{
            remain -= digits[i];
            exponent += 1;
        }}
    }}
    exponent -= {bias};
    last = {last};
    accumulator = INT64_C({one});
    for (i = 1; i <= last; i++) {{
        if (remain >= logs[i - 1]) {{
            remain -= logs[i - 1];
            /* Rounded by the highest bit that the shift drops. */
            accumulator += (accumulator >> i) + ((accumulator >> (i - 1)) & 1);
        }}
    }}
{tail}",
            digits = table("int64_t", "digits", &self.digits),
            digit_count = self.digits.len(),
            logs = table("int64_t", "logs", &logs),
            start = self.start,
            bias = self.engine.bias,
            one = (1i64 << self.engine.accumulator_bits) + i64::from(self.engine.offset),
            tail = tail(self.tail, bits),
        )
    }
}
