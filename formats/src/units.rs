//! Names of the hardware units, the vector unit's operations and their codes.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::fixed::Rounding;

/// Top module of the gathering unit.
pub const GATHERING_UNIT: &str = "gathering_unit";
/// Top module of the vector unit.
pub const VECTOR_UNIT: &str = "vector_unit";
/// Top module of the splat unit.
pub const SPLAT_UNIT: &str = "splat_unit";
/// Top module that joins both units with registers.
pub const NPU_EXT: &str = "potamoi_npu_ext";
/// A multiply-accumulate unit of the array around them.
pub const ARRAY_MAC: &str = "array_mac";

/// Operation of a lane on its two signed 32-bit operands `a` and `b`.
///
/// All operations but the exponentials compute an exact integer, shift it right by the operation's
/// `shift` with its rounding, and saturate to a signed 32-bit result.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize, JsonSchema,
)]
#[serde(rename_all = "kebab-case")]
pub enum OpCode {
    /// `a`.
    Pass,
    /// `max(a, 0)`.
    Relu,
    /// `a + b`.
    Add,
    /// `a * b`.
    Multiply,
    /// `a^2 + b^2`: with a shift, the exponent of a splat from the two affine forms of its Cholesky
    /// factors.
    SquareSum,
    /// `exp(-a)` in the alpha configuration, `a` clamped to the input format;
    /// `exp(a)` as exponent and mantissa in the general one. Ignores `b`, shift
    /// and rounding.
    Exp,
    /// `1 - exp(-a)`, `a` with `one_minus_frac_bits` fraction bits and clamped
    /// to 0..16; exactly 0 at 0. Ignores `b`, shift and rounding.
    OneMinusExp,
    /// `1 / (1 + exp(-a))`, a signed 32-bit `a` with the fraction bits of the
    /// exponential's input. Ignores `b`, shift and rounding.
    Sigmoid,
    /// `ln(1 + exp(a))`, `a` as for sigmoid; the result has the
    /// exponential's `output_bits` fraction bits and is held within signed 32
    /// bits. Ignores `b`, shift and rounding.
    Softplus,
}

impl OpCode {
    /// All operations by code.
    pub const ALL: [Self; 9] = [
        Self::Pass,
        Self::Relu,
        Self::Add,
        Self::Multiply,
        Self::SquareSum,
        Self::Exp,
        Self::OneMinusExp,
        Self::Sigmoid,
        Self::Softplus,
    ];

    /// The code on the operation port, 4 bits.
    #[must_use]
    pub const fn code(self) -> u8 {
        self as u8
    }

    /// The name in a configuration.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Pass => "pass",
            Self::Relu => "relu",
            Self::Add => "add",
            Self::Multiply => "multiply",
            Self::SquareSum => "square-sum",
            Self::Exp => "exp",
            Self::OneMinusExp => "one-minus-exp",
            Self::Sigmoid => "sigmoid",
            Self::Softplus => "softplus",
        }
    }

    /// Names of several operations, as a configuration lists them.
    #[must_use]
    pub fn list(ops: &[Self]) -> String {
        let names: Vec<_> = ops.iter().map(|op| format!("\"{}\"", op.name())).collect();
        format!("[{}]", names.join(", "))
    }

    /// Whether it uses both operands.
    #[must_use]
    pub const fn takes_both(self) -> bool {
        matches!(self, Self::Add | Self::Multiply | Self::SquareSum)
    }

    /// Whether the exponential engine computes it.
    #[must_use]
    pub const fn is_exponential(self) -> bool {
        matches!(self, Self::Exp | Self::OneMinusExp) || self.is_logistic()
    }

    /// Whether it takes several passes through the engine: sigmoid and softplus.
    #[must_use]
    pub const fn is_logistic(self) -> bool {
        matches!(self, Self::Sigmoid | Self::Softplus)
    }
}

/// One operation, the same for all lanes of a vector.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
pub struct VectorOp {
    /// The operation.
    pub code: OpCode,
    /// Bits dropped from the exact result, 0 to 63.
    pub shift: u8,
    /// Rounding of the dropped bits.
    pub rounding: Rounding,
}

impl VectorOp {
    /// An operation that drops no bits.
    #[must_use]
    pub const fn new(code: OpCode) -> Self {
        Self {
            code,
            shift: 0,
            rounding: Rounding::Floor,
        }
    }

    /// The operation field of `s_axis_vec_tuser`.
    #[must_use]
    pub const fn field(self) -> u16 {
        let rounding = match self.rounding {
            Rounding::Floor => 0,
            Rounding::HalfUp => 1,
            Rounding::HalfEven => 2,
        };
        self.code.code() as u16 | ((self.shift & 63) as u16) << 4 | rounding << 10
    }
}
