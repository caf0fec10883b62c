//! Error bounds of Compact-3DGS colours in fixed point.

use glam::DVec3;
use potamoi_formats::config::Config;
use rayon::prelude::*;

use super::fixed::with_first_columns;
use super::{FEATURES, FixedColour, HashedColour, LEVELS, ONES, harmonics};
use crate::FieldError;
use crate::bound::{ErrorInterval, Outputs, Pair, gathered};
use crate::quantisation::held;

impl HashedColour {
    /// Upper bound of the error of a channel's coefficient of the constant harmonic, for Gaussians
    /// at `centres` seen from `eye`. Every rounding of gathered and computed values is taken at
    /// its worst.
    ///
    /// # Errors
    /// Those of [`FixedColour::new`].
    pub fn off(&self, centres: &[DVec3], eye: DVec3, config: &Config) -> Result<f64, FieldError> {
        let codes = FixedColour::new(self, centres, config)?;
        let down = codes.feature_bits as i32 - codes.harmonic_bits;
        let pair = Pair::new(&with_first_columns(&self.head, down)?, &codes.head);
        let inputs = |at: &DVec3| {
            let mut inputs = self.inputs_off(*at, codes.feature_bits, config.gu.weight_bits);
            let scale = [codes.feature_bits as i32, codes.harmonic_bits].map(|b| 2f64.powi(b));
            let direction = harmonics((*at - eye).normalize_or_zero());
            for exact in direction.into_iter().chain([1.0; ONES]) {
                let own = exact * 2f64.powi(-down);
                let code = held(exact * scale[1]);
                inputs.values.push(own);
                inputs
                    .off
                    .push(ErrorInterval::exactly(f64::from(code) / scale[0] - own));
            }
            inputs
        };
        let of_one = |at: &DVec3| {
            let inputs = inputs(at);
            let made = pair.outputs(&inputs.values, &inputs.off);
            let each = made.values.iter().zip(&made.off);
            // Both are kept in 24 bits.
            each.fold(0.0, |most: f64, (value, off)| {
                most.max(off.largest() + value.abs() * 2f64.powi(-23))
            })
        };
        Ok(centres.par_iter().map(of_one).reduce(|| 0.0, f64::max))
    }

    /// The features at a point, with their errors.
    fn inputs_off(&self, at: DVec3, feature_bits: u32, weight_bits: u32) -> Outputs {
        let mut places = [DVec3::ZERO; LEVELS as usize];
        self.index(at, &mut places);
        let mut all = Outputs::default();
        for (table, place) in self.tables.iter().zip(places) {
            let mut own = [0.0; FEATURES as usize];
            let mut off = [ErrorInterval::default(); FEATURES as usize];
            table.gather(place, &mut own);
            let bits = [feature_bits; FEATURES as usize];
            gathered(table, &bits, weight_bits, place, &own, &mut off);
            all.values.extend(own);
            all.off.extend(off);
        }
        all
    }
}
