//! Sums of a layer of a perceptron for a batch of samples.
//!
//! A sum starts at its bias, and the products are added input after input. Vectors hold several
//! outputs of one sample, so that they change neither a product nor the order of additions: the
//! result is the same with vectors of any width, and in a batch of any size. Inputs of 0, half of
//! those behind a ReLU, are left out.

use fearless_simd::prelude::*;
use fearless_simd::{Level, dispatch, f64x8};

/// Outputs in a block of weights. The weights of a block of 128 inputs fit a first-level cache.
const BLOCK: usize = 32;

/// Weights of some outputs from one input.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(align(64))]
struct Row([f64; BLOCK]);

/// Weights and biases of a layer, output block after output block.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Weights {
    inputs: usize,
    outputs: usize,
    /// A row for each input of each block; 0 where a block exceeds the outputs.
    rows: Vec<Row>,
    /// The biases of each block.
    starts: Vec<Row>,
}

/// Inputs in a word of [`Passed`].
const WORD: usize = 64;

/// The inputs of a batch that are added: those that are not 0, or behind a ReLU those above 0.
#[derive(Debug, Default)]
pub(super) struct Passed {
    /// A bit for each input of a sample, the first lowest; each sample begins a word.
    bits: Vec<u64>,
    /// Words of a sample.
    words: usize,
}

impl Passed {
    /// Takes the inputs of samples of `width` inputs each.
    pub(super) fn keep(&mut self, values: &[f64], width: usize, behind_relu: bool) {
        self.keep_with(Level::new(), values, width, behind_relu);
    }

    fn keep_with(&mut self, level: Level, values: &[f64], width: usize, behind_relu: bool) {
        self.words = width.div_ceil(WORD);
        self.bits.clear();
        self.bits.resize(values.len() / width * self.words, 0);
        dispatch!(level, simd => self.find(simd, values, width, behind_relu));
    }

    /// Sets the bits. Plain loops, so that the compiler sees the vectors in them.
    #[inline(always)]
    fn find<S: Simd>(&mut self, simd: S, values: &[f64], width: usize, behind_relu: bool) {
        let samples = values.chunks_exact(width);
        for (sample, bits) in samples.zip(self.bits.chunks_exact_mut(self.words)) {
            for (values, bits) in sample.chunks(WORD).zip(bits) {
                *bits = match behind_relu {
                    true => left::<_, true>(simd, values),
                    false => left::<_, false>(simd, values),
                };
            }
        }
    }

    /// The bits of each sample.
    fn samples(&self) -> impl Iterator<Item = &[u64]> {
        self.bits.chunks_exact(self.words.max(1))
    }
}

/// Which of at most 64 values are not 0, or behind a ReLU above 0.
#[inline(always)]
fn left<S: Simd, const BEHIND_RELU: bool>(simd: S, values: &[f64]) -> u64 {
    let zero = f64x8::splat(simd, 0.0);
    let (groups, rest) = values.as_chunks::<8>();
    let mut bits = 0;
    for (at, group) in groups.iter().enumerate() {
        let group = f64x8::from_slice(simd, group);
        let own = match BEHIND_RELU {
            true => group.simd_gt(zero).to_bitmask(),
            false => group.simd_eq(zero).to_bitmask() ^ 0xff,
        };
        bits |= own << (8 * at);
    }
    for (at, value) in (8 * groups.len()..).zip(rest) {
        let own = if BEHIND_RELU {
            *value > 0.0
        } else {
            *value != 0.0
        };
        bits |= u64::from(own) << at;
    }
    bits
}

impl Weights {
    /// Weights of `inputs`, a row of inputs for each output, and a bias for each output.
    pub(super) fn new(inputs: usize, weights: &[f32], bias: &[f32]) -> Self {
        let blocks = || bias.chunks(BLOCK).zip(weights.chunks(BLOCK * inputs));
        let rows = blocks().flat_map(|(_, block)| {
            (0..inputs).map(|input| Row::of(block.iter().skip(input).step_by(inputs)))
        });
        Self {
            inputs,
            outputs: bias.len(),
            rows: rows.collect(),
            starts: blocks().map(|(bias, _)| Row::of(bias.iter())).collect(),
        }
    }

    /// Replaces `sums` by those of each sample of `values`, before their ReLU.
    pub(super) fn sums(&self, values: &[f64], passed: &Passed, sums: &mut Vec<f64>) {
        self.sums_with(Level::new(), values, passed, sums);
    }

    fn sums_with(&self, level: Level, values: &[f64], passed: &Passed, sums: &mut Vec<f64>) {
        // Each is written.
        sums.resize(values.len() / self.inputs * self.outputs, 0.0);
        dispatch!(level, simd => self.with(simd, values, passed, sums));
    }

    /// The same with some vectors: as many outputs side by side as fit the registers.
    #[inline(always)]
    fn with<S: Simd>(&self, _: S, values: &[f64], passed: &Passed, sums: &mut [f64]) {
        match self.outputs {
            ..=8 => self.blocks::<8>(values, passed, sums),
            9..=16 => self.blocks::<16>(values, passed, sums),
            _ if S::f64s::LEN < 4 => self.blocks::<16>(values, passed, sums),
            _ => self.blocks::<BLOCK>(values, passed, sums),
        }
    }

