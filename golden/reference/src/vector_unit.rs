//! The vector unit's arithmetic, element by element.

use std::sync::Arc;

use potamoi_formats::config::VuConfig;
use potamoi_formats::fixed::round_shift;
use potamoi_formats::units::{OpCode, VectorOp};
use rayon::prelude::*;
use thiserror::Error;

use super::exp_table::ExpTable;
use super::exponential::ReferenceExponential;

/// A request that the vector unit refuses.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum VectorError {
    /// The operation was not built.
    #[error(
        "vector operation {} is not built: vu.ops is {}; add it to vu.ops in the configuration",
        op.name(),
        OpCode::list(built)
    )]
    NotBuilt {
        /// The requested operation.
        op: OpCode,
        /// The operations that were built.
        built: Vec<OpCode>,
    },
    /// The operation field cannot hold the shift.
    #[error("vector operation {} with shift {shift}: expected 0 to 63", op.name())]
    Shift {
        /// The operation.
        op: OpCode,
        /// The requested shift.
        shift: u8,
    },
    /// An operand is beyond the width that the lanes have for it.
    #[error(
        "vector operation {} with {operand}[{index}] = {value}: expected {low} to {high}, \
         {bits} signed bits as {field} gives; another value raises flag 3 of stat_errors \
         (operand beyond its width); widen the field, or leave it out for 32 bits",
        op.name()
    )]
    Beyond {
        /// The operation.
        op: OpCode,
        /// `a` or `b`.
        operand: char,
        /// The element.
        index: usize,
        /// The operand's value.
        value: i32,
        /// The operand's width.
        bits: u32,
        /// Smallest value within the width.
        low: i32,
        /// Largest value within the width.
        high: i32,
        /// Field of the configuration with the width.
        field: &'static str,
    },
    /// The slices differ in length.
    #[error(
        "vector operation {op:?} on slices of unequal lengths: a has {a}, b has {b}, \
         out has {out} elements"
    )]
    Lengths {
        /// The operation.
        op: OpCode,
        /// Elements of `a`.
        a: usize,
        /// Elements of `b`.
        b: usize,
        /// Elements of `out`.
        out: usize,
    },
}

/// Elements that one thread computes at a time.
const CHUNK: usize = 4096;

/// Bit-exact model of the vector unit's lanes, without timing.
#[derive(Debug, Clone)]
pub struct ReferenceVectorUnit {
    ops: Vec<OpCode>,
    exp: ReferenceExponential,
    /// Results of `exp`, where operands have few bits.
    exps: Option<Arc<ExpTable>>,
    /// Signed widths of `a` and `b` of multiply and of square-sum.
    multiply: [u32; 2],
    square_sum: [u32; 2],
}

impl ReferenceVectorUnit {
    /// The unit that `config` describes; see [`ReferenceExponential::new`].
    #[must_use]
    pub fn new(config: &VuConfig) -> Self {
        Self {
            ops: config.ops.clone(),
            exp: ReferenceExponential::new(&config.exp),
            exps: ExpTable::new(config.exp.input).map(Arc::new),
            multiply: config.operand_widths(OpCode::Multiply),
            square_sum: config.operand_widths(OpCode::SquareSum),
        }
    }

    /// The exponential engine.
    #[must_use]
    pub fn exp(&self) -> &ReferenceExponential {
        &self.exp
    }

    /// Signed widths of the operands of an operation, and the field with them.
    const fn widths(&self, op: OpCode) -> ([u32; 2], &'static str) {
        match op {
            OpCode::Multiply => (self.multiply, "vu.operands.multiply"),
            OpCode::SquareSum => (self.square_sum, "vu.operands.square_sum"),
            _ => ([32; 2], ""),
        }
    }

    /// Whether an operand is beyond its width, which raises bit 3 of `stat_errors`. The result is
    /// then that of its low bits.
    #[must_use]
    pub fn is_beyond(&self, op: OpCode, a: i32, b: i32) -> bool {
        let ([of_a, of_b], _) = self.widths(op);
        low_bits(a, of_a) != a || low_bits(b, of_b) != b
    }

    /// Refuses operands of which one raises the flag.
    ///
    /// # Errors
    /// The first operand that is beyond its width.
    pub fn within(&self, op: OpCode, a: &[i32], b: &[i32]) -> Result<(), VectorError> {
        let (widths, field) = self.widths(op);
        for ((values, operand), bits) in [(a, 'a'), (b, 'b')].into_iter().zip(widths) {
            let beyond = |value: &i32| low_bits(*value, bits) != *value;
            if let Some(index) = values.iter().position(beyond) {
                let high = i32::MAX >> (32 - bits);
                return Err(VectorError::Beyond {
                    op,
                    operand,
                    index,
                    value: values[index],
                    bits,
                    low: -high - 1,
                    high,
                    field,
                });
            }
        }
        Ok(())
    }

