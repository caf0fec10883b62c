//! Error bounds of TensoRF in fixed point.

use glam::DVec3;
use potamoi_formats::config::Config;

use super::Tensorf;
use super::fixed::{TensorfHead, head};
use crate::FieldError;
use crate::bound::{Bounds, ErrorInterval, Outputs, Pair, UnitErrors};
use potamoi_march::Head as _;
use potamoi_reference::bounds::VectorBounds;

pub(super) struct TensorfBounds<'a> {
    field: &'a Tensorf,
    head: TensorfHead,
    frac_bits: Vec<Vec<u32>>,
    basis: Pair,
    mlp: Pair,
    errors: UnitErrors,
}

pub(super) fn bounds<'a>(
    field: &'a Tensorf,
    config: &Config,
    vector: &VectorBounds,
) -> Result<TensorfBounds<'a>, FieldError> {
    let (frac_bits, head) = head(field, config)?;
    Ok(TensorfBounds {
        field,
        basis: Pair::new(&field.basis, &head.basis),
        mlp: Pair::new(&field.mlp, &head.mlp),
        errors: UnitErrors::of(config, vector),
        frac_bits,
        head,
    })
}

impl TensorfBounds<'_> {
    /// Products of planes and lines, of density (kind 0) or of appearance.
    fn products(&self, features: &[f64], off: &[ErrorInterval], kind: usize) -> Outputs {
        let mut all = Outputs::default();
        for mode in &self.head.modes {
            let own = match kind {
                0 => 0..mode.density,
                _ => mode.density..mode.channels,
            };
            // A product that keeps all of its bits is exact.
            let rounding = match mode.frac_bits[kind] > self.head.product_bits[kind] {
                true => 2f64.powi(-1 - self.head.product_bits[kind] as i32),
                false => 0.0,
            };
            for i in own {
                let at = [mode.plane + i, mode.line + i];
                let values = at.map(|at| features[at]);
                let product = ErrorInterval::product(values, at.map(|at| off[at]));
                all.values.push(values[0] * values[1]);
                all.off.push(product.rounded(rounding));
            }
        }
        all
    }

    /// Appends sines or cosines of values, as the perceptron's inputs.
    fn waves(from: &Outputs, count: usize, frequencies: usize, half: f64, to: &mut Outputs) {
        for wave in [f64::sin, f64::cos] {
            for (value, off) in from.values.iter().zip(&from.off).take(count) {
                for k in 0..frequencies {
                    let times = 2f64.powi(k as i32);
                    let exact = wave(times * value);
                    to.values.push(exact);
                    to.off.push(ErrorInterval {
                        known: wave(times * (value + off.known)) - exact,
                        most: (times * off.most).min(2.0) + half,
                    });
                }
            }
        }
    }
}

impl Bounds for TensorfBounds<'_> {
    fn frac_bits(&self) -> &[Vec<u32>] {
        &self.frac_bits
    }

    fn alpha(&self, features: &[f64], off: &[ErrorInterval]) -> f64 {
        let products = self.products(features, off, 0);
        let sum = products.values.iter().sum();
        let off = products
            .off
            .iter()
            .fold(ErrorInterval::default(), |sum, off| sum + *off);
        let bits = self.head.product_bits[0] as i32;
        self.head.opacity.off(&self.errors, sum, off, bits)
    }

    fn colour(&self, features: &[f64], off: &[ErrorInterval], direction: DVec3) -> f64 {
        let products = self.products(features, off, 1);
        let made = self.basis.outputs(&products.values, &products.off);
        let scale = 2f64.powi(self.head.basis.output_frac());
        let mut codes = vec![];
        self.head.encode(direction, &mut codes);
        let rules = &self.field.rules;
        let count = made.values.len();
        let mut inputs = Outputs {
            values: made.values.clone(),
            off: made.off.clone(),
        };
        // Of a direction all codes are known.
        let mut towards = direction.to_array().to_vec();
        super::encode(0..3, rules.view_frequencies, &mut towards);
        let mut known = towards.iter().zip(&codes).map(|(exact, code)| {
            (
                *exact,
                ErrorInterval::exactly(f64::from(*code) / scale - exact),
            )
        });
        for (exact, off) in known.by_ref().take(3) {
            inputs.values.push(exact);
            inputs.off.push(off);
        }
        Self::waves(
            &made,
            count,
            rules.feature_frequencies,
            0.5 / scale,
            &mut inputs,
        );
        for (exact, off) in known {
            inputs.values.push(exact);
            inputs.off.push(off);
        }
        let logits = self.mlp.outputs(&inputs.values, &inputs.off);
        self.errors.colours(&logits, self.head.mlp.output_frac())
    }
}
