//! Work of a multiply-accumulate unit of the array.

use potamoi_rtl::WeightProducts;
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64Mcg;

use super::activity::GatherWindow;

/// Channels whose column is simulated, and samples of each.
const CHANNELS: usize = 8;
const SAMPLES: usize = 256;
/// Seed of the weights.
const SEED: u64 = 7;

/// Products of a column of the array: for each channel a weight, which all samples use.
///
/// Inputs are features that a scene's samples gathered, sums those of the channels above. Weights
/// are drawn: no trained network of 16-bit weights is at hand.
#[derive(Debug, Clone, Default, PartialEq, serde::Serialize)]
pub(super) struct MultiplyWindow {
    pub(super) runs: Vec<WeightProducts>,
}

impl MultiplyWindow {
    /// The work of the units that the first channels of a share of gathering go to.
    pub(super) fn of(gathered: &GatherWindow) -> Self {
        let channels = gathered.tasks.first().map_or(0, |task| task.channels);
        let samples: Vec<&[i32]> = (gathered.features.chunks(channels.max(1)))
            .take(SAMPLES)
            .collect();
        let mut sums = vec![0i32; samples.len()];
        let mut random = Pcg64Mcg::seed_from_u64(SEED);
        let runs = (0..channels.min(CHANNELS)).map(|channel| {
            let weight = weight(&mut random);
            let operands = samples.iter().zip(&mut sums).map(|(sample, sum)| {
                let input = sample[channel].clamp(i16::MIN.into(), i16::MAX.into()) as i16;
                let above = *sum;
                *sum = WeightProducts::sum(weight, input, above);
                (input, above)
            });
            WeightProducts {
                weight,
                operands: operands.collect(),
            }
        });
        Self {
            runs: runs.collect(),
        }
    }

    pub(super) fn products(&self) -> u64 {
        self.runs.iter().map(|run| run.operands.len() as u64).sum()
    }
}

/// A weight of a bell curve around 0, by the sum of three even ones; its standard deviation is a
/// quarter of the range.
fn weight(random: &mut Pcg64Mcg) -> i16 {
    let third = i16::MAX / 4;
    (0..3).map(|_| random.random_range(-third..=third)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use potamoi_formats::rit::Vertices;
    use potamoi_reference::GatherTask;

    /// Three samples of two channels: the second channel's sums are the first one's products.
    #[test]
    fn sums_are_those_of_the_channels_above() {
        let task = GatherTask {
            vertices: Vertices::Eight,
            channels: 2,
            rows: vec![],
            entries: vec![],
        };
        let window = MultiplyWindow::of(&GatherWindow {
            tasks: vec![task],
            features: vec![3, 10, -4, 20, 40_000, 30],
        });
        let [first, second] = &window.runs[..] else {
            unreachable!("two channels")
        };
        assert_eq!(window.products(), 6);
        assert_eq!(first.operands, [(3, 0), (-4, 0), (i16::MAX, 0)]);
        let above = [3, -4, i16::MAX].map(|x| i32::from(x) * i32::from(first.weight));
        let expected: Vec<_> = [10, 20, 30].into_iter().zip(above).collect();
        assert_eq!(second.operands, expected);
        assert_ne!(first.weight, second.weight);
    }

    /// A quarter of the range is 8191; each of three has a deviation of 8191 / sqrt(3).
    #[test]
    fn weights_are_a_bell_of_a_quarter_of_the_range() {
        let mut random = Pcg64Mcg::seed_from_u64(1);
        let all: Vec<f64> = (0..4000).map(|_| weight(&mut random).into()).collect();
        let mean = all.iter().sum::<f64>() / all.len() as f64;
        let square = all.iter().map(|w| (w - mean).powi(2)).sum::<f64>() / all.len() as f64;
        // Three standard errors.
        assert!(mean.abs() < 3.0 * 8191.0 / 4000f64.sqrt(), "{mean}");
        assert!(
            (square.sqrt() / 8191.0 - 1.0).abs() < 3.0 / 8000f64.sqrt(),
            "{square}"
        );
    }
}
