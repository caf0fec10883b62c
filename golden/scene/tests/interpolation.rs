//! The benefit of weights that sum to exactly 1: PSNR against trilinear interpolation in double
//! precision.
//!
//! The field is in [0, 1], stored in unsigned codes of the stated bits: of mean
//! 0.5 and standard deviation 0.12, and nearly linear within a cell, as fields
//! that are sampled densely enough are. Weights rounded one by one lose by the
//! field's magnitude, split weights by its differences within a cell.

use potamoi_formats::config::Config;
use potamoi_formats::fixed::{Rounding, round_shift};
use potamoi_formats::rit::{RitEntry, Vertices};
use potamoi_reference::GatherTask;
use potamoi_reference::gathering_unit::ReferenceGatheringUnit;
use potamoi_reference::weights::trilinear;
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64Mcg;

const SAMPLES: usize = 60_000;
/// Largest difference of the field along an edge of a cell.
const SLOPE: f64 = 0.0243;

struct Sample {
    fraction: [u16; 3],
    field: [f64; 8],
}

impl Sample {
    fn draw(random: &mut Pcg64Mcg) -> Self {
        let mut spread = |half: f64| random.random_range(-half..half);
        let base = 0.5 + spread(0.12 * 3f64.sqrt());
        let slopes = [spread(SLOPE), spread(SLOPE), spread(SLOPE)];
        let at = |c: usize| {
            let steps = (0..3).map(|axis| slopes[axis] * ((c >> axis & 1) as f64 - 0.5));
            base + steps.sum::<f64>()
        };
        let field = std::array::from_fn(at);
        let fraction = [(); 3].map(|()| random.random_range(0..=4096));
        Self { fraction, field }
    }

    /// Weights as real numbers.
    fn exact(&self) -> [f64; 8] {
        let u = self.fraction.map(|f| f64::from(f) / 4096.0);
        std::array::from_fn(|c| {
            (0..3)
                .map(|axis| {
                    if c >> axis & 1 == 1 {
                        u[axis]
                    } else {
                        1.0 - u[axis]
                    }
                })
                .product()
        })
    }

    fn rounded(&self, weight_bits: u32, round: fn(f64) -> f64) -> [u16; 8] {
        self.exact()
            .map(|w| round(w * 2f64.powi(weight_bits as i32)) as u16)
    }
}

fn samples(seed: u64) -> Vec<Sample> {
    let mut random = Pcg64Mcg::seed_from_u64(seed);
    (0..SAMPLES).map(|_| Sample::draw(&mut random)).collect()
}

/// The gathering unit's sum on unsigned codes.
fn interpolate(codes: &[i64; 8], weights: &[u16; 8], weight_bits: u32, bits: u32) -> i64 {
    let sum: i64 = codes
        .iter()
        .zip(weights)
        .map(|(c, w)| c * i64::from(*w))
        .sum();
    let rounded = round_shift(i128::from(sum), weight_bits, Rounding::HalfEven) as i64;
    rounded.clamp(0, (1 << bits) - 1)
}

/// PSNR with split and with independently rounded weights, in dB.
fn psnr(samples: &[Sample], bits: u32, weight_bits: u32) -> [f64; 2] {
    let peak = ((1i64 << bits) - 1) as f64;
    let mut squares = [0.0f64; 2];
    for sample in samples {
        let codes = sample.field.map(|f| (f * peak).round() as i64);
        let exact: f64 = sample
            .exact()
            .iter()
            .zip(&sample.field)
            .map(|(w, f)| w * f)
            .sum();
        let both = [
            trilinear(sample.fraction, weight_bits),
            sample.rounded(weight_bits, f64::round),
        ];
        for (square, weights) in squares.iter_mut().zip(&both) {
            let found = interpolate(&codes, weights, weight_bits, bits);
            *square += (found as f64 / peak - exact).powi(2);
        }
    }
    squares.map(|square| -10.0 * (square / samples.len() as f64).log10())
}

