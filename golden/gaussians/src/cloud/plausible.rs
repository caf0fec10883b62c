//! Values that are allowed, and that no trainer writes.

use super::Cloud;

/// Largest colour coefficient, in magnitude, that is plausible. Trained ones are within 20, of HDR pictures
/// within some hundreds.
const COLOUR: f32 = 1000.0;
/// Largest plausible natural logarithm of a size: 5e8 scene units. Those of trained backgrounds are within
/// 10.
const LOG_SCALE: f32 = 20.0;
/// Largest plausible coordinate of a centre in scene units.
const CENTRE: f32 = 1e9;

impl Cloud {
    /// Sentences on values that are far beyond those of trained models, such as those of a damaged file:
    /// how many Gaussians have them, and the largest.
    #[must_use]
    pub fn implausible(&self) -> Vec<String> {
        let coefficients = self.sh.len() / self.len().max(1);
        let colours = self.sh.chunks(coefficients.max(1)).map(largest);
        let sizes = self
            .log_scales
            .iter()
            .map(|own| own.iter().copied().fold(f32::MIN, f32::max));
        let centres = self.means.iter().map(|own| largest(&[*own]));
        [
            beyond("a colour coefficient", colours, COLOUR, |own| own),
            beyond("a size in scene units", sizes, LOG_SCALE, f32::exp),
            beyond("a coordinate of the centre", centres, CENTRE, |own| own),
        ]
        .into_iter()
        .flatten()
        .map(|text| format!("that the file is whole, although {text}"))
        .collect()
    }
}

/// The largest magnitude.
fn largest(values: &[[f32; 3]]) -> f32 {
    values
        .iter()
        .flatten()
        .fold(0f32, |most, own| most.max(own.abs()))
}

/// How many values are beyond a limit; nothing where none is. `shown` is a value as users know it.
fn beyond(
    what: &str,
    values: impl Iterator<Item = f32>,
    limit: f32,
    shown: fn(f32) -> f32,
) -> Option<String> {
    let (mut count, mut all, mut most) = (0usize, 0usize, f32::MIN);
    for own in values {
        all += 1;
        if own > limit {
            count += 1;
            most = most.max(own);
        }
    }
    (count > 0).then(|| {
        format!(
            "{count} of {all} Gaussians have {what} beyond {:.0e} (the largest is {:.1e})",
            shown(limit),
            shown(most)
        )
    })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn cloud(mean: f32, log_scale: f32, colour: f32) -> Cloud {
        let two = |own: f32| vec![[0.5; 3], [own, 0.0, 0.0]];
        Cloud::new(
            0,
            two(mean),
            two(log_scale),
            vec![[1.0, 0.0, 0.0, 0.0]; 2],
            vec![0.0; 2],
            two(colour),
        )
        .unwrap()
    }

    #[test]
    fn values_of_trained_models_pass_and_others_are_counted() {
        assert!(cloud(-1e6, 10.0, -300.0).implausible().is_empty());
        for (own, said) in [
            (
                cloud(0.0, 0.0, -1e30),
                "1 of 2 Gaussians have a colour coefficient beyond 1e3 (the largest is 1.0e30)",
            ),
            (
                cloud(0.0, 80.0, 0.0),
                "1 of 2 Gaussians have a size in scene units beyond 5e8 (the largest is 5.5e34)",
            ),
            (
                cloud(-2e9, 0.0, 0.0),
                "1 of 2 Gaussians have a coordinate of the centre beyond 1e9 (the largest is 2.0e9)",
            ),
        ] {
            let found = own.implausible();
            assert_eq!(found.len(), 1);
            assert!(found[0].ends_with(said), "{found:?}");
        }
    }
}
