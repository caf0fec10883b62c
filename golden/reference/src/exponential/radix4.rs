//! Compare and subtract, two bits at a time: the largest of three multiples of a digit's weight
//! that fits is subtracted.

use potamoi_formats::config::{Engine, ExpConfig};

use super::c_header::{table, tail};
use super::form::{FAR_BIAS, Form, Raw};
use crate::logarithms::{ln_one_plus_ratio, times_ln2};

/// The constants of a radix-4 engine.
#[derive(Debug, Clone)]
pub(super) struct Radix4 {
    engine: Engine,
    tail: bool,
    /// `d 4^j ln 2`, d = 1..3, highest j first.
    digits: Vec<[i64; 3]>,
    /// `2 j` and `ln(1 + d 4^-j)`, j = 1..J.
    steps: Vec<(u32, [i64; 3])>,
    centre: i64,
}

impl Radix4 {
    pub(super) fn new(config: &ExpConfig) -> Self {
        let mut engine = config.engine();
        engine.accumulator_bits = engine.accumulator_bits.min(40);
        engine.constant_bits = engine.constant_bits.min(40);
        let (bits, n) = (engine.constant_bits, config.resolved_bits());
        let digits = (0..engine.digits).rev();
        Self {
            engine,
            tail: config.tail,
            digits: digits
                .map(|j| [1, 2, 3].map(|d| times_ln2(d << (2 * j), bits)))
                .collect(),
            steps: (1..=config.iterations.min(15))
                .map(|j| (2 * j, [1, 2, 3].map(|d| ln_one_plus_ratio(d, 2 * j, bits))))
                .collect(),
            centre: if engine.centred && bits > n {
                1 << (bits - n - 1)
            } else {
                0
            },
        }
    }
}

impl Radix4 {
    /// The first remainder: `bias ln 2`, accumulated digit by digit, and the centre.
    fn start(&self, bias: u32) -> i64 {
        let places = (0..u32::BITS / 2).map(|j| ((bias >> (2 * j)) & 3) << (2 * j));
        let biased = places
            .filter(|&part| part > 0)
            .map(|part| times_ln2(part, self.engine.constant_bits))
            .sum::<i64>();
        biased + self.centre
    }
}

impl Form for Radix4 {
    fn power(&self, value: i64, far: bool) -> Raw {
        let bias = if far { FAR_BIAS } else { self.engine.bias };
        let mut remain = self.start(bias) - value;
        let mut taken = 0;
        for multiples in &self.digits {
            taken = 4 * taken + subtract(&mut remain, multiples) as i32;
        }
        let mut accumulator =
            (1i64 << self.engine.accumulator_bits) + i64::from(self.engine.offset);
        for (shift, multiples) in &self.steps {
            let multiple = accumulator * subtract(&mut remain, multiples);
            accumulator += (multiple >> shift) + (multiple >> (shift - 1) & 1);
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

    fn c_power(&self) -> String {
        let bits = self.engine.constant_bits;
        let logs: Vec<_> = self.steps.iter().flat_map(|&(_, own)| own).collect();
        format!(
            r"    /* Constants have {bits} fraction bits and are rounded to nearest, three for each digit.
       digits: d 4^j ln 2, the highest j first; logs: ln(1 + d 4^-j), j = 1, 2, .. */
{digits}
{logs}
    int64_t remain = INT64_C({start}) - value;
    int i;
    exponent = 0;
    for (i = 0; i < {digit_count}; i++) {{
        const int64_t *own = digits + 3 * i;
        const int digit = (remain >= own[0]) + (remain >= own[1]) + (remain >= own[2]);
        remain -= digit > 0 ? own[digit - 1] : 0;
        exponent = 4 * exponent + digit;
    }}
    exponent -= {bias};
    accumulator = INT64_C({one});
    for (i = 1; i <= {log_count}; i++) {{
        const int64_t *own = logs + 3 * (i - 1);
        const int digit = (remain >= own[0]) + (remain >= own[1]) + (remain >= own[2]);
        const int64_t multiple = accumulator * digit;
        remain -= digit > 0 ? own[digit - 1] : 0;
        /* Rounded by the highest bit that the shift drops. */
        accumulator += (multiple >> (2 * i)) + ((multiple >> (2 * i - 1)) & 1);
    }}
{tail}",
            digits = table("int64_t", "digits", self.digits.as_flattened()),
            digit_count = self.digits.len(),
            logs = table("int64_t", "logs", &logs),
            log_count = self.steps.len(),
            start = self.start(self.engine.bias),
            bias = self.engine.bias,
            one = (1i64 << self.engine.accumulator_bits) + i64::from(self.engine.offset),
            tail = tail(self.tail, bits),
        )
    }
}

/// Subtracts the largest multiple that fits and returns its number.
fn subtract(remain: &mut i64, multiples: &[i64; 3]) -> i64 {
    let digit = multiples.iter().filter(|&m| *remain >= *m).count();
    if let Some(index) = digit.checked_sub(1) {
        *remain -= multiples[index];
    }
    digit as i64
}
