//! Calibration samples, which determine the range of a perceptron's sums.

use std::fmt;
use std::sync::OnceLock;

use glam::DVec3;

use super::Field;
use super::table::gather_all;

/// A sample of at least this opacity is visible.
pub(super) const SEEN_FROM: f64 = 1e-4;
/// Number of visible samples.
const SEEN: u32 = 8192;
/// Maximum number of attempts a sample: most of a box may be empty.
const TRIES: u32 = 64;
/// Samples that are gathered together.
const BATCH: usize = 64;

/// Largest magnitudes on the calibration set, computed when first asked for. They follow from the
/// rest of a model: any two compare equal, and a copy, which may get another step, computes its own.
#[derive(Default)]
pub(super) struct Magnitudes(OnceLock<[Vec<f64>; 2]>);

impl Magnitudes {
    /// The known magnitudes, or those that `find` computes.
    pub(super) fn or_find(&self, find: impl FnOnce() -> [Vec<f64>; 2]) -> [&[f64]; 2] {
        self.0.get_or_init(find).each_ref().map(Vec::as_slice)
    }
}

impl Clone for Magnitudes {
    fn clone(&self) -> Self {
        Self::default()
    }
}

impl PartialEq for Magnitudes {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

impl fmt::Debug for Magnitudes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Magnitudes")
    }
}

fn fraction(n: u32, step: f64) -> f64 {
    (f64::from(n) * step).fract()
}

/// Direction `n` of a spiral that covers the sphere evenly.
pub(super) fn direction(n: u32) -> DVec3 {
    let height = 2.0 * fraction(n, 0.618_033_988_749_894_8) - 1.0;
    let (sin, cos) = (2.399_963_229_728_653 * f64::from(n)).sin_cos();
    let wide = (1.0 - height * height).sqrt();
    DVec3::new(wide * cos, wide * sin, height)
}

/// Gathers at fixed positions, spread evenly over a field's box, where the field is not known to
/// be empty, until enough samples are visible. Calls `tell` with the features, the opacity of a
/// step, and a direction; directions are spread evenly over the sphere.
pub(super) fn visit(field: &dyn Field, mut tell: impl FnMut(&[f64], f64, DVec3)) {
    let sampling = field.sampling();
    let [low, high] = sampling.bounds;
    let (tables, channels) = (field.tables().len(), field.channels().max(1));
    let (mut numbers, mut places) = (vec![], vec![]);
    let (mut features, mut depths, mut kept) = (vec![], vec![], vec![]);
    let (mut next, mut seen) = (1..SEEN * TRIES, 0);
    while seen < SEEN {
        numbers.clear();
        places.clear();
        while numbers.len() < BATCH
            && let Some(n) = next.next()
        {
            let from = places.len();
            places.resize(from + tables, DVec3::ZERO);
            match field.index(low + (high - low) * spread(n), &mut places[from..]) {
                true => numbers.push(n),
                false => places.truncate(from),
            }
        }
        if numbers.is_empty() {
            break;
        }
        features.clear();
        features.resize(numbers.len() * channels, 0.0);
        gather_all(field.tables(), &places, &mut features);
        field.depths(&features, &mut depths, &mut kept);
        let samples = numbers.iter().zip(features.chunks_exact(channels));
        for ((n, features), depth) in samples.zip(&depths) {
            let alpha = -(-depth).exp_m1();
            tell(features, alpha, direction(*n));
            if alpha > sampling.least_opacity.max(SEEN_FROM) {
                seen += 1;
                if seen == SEEN {
                    break;
                }
            }
        }
    }
}

/// Position `n` of a sequence of low discrepancy in the unit cube (Roberts 2018): multiples of powers
/// of the root of `x^4 = x + 1`.
fn spread(n: u32) -> DVec3 {
    DVec3::new(
        fraction(n, 0.819_172_513_396_164_4),
        fraction(n, 0.671_043_606_703_789_2),
        fraction(n, 0.549_700_477_901_970_2),
    )
}
