//! Configuration of the vector unit.

use serde::{Deserialize, Serialize};

use super::{ExpBase, ExpConfig, ExpForm};
use crate::timing::{Passes, Pipeline, PowerRegister};
use crate::units::OpCode;

/// The vector unit.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct VuConfig {
    /// Number of lanes. The paper states none; 24, one for each MAC column, is a named assumption.
    pub lanes: u32,
    /// Operations built; by default those that the paper's algorithms need.
    pub ops: Vec<OpCode>,
    /// Capacity of the output FIFO in results.
    pub fifo_depth: u32,
    /// Whether operations have register stages between: a faster clock, results some cycles later.
    ///
    /// [`VuConfig::lag`] counts them.
    #[serde(skip_serializing_if = "is_false")]
    pub registered: bool,
    /// Widths of the operands of multiplications; left out: all 32 bits.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub operands: Option<OperandWidths>,
    /// The samples of fields and stored voxels whose exponential is computed. No hardware depends on it.
    #[serde(skip_serializing_if = "is_default")]
    pub samples: VuSamples,
    /// The exponential engine.
    pub exp: ExpConfig,
}

/// Which samples are sent through the exponential of the vector unit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum VuSamples {
    /// All.
    #[default]
    All,
    /// Those whose opacity is not 0, judged by their optical depth. No code of a picture depends on the
    /// others.
    ThatMayCount,
}

/// Signed widths of the operands of multiplications, in bits. An operand beyond its width raises a
/// flag, and its low bits are multiplied.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct OperandWidths {
    /// Of `a` and `b` of multiply.
    pub multiply: [u32; 2],
    /// Of `a` and `b` of square-sum.
    pub square_sum: u32,
}

/// Bits of an operand.
const WORD: u32 = 32;

impl Default for OperandWidths {
    fn default() -> Self {
        Self {
            multiply: [WORD; 2],
            square_sum: WORD,
        }
    }
}

fn is_default<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}

// Serde passes a reference.
#[allow(clippy::trivially_copy_pass_by_ref)]
const fn is_false(value: &bool) -> bool {
    !*value
}

impl VuConfig {
    /// Signed widths of `a` and `b` that an operation takes, in bits.
    #[must_use]
    pub fn operand_widths(&self, op: OpCode) -> [u32; 2] {
        match (&self.operands, op) {
            (Some(own), OpCode::Multiply) => own.multiply,
            (Some(own), OpCode::SquareSum) => [own.square_sum; 2],
            _ => [WORD; 2],
        }
    }

    /// Whether an operand of a built operation can be beyond its width.
    #[must_use]
    pub fn has_narrow_operands(&self) -> bool {
        let narrow = |op: &OpCode| self.operand_widths(*op) != [WORD; 2];
        self.ops.iter().any(narrow)
    }

    /// Register stages of a power beside those of [`ExpConfig::power_pipeline`].
    #[must_use]
    pub fn power_registers(&self) -> Pipeline<PowerRegister> {
        let pieces = self.exp.form == ExpForm::Piecewise;
        Pipeline::power_registers(self.registered, pieces, self.exp.base == ExpBase::Two)
    }

    /// Passes of an operation through the iterative engine.
    #[must_use]
    pub fn passes(&self, op: OpCode) -> Passes {
        Passes::of(op, &self.exp.power_pipeline(), &self.power_registers())
    }

    /// Cycles by which these stages delay the result of every operation.
    #[must_use]
    pub fn lag(&self) -> u32 {
        let element_wise = |registered| Pipeline::element_wise(registered).cycles();
        match self.ops.iter().any(|op| op.is_exponential()) {
            true => self.power_registers().cycles(),
            false => element_wise(self.registered) - element_wise(false),
        }
    }
}

impl Default for VuConfig {
    fn default() -> Self {
        Self {
            lanes: 24,
            ops: vec![
                OpCode::Pass,
                OpCode::Relu,
                OpCode::Add,
                OpCode::Multiply,
                OpCode::SquareSum,
                OpCode::Exp,
                OpCode::OneMinusExp,
            ],
            fifo_depth: 3,
            registered: false,
            operands: None,
            samples: VuSamples::All,
            exp: ExpConfig::default(),
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::config::Config;

    /// The numbers of `docs/reference/vector-unit.md`.
    #[test]
    fn the_lag_is_as_documented() {
        let lag = |text: &str| {
            let config = Config::from_toml(text, "test").unwrap();
            config.vu.lag()
        };
        assert_eq!(lag(""), 0);
        assert_eq!(lag("[vu]\nregistered = true"), 2);
        assert_eq!(lag("[vu]\nregistered = true\nops = [\"add\"]"), 2);
        assert_eq!(
            lag("[vu]\nregistered = true\n[vu.exp]\npipelined = true"),
            2
        );
        let pieces = "[vu]\nregistered = true\n[vu.exp]\nform = \"piecewise\"\npipelined = true";
        assert_eq!(lag(pieces), 4);
        assert_eq!(lag(&format!("{pieces}\nbase = \"two\"")), 3);
    }

    #[test]
    fn widths_are_of_built_operations() {
        let vu = |text: &str| Config::from_toml(text, "test").unwrap().vu;
        let narrow = vu("[vu.operands]\nmultiply = [22, 18]\nsquare_sum = 19");
        assert!(narrow.has_narrow_operands());
        assert_eq!(narrow.operand_widths(OpCode::Multiply), [22, 18]);
        assert_eq!(narrow.operand_widths(OpCode::SquareSum), [19, 19]);
        assert_eq!(narrow.operand_widths(OpCode::Add), [32, 32]);
        assert!(!vu("").has_narrow_operands());
        assert!(!vu("[vu.operands]\nsquare_sum = 32").has_narrow_operands());
    }
}
