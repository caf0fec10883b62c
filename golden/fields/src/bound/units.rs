//! Error bounds of the vector unit's part in opacities and colours.

use potamoi_formats::config::Config;

use super::{ErrorInterval, Outputs};
use crate::opacity::{Curve, Opacity, THICKEST};
use crate::softplus;
use potamoi_reference::bounds::VectorBounds;

/// Operands of softplus and sigmoid saturate at plus and minus this.
const LOGISTIC_HOLDS: f64 = 16.0;

/// Error bounds of a configuration's vector unit, as differences of values.
#[derive(Debug, Clone, Copy)]
pub(crate) struct UnitErrors {
    /// Error of exp and 1 - exp(-s).
    pub(super) power: f64,
    pub(super) softplus: f64,
    pub(super) sigmoid: f64,
    /// Half a code of the operands.
    pub(super) operand: f64,
    /// Half a code of optical depths.
    pub(super) depth: f64,
    /// exp(-u) at the largest operand, at which larger ones saturate.
    least: f64,
    /// Fraction bits of operands.
    operand_bits: i32,
    /// Fraction bits of results.
    pub(super) result_bits: u32,
}

impl UnitErrors {
    pub(crate) fn of(config: &Config, vector: &VectorBounds) -> Self {
        let exp = &config.vu.exp;
        let half = |bits: u32| 2f64.powi(-(bits as i32) - 1);
        let unit = 2f64.powi(-(exp.output_bits as i32));
        let largest = exp.input.max() as f64 * exp.input.ulp();
        Self {
            // The largest code stands for 1, too.
            power: (vector.exp.max(vector.one_minus_exp) + 1.0) * unit,
            softplus: vector.softplus * unit,
            sigmoid: (vector.sigmoid + 1.0) * unit,
            operand: half(exp.input.frac_bits()),
            depth: half(exp.one_minus_frac_bits),
            least: (-largest).exp(),
            operand_bits: exp.input.frac_bits() as i32,
            result_bits: exp.output_bits,
        }
    }

    /// The difference of a code as an operand, which may be rounded to fewer bits.
    fn as_operand(&self, off: ErrorInterval, frac_bits: i32) -> ErrorInterval {
        match frac_bits > self.operand_bits {
            true => off.rounded(self.operand),
            false => off,
        }
    }

    /// Upper bound of the error of the logistic function, for codes of `frac_bits` fraction bits.
    pub(crate) fn logistic(&self, logit: f64, off: ErrorInterval, frac_bits: i32) -> f64 {
        let off = self.as_operand(off, frac_bits);
        let logistic = |x: f64| 1.0 / (1.0 + (-x).exp());
        let (own, middle) = (logistic(logit), logit + off.known);
        let ends = [middle - off.most, middle + off.most].map(|x| (logistic(x) - own).abs());
        ends[0].max(ends[1]) + self.sigmoid + (-LOGISTIC_HOLDS).exp()
    }

    /// Upper bound of the error of colours, the largest of a channel, from logits of `frac_bits`
    /// fraction bits.
    pub(crate) fn colours(&self, logits: &Outputs, frac_bits: i32) -> f64 {
        let each = logits.values.iter().zip(&logits.off);
        let each = each.map(|(logit, off)| self.logistic(*logit, *off, frac_bits));
        each.fold(0.0, f64::max)
    }
}

impl Opacity {
    /// Upper bound of an opacity's error, from the difference of a number with `frac_bits`
    /// fraction bits.
    pub(crate) fn off(
        &self,
        errors: &UnitErrors,
        number: f64,
        off: ErrorInterval,
        frac_bits: i32,
    ) -> f64 {
        let [low, high] = match self.curve {
            Curve::Softplus { shift } => {
                // The shift is rounded, too.
                let off = errors.as_operand(off, frac_bits).rounded(errors.operand);
                let middle = number + shift + off.known;
                let ends = [middle - off.most, middle + off.most].map(softplus);
                let unit = errors.softplus + (-LOGISTIC_HOLDS).exp();
                self.depths([ends[0] - unit, ends[1] + unit], errors)
            }
            Curve::Relu => {
                let middle = number + off.known;
                self.depths([middle - off.most, middle + off.most], errors)
            }
            Curve::Exp => self.exponential_depths(errors, number, off),
        };
        let own = (-self.depth(number)).exp();
        let through = [low, high].map(|depth| (-depth.max(0.0)).exp());
        // Thicker ones are held there.
        let held = match high > THICKEST {
            true => (-THICKEST).exp(),
            false => 0.0,
        };
        (through[0] - own).max(own - through[1]).max(0.0) + held + errors.power
    }

    /// The optical depth for a number.
    fn depth(&self, number: f64) -> f64 {
        self.interval
            * match self.curve {
                Curve::Softplus { shift } => softplus(number + shift),
                Curve::Relu => number.max(0.0),
                Curve::Exp => number.exp(),
            }
    }

    /// The range of optical depths for a range of densities, multiplied by the interval's code.
    fn depths(&self, [low, high]: [f64; 2], errors: &UnitErrors) -> [f64; 2] {
        let high = high.max(0.0);
        let off = high * self.interval_off() + errors.depth;
        [
            self.interval * low.max(0.0) - off,
            self.interval * high + off,
        ]
    }

    /// The range of 16 exp(-u)^2, where u is half of ln 16 less the number and the interval's
    /// logarithm.
    fn exponential_depths(&self, errors: &UnitErrors, number: f64, off: ErrorInterval) -> [f64; 2] {
        let u = (THICKEST.ln() - self.interval.ln() - number - off.known) / 2.0;
        // Half of the number is rounded, and so is what it is taken from.
        let most = off.most / 2.0 + 2.0 * errors.operand;
        let root = |u: f64| (-u.max(0.0)).exp();
        let thin = (root(u + most) - errors.power).max(0.0);
        let thick = root(u - most).max(errors.least) + errors.power;
        [
            THICKEST * thin * thin - errors.depth,
            THICKEST * thick * thick + errors.depth,
        ]
    }
}