/// Figures measured on another field with other code; the slope of the field
/// here is set by one of them (16 bits, W = 8), the rest follows. W = 15 stands
/// for 16, which U1.15 words do not hold: rounded weights lose 6 dB by it where
/// they set the error.
#[test]
fn split_weights_are_worth_thirty_decibels() {
    let samples = samples(1);
    let table = [
        (
            8,
            [56.6, 57.7, 57.8, 57.8, 57.8],
            [31.6, 43.5, 53.6, 57.7, 57.8],
        ),
        (
            12,
            [63.0, 74.9, 81.0, 81.9, 81.9],
            [31.6, 43.7, 55.7, 77.7, 81.9],
        ),
        (
            16,
            [63.1, 75.9, 88.0, 105.1, 106.0],
            [31.6, 43.7, 55.7, 79.8, 96.5],
        ),
    ];
    for (bits, split, rounded) in table {
        for (i, weight_bits) in [4, 6, 8, 12, 15].into_iter().enumerate() {
            let found = psnr(&samples, bits, weight_bits);
            println!(
                "{bits}-bit features, W = {weight_bits}: split {:.1} dB (known {}), rounded {:.1} dB (known {})",
                found[0], split[i], found[1], rounded[i]
            );
            assert!(
                (found[0] - split[i]).abs() < 1.0,
                "{bits} {weight_bits}: {found:?}"
            );
            assert!(
                (found[1] - rounded[i]).abs() < 1.0,
                "{bits} {weight_bits}: {found:?}"
            );
        }
    }
}

/// The table's sums are the gathering unit's: features are signed there, and
/// weights that sum to 1 make the difference an exact offset.
#[test]
fn the_unit_gives_the_same_sums() {
    let samples = samples(2);
    for (bits, weight_bits) in [(8, 4), (12, 8), (16, 8), (16, 15)] {
        let text = format!("[gu]\nfeature_bits = {bits}\nweight_bits = {weight_bits}");
        let twin = ReferenceGatheringUnit::new(&Config::from_toml(&text, "test").unwrap());
        let (peak, offset) = (((1i64 << bits) - 1) as f64, 1i64 << (bits - 1));
        for sample in samples.iter().take(2000) {
            let codes = sample.field.map(|f| (f * peak).round() as i64);
            let weights = trilinear(sample.fraction, weight_bits);
            let task = GatherTask {
                vertices: Vertices::Eight,
                channels: 1,
                rows: codes.iter().map(|c| (c - offset) as i16).collect(),
                entries: vec![RitEntry {
                    slot: 0,
                    rows: [0, 1, 2, 3, 4, 5, 6, 7],
                    weights,
                }],
            };
            let mut found = vec![];
            assert_eq!(twin.gather(&task, &mut found), Ok(0));
            let expected = interpolate(&codes, &weights, weight_bits, bits);
            assert_eq!(i64::from(found[0]) + offset, expected);
        }
    }
}

/// A constant field comes back from split weights, and from hardly any others.
#[test]
fn only_exact_sums_keep_a_constant_field() {
    let samples = samples(3);
    let field = [32_767i64; 8];
    let off = |weights: &[u16; 8]| (interpolate(&field, weights, 8, 16) - 32_767).abs();
    let wrong = |round: fn(f64) -> f64| {
        let offs = samples.iter().map(|s| off(&s.rounded(8, round)));
        let (count, most) = offs.fold((0, 0), |(n, m), off| (n + u32::from(off > 0), m.max(off)));
        (f64::from(count) / SAMPLES as f64, most)
    };
    let (cut, rounded) = (wrong(f64::floor), wrong(f64::round));
    println!("cut off: {cut:?} wrong, at most; rounded: {rounded:?}");
    assert!(samples.iter().all(|s| off(&trilinear(s.fraction, 8)) == 0));
    assert!(cut.0 > 0.99, "{cut:?}");
    // Off by three units of 2^-8 at most: 384 codes.
    assert!(
        (0.45..0.60).contains(&rounded.0) && rounded.1 == 384,
        "{rounded:?}"
    );
}

/// Rounding half to even leaves no bias, rounding down half a code.
#[test]
fn half_even_has_no_bias() {
    let (mut sums, mut count) = ([0.0f64; 3], 0.0);
    for sample in samples(4) {
        // Few weight bits make ties frequent.
        let weights = trilinear(sample.fraction, 4);
        let codes = sample.field.map(|f| (f * 255.0).round() as i128);
        let sum: i128 = codes
            .iter()
            .zip(&weights)
            .map(|(c, w)| c * i128::from(*w))
            .sum();
        for (bias, rounding) in
            sums.iter_mut()
                .zip([Rounding::Floor, Rounding::HalfUp, Rounding::HalfEven])
        {
            *bias += round_shift(sum, 4, rounding) as f64 - sum as f64 / 16.0;
        }
        count += 1.0;
    }
    let [floor, up, even] = sums.map(|sum| sum / count);
    println!("bias in codes: down {floor:.4}, half up {up:.4}, half to even {even:.4}");
    assert!(floor < -0.4 && up > 0.01, "{floor} {up}");
    // Five standard errors of a mean of values within half a code.
    assert!(even.abs() < 5.0 * 0.3 / count.sqrt(), "{even}");
}
