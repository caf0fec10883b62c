//! The machine's peak: additions and multiplications of 64 bits.

use std::hint::black_box;

use fearless_simd::dispatch;
use fearless_simd::prelude::*;
use potamoi_base::vectors::Vectors;

use crate::sizes::Sizes;
use crate::time::Meter;

/// Independent values in the loop: enough to hide latencies, few enough for the registers of the
/// smallest machine.
const CHAINS: usize = 12;

/// Additions and multiplications a second of processor time of one thread with these vectors, if they
/// come in equal numbers, from registers, without dependencies, and none of them fused. `None` where the
/// processor does not have the vectors.
pub(crate) fn peak(vectors: Vectors, sizes: &Sizes, meter: &mut Meter) -> Option<f64> {
    let level = vectors.level()?;
    let lanes = dispatch!(level, simd => lanes(simd)) as u64;
    let mut run = || {
        dispatch!(level, simd => chains(simd, sizes.peak_rounds));
        Ok::<_, std::convert::Infallible>(())
    };
    let Ok((ms, ())) = meter.fastest(sizes.peak_runs, 1, &mut run);
    let rounds = sizes.peak_rounds / CHAINS as u64 * CHAINS as u64;
    Some(2.0 * (rounds * lanes) as f64 / (1e-3 * ms))
}

#[inline(always)]
fn lanes<S: Simd>(_: S) -> usize {
    S::f64s::LEN
}

#[inline(always)]
fn chains<S: Simd>(simd: S, rounds: u64) {
    let splat = |value: f64| S::f64s::splat(simd, black_box(value));
    let mut values: [S::f64s; CHAINS] = std::array::from_fn(|i| splat(i as f64));
    let (factor, term) = (splat(0.999), splat(0.001));
    for _ in 0..rounds / CHAINS as u64 {
        for value in &mut values {
            *value = *value * factor + term;
        }
    }
    black_box(values.map(|value| value.to_array()));
}