    /// The sums of all outputs, `LANES` side by side.
    #[inline(always)]
    fn blocks<const LANES: usize>(&self, values: &[f64], passed: &Passed, sums: &mut [f64]) {
        let blocks = self.rows.chunks_exact(self.inputs).zip(&self.starts);
        for (block, (rows, starts)) in blocks.enumerate() {
            for part in (0..BLOCK).step_by(LANES) {
                let first = block * BLOCK + part;
                let Some(count) = self.outputs.checked_sub(first).filter(|rest| *rest > 0) else {
                    break;
                };
                let starts = *starts.lanes::<LANES>(part);
                let samples = values.chunks_exact(self.inputs).zip(passed.samples());
                let outputs = sums.chunks_exact_mut(self.outputs);
                for ((values, bits), outputs) in samples.zip(outputs) {
                    let own = summed(starts, rows, part, values, bits);
                    let outputs = &mut outputs[first..];
                    // A copy of known length is no call.
                    match outputs.first_chunk_mut::<LANES>() {
                        Some(whole) => *whole = own,
                        None => outputs.copy_from_slice(&own[..count]),
                    }
                }
            }
        }
    }
}

/// The sums of one sample from `starts` on, with the weights of `LANES` outputs from `first`, over the
/// inputs whose bit is set.
///
/// The loop over lanes is by number, which the compiler turns into vectors as it stands.
#[inline(always)]
#[allow(clippy::needless_range_loop)]
fn summed<const LANES: usize>(
    starts: [f64; LANES],
    rows: &[Row],
    first: usize,
    values: &[f64],
    bits: &[u64],
) -> [f64; LANES] {
    let mut sums = starts;
    let words = values.chunks(WORD).zip(rows.chunks(WORD)).zip(bits);
    for ((values, rows), bits) in words {
        let mut left = *bits;
        while left != 0 {
            let input = left.trailing_zeros() as usize;
            left &= left - 1;
            let (value, row) = (values[input], rows[input].lanes::<LANES>(first));
            for lane in 0..LANES {
                sums[lane] += row[lane] * value;
            }
        }
    }
    sums
}

impl Row {
    fn of<'a>(values: impl Iterator<Item = &'a f32>) -> Self {
        let mut row = [0.0; BLOCK];
        for (to, value) in row.iter_mut().zip(values) {
            *to = f64::from(*value);
        }
        Self(row)
    }

    /// `LANES` values from `first`, a multiple of `LANES`.
    #[inline(always)]
    fn lanes<const LANES: usize>(&self, first: usize) -> &[f64; LANES] {
        &self.0.as_chunks::<LANES>().0[first / LANES]
    }
}

#[cfg(test)]
mod tests {
    use potamoi_base::vectors::Vectors;
    use proptest::prelude::*;

    use super::*;

    /// Sums of one sample, input after input.
    fn plain(inputs: &[f64], weights: &[f32], bias: &[f32]) -> Vec<f64> {
        let rows = weights.chunks_exact(inputs.len()).zip(bias);
        let sums = rows.map(|(row, bias)| {
            let products = row.iter().zip(inputs).filter(|(_, x)| **x != 0.0);
            products.fold(f64::from(*bias), |sum, (w, x)| sum + f64::from(*w) * x)
        });
        sums.collect()
    }

    proptest! {
        /// A batch of any size has the sums of each sample alone, to the last bit: with all vectors
        /// of the machine, and with the lanes of others.
        #[test]
        fn a_batch_is_its_samples_one_by_one(
            inputs in 1..150usize,
            outputs in 1..80usize,
            samples in 0..9usize,
            seed: u64,
        ) {
            use rand::{Rng as _, SeedableRng as _};
            let mut random = rand_pcg::Pcg64Mcg::seed_from_u64(seed);
            let mut list = |count| -> Vec<f32> {
                (0..count).map(|_| random.random_range(-2.0f32..2.0)).collect()
            };
            let (weights, bias) = (list(inputs * outputs), list(outputs));
            let values = list(samples * inputs).into_iter();
            // A quarter are 0, of both signs.
            let values = values.map(|v| if v.abs() < 0.5 { f64::from(0f32.copysign(v)) } else { f64::from(v) / 3.0 });
            let values: Vec<f64> = values.collect();
            let made = Weights::new(inputs, &weights, &bias);
            let mut passed = Passed::default();
            let levels: Vec<Level> = Vectors::here().filter_map(Vectors::level).collect();
            for (level, behind_relu) in levels.iter().flat_map(|own| [(own, true), (own, false)]) {
                passed.keep_with(*level, &values, inputs, behind_relu);
                for (sample, words) in values.chunks_exact(inputs).zip(passed.samples()) {
                    for (at, value) in sample.iter().enumerate() {
                        let is_left = words[at / WORD] >> (at % WORD) & 1 == 1;
                        let passes = if behind_relu { *value > 0.0 } else { *value != 0.0 };
                        prop_assert_eq!(is_left, passes, "{} {}", at, value);
                    }
                }
            }
            let bits = |sums: &[f64]| sums.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
            let each = values.chunks_exact(inputs);
            let expected: Vec<f64> = each.flat_map(|own| plain(own, &weights, &bias)).collect();
            let mut sums = vec![];
            for level in levels {
                sums.fill(f64::NAN);
                made.sums_with(level, &values, &passed, &mut sums);
                prop_assert_eq!(bits(&sums), bits(&expected), "{:?}", level);
            }
            for narrow in [Weights::blocks::<8>, Weights::blocks::<16>, Weights::blocks::<BLOCK>] {
                sums.fill(f64::NAN);
                narrow(&made, &values, &passed, &mut sums);
                prop_assert_eq!(bits(&sums), bits(&expected));
            }
        }
    }
}
