//! Error bounds of gathered features.

use glam::DVec3;

use super::ErrorInterval;
use crate::Table;
use potamoi_march::tiling::cell;
use potamoi_reference::weights;

/// Appends the errors of a table's features at a position, in fixed point, relative to `features`.
///
/// The weights follow from the position, so their effect is known. Codes are off by up to half a
/// unit, and so is a sum whose weights add up to 1; its result is rounded once more.
pub(crate) fn gathered(
    table: &Table,
    frac_bits: &[u32],
    weight_bits: u32,
    place: DVec3,
    features: &[f64],
    out: &mut [ErrorInterval],
) {
    let unit = |frac: u32| 2f64.powi(-(frac as i32));
    if table.vertices() == 1 {
        // A row by its number: nothing is weighed.
        for (to, frac) in out.iter_mut().zip(frac_bits) {
            *to = ErrorInterval::within(unit(*frac) / 2.0);
        }
        return;
    }
    let (low, fraction) = cell(table.points(), place.to_array());
    let codes: [u16; 8] = match table.vertices() {
        2 => padded(&weights::linear(fraction[0], weight_bits)),
        4 => padded(&weights::bilinear([fraction[0], fraction[1]], weight_bits)),
        _ => weights::trilinear(fraction, weight_bits),
    };
    let channels = table.channels();
    for (to, (feature, frac)) in out.iter_mut().zip(features.iter().zip(frac_bits)) {
        *to = ErrorInterval {
            known: -feature,
            most: unit(*frac),
        };
    }
    let mut corner = 0;
    let middle = DVec3::from(low.map(|v| v as f64 + 0.5));
    table.corners(middle, |row, _| {
        let weight = f64::from(codes[corner]) * unit(weight_bits);
        corner += 1;
        let values = &table.values()[row * channels..][..channels];
        for (to, value) in out.iter_mut().zip(values) {
            to.known += weight * f64::from(*value);
        }
    });
}

fn padded(weights: &[u16]) -> [u16; 8] {
    let mut all = [0; 8];
    all[..weights.len()].copy_from_slice(weights);
    all
}