    /// Computes `op(a, b)` in one lane.
    ///
    /// # Errors
    /// The operation was not built, or its shift is above 63.
    pub fn element(&self, op: VectorOp, a: i32, b: i32) -> Result<i32, VectorError> {
        self.check(op)?;
        Ok(self.compute(op, a, b))
    }

    /// Computes `out[i] = op(a[i], b[i])`.
    ///
    /// # Errors
    /// Those of [`ReferenceVectorUnit::element`], or the slices differ in length. `out` is unchanged then.
    pub fn slice(
        &self,
        op: VectorOp,
        a: &[i32],
        b: &[i32],
        out: &mut [i32],
    ) -> Result<(), VectorError> {
        self.check(op)?;
        if a.len() != out.len() || b.len() != out.len() {
            return Err(VectorError::Lengths {
                op: op.code,
                a: a.len(),
                b: b.len(),
                out: out.len(),
            });
        }
        let fill = |out: &mut [i32], a: &[i32], b: &[i32]| {
            for ((out, &a), &b) in out.iter_mut().zip(a).zip(b) {
                *out = self.compute(op, a, b);
            }
        };
        if out.len() <= CHUNK {
            fill(out, a, b);
        } else {
            out.par_chunks_mut(CHUNK)
                .zip(a.par_chunks(CHUNK))
                .zip(b.par_chunks(CHUNK))
                .for_each(|((out, a), b)| fill(out, a, b));
        }
        Ok(())
    }

    fn check(&self, op: VectorOp) -> Result<(), VectorError> {
        if !self.ops.contains(&op.code) {
            return Err(VectorError::NotBuilt {
                op: op.code,
                built: self.ops.clone(),
            });
        }
        if op.shift > 63 {
            return Err(VectorError::Shift {
                op: op.code,
                shift: op.shift,
            });
        }
        Ok(())
    }

    fn compute(&self, op: VectorOp, a: i32, b: i32) -> i32 {
        let ([of_a, of_b], _) = self.widths(op.code);
        let (x, y) = (low_bits(a, of_a), low_bits(b, of_b));
        let (x, y) = (i64::from(x), i64::from(y));
        let exact = match op.code {
            OpCode::Pass => x.into(),
            OpCode::Relu => x.max(0).into(),
            OpCode::Add => (x + y).into(),
            OpCode::Multiply => (x * y).into(),
            // 2^63 of the least operands has no place in 64 bits.
            OpCode::SquareSum => i128::from(x * x) + i128::from(y * y),
            OpCode::Exp => {
                return match &self.exps {
                    Some(table) => table.of(a, |a| self.exp.exp(a)),
                    None => self.exp.exp(a),
                };
            }
            OpCode::OneMinusExp => return self.exp.one_minus_exp(a),
            OpCode::Sigmoid => return self.exp.sigmoid(a),
            OpCode::Softplus => return self.exp.softplus(a),
        };
        let rounded = round_shift(exact, u32::from(op.shift), op.rounding);
        rounded.clamp(i128::from(i32::MIN), i128::from(i32::MAX)) as i32
    }
}

/// The value of so many low bits, signed.
const fn low_bits(value: i32, bits: u32) -> i32 {
    value << (32 - bits) >> (32 - bits)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use potamoi_formats::config::OperandWidths;
    use potamoi_formats::fixed::Rounding;
    use proptest::prelude::*;

    fn twin() -> ReferenceVectorUnit {
        ReferenceVectorUnit::new(&VuConfig {
            ops: OpCode::ALL.to_vec(),
            ..VuConfig::default()
        })
    }

    fn op(code: OpCode, shift: u8, rounding: Rounding) -> VectorOp {
        VectorOp {
            code,
            shift,
            rounding,
        }
    }

    #[test]
    fn extremes_saturate_in_32_bits_and_not_before() {
        let (min, max) = (i32::MIN, i32::MAX);
        for (code, shift, rounding, a, b, expected) in [
            (OpCode::Add, 0, Rounding::Floor, max, 1, max),
            (OpCode::Add, 0, Rounding::Floor, min, -1, min),
            // A sum that wraps at 32 bits would give 0 here.
            (OpCode::Add, 1, Rounding::Floor, min, min, min),
            (OpCode::Multiply, 31, Rounding::Floor, min, min, max),
            (OpCode::Multiply, 32, Rounding::Floor, min, min, 1 << 30),
            (OpCode::SquareSum, 33, Rounding::HalfUp, min, min, 1 << 30),
            (OpCode::SquareSum, 0, Rounding::Floor, min, min, max),
            (OpCode::Relu, 0, Rounding::Floor, min, 7, 0),
            (OpCode::Pass, 1, Rounding::HalfEven, -3, 7, -2),
            (OpCode::Pass, 1, Rounding::HalfUp, -3, 7, -1),
            (OpCode::Pass, 1, Rounding::Floor, -3, 7, -2),
            (OpCode::Pass, 63, Rounding::Floor, -3, 7, -1),
            (OpCode::Pass, 63, Rounding::HalfUp, -3, 7, 0),
        ] {
            let found = twin().element(op(code, shift, rounding), a, b).unwrap();
            assert_eq!(found, expected, "{code:?} >> {shift} {rounding:?} {a} {b}");
        }
    }

    #[test]
    fn an_operand_beyond_its_width_is_told_and_its_low_bits_count() {
        let unit = ReferenceVectorUnit::new(&VuConfig {
            operands: Some(OperandWidths {
                multiply: [5, 4],
                square_sum: 3,
            }),
            ..VuConfig::default()
        });
        for (code, a, b, beyond, result) in [
            (OpCode::Multiply, 15, 7, false, 105),
            (OpCode::Multiply, -16, -8, false, 128),
            (OpCode::Multiply, 16, 7, true, -112),
            (OpCode::Multiply, -17, 7, true, 105),
            (OpCode::Multiply, 3, 8, true, -24),
            (OpCode::Multiply, 33, 1, true, 1),
            (OpCode::SquareSum, 3, -4, false, 25),
            (OpCode::SquareSum, 4, 0, true, 16),
            (OpCode::SquareSum, 0, -5, true, 9),
            (OpCode::Add, i32::MAX, 0, false, i32::MAX),
        ] {
            let plain = op(code, 0, Rounding::Floor);
            assert_eq!(unit.element(plain, a, b), Ok(result), "{code:?} {a} {b}");
            assert_eq!(unit.is_beyond(code, a, b), beyond, "{code:?} {a} {b}");
            assert_eq!(unit.within(code, &[1, a], &[1, b]).is_err(), beyond);
        }
        let error = unit.within(OpCode::Multiply, &[0, 1, -17], &[0; 3]);
        let told = error.unwrap_err().to_string();
        let wanted = "vector operation multiply with a[2] = -17: expected -16 to 15, 5 signed bits as \
                      vu.operands.multiply gives";
        assert!(told.starts_with(wanted), "{told}");
    }

    #[test]
    fn what_was_not_built_is_named() {
        let config = VuConfig {
            ops: vec![OpCode::Pass, OpCode::Exp],
            ..VuConfig::default()
        };
        let unit = ReferenceVectorUnit::new(&config);
        for code in OpCode::ALL {
            let result = unit.element(VectorOp::new(code), 1, 1);
            assert_eq!(result.is_ok(), config.ops.contains(&code), "{code:?}");
            if let Err(error) = result {
                assert!(
                    error
                        .to_string()
                        .contains(&format!("{} is not built", code.name()))
                );
            }
        }
        let shifted = op(OpCode::Pass, 64, Rounding::Floor);
        assert_eq!(
            unit.element(shifted, 1, 1),
            Err(VectorError::Shift {
                op: OpCode::Pass,
                shift: 64
            })
        );
        let mut out = [9; 2];
        let pass = VectorOp::new(OpCode::Pass);
        assert!(unit.slice(pass, &[1, 2], &[1], &mut out).is_err());
        assert!(unit.slice(pass, &[1], &[1], &mut out).is_err());
        assert_eq!(out, [9; 2]);
    }

    #[test]
    fn long_slices_agree_with_single_elements() {
        let n = 3 * CHUNK + 17;
        let a: Vec<i32> = (0..n as i32)
            .map(|i| i.wrapping_mul(0x9e37_79b1_u32 as i32))
            .collect();
        let b: Vec<i32> = a.iter().rev().copied().collect();
        let unit = twin();
        for code in OpCode::ALL {
            let op = op(code, 20, Rounding::HalfEven);
            let mut out = vec![0; n];
            unit.slice(op, &a, &b, &mut out).unwrap();
            for i in (0..n).step_by(97).chain([n - 1]) {
                assert_eq!(out[i], unit.element(op, a[i], b[i]).unwrap());
            }
        }
    }

    proptest! {
        /// Rounding to nearest never moves a result by more than half a unit
        /// of its last bit from the quotient in floating point.
        #[test]
        fn results_are_the_rounded_quotients(a: i32, b: i32, shift in 0u8..40) {
            for (code, exact) in [
                (OpCode::Add, i128::from(a) + i128::from(b)),
                (OpCode::Multiply, i128::from(a) * i128::from(b)),
                (OpCode::SquareSum, i128::from(a).pow(2) + i128::from(b).pow(2)),
            ] {
                let found = twin().element(op(code, shift, Rounding::HalfEven), a, b).unwrap();
                let unit = 1i128 << shift;
                let within = (i128::from(found) * unit - exact).abs() * 2 <= unit;
                let past_max = found == i32::MAX && exact > i128::from(i32::MAX) * unit;
                let past_min = found == i32::MIN && exact < i128::from(i32::MIN) * unit;
                prop_assert!(within || past_max || past_min);
            }
        }
    }
}
