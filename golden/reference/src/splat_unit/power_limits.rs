//! The largest power at which the alpha of an opacity still counts.
//!
//! `alpha = o e(u)` counts if it is at least the alpha threshold. For each opacity `o` there is a
//! largest `u` that counts, and every larger one is dropped before the exponential. It is found by
//! a scan over the exponential's own codes, from the top, so that it holds for any form: nothing is
//! assumed of `e`, not even that it falls.

use crate::exponential::ReferenceExponential;
use potamoi_formats::config::ExpConfig;

/// Codes of an opacity, U0.16.
const OPACITIES: u32 = 1 << 16;
/// Bits after the leading one that tell opacities apart in [`CoarseLimits`].
const INDEX_BITS: u32 = 6;
/// Leading ones of opacities.
const OCTAVES: usize = 16;

/// The limit of every opacity, exactly.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PowerLimits {
    /// By opacity; `None` where nothing counts.
    limits: Vec<Option<u32>>,
}

impl PowerLimits {
    /// The limits of an exponential and an alpha threshold, U0.16. `config` has alpha output and an
    /// unsigned input.
    #[must_use]
    pub fn new(config: &ExpConfig, alpha_min: i32) -> Self {
        let exp = ReferenceExponential::new(config);
        let codes = 1u32 << config.input.width().min(24);
        // The largest power at or above each code: it never rises.
        let mut above: Vec<i64> = (0..codes).map(|u| exp.exp(u as i32).into()).collect();
        for u in (1..above.len()).rev() {
            above[u - 1] = above[u - 1].max(above[u]);
        }
        let (min, bits) = (i64::from(alpha_min), config.output_bits);
        let counts =
            |opacity: i64, power: i64| (opacity * power + (1 << (bits - 1))) >> bits >= min;
        let limit = |opacity: u32| {
            let counted = above.partition_point(|power| counts(opacity.into(), *power));
            (counted as u32).checked_sub(1)
        };
        Self {
            limits: (0..OPACITIES).map(limit).collect(),
        }
    }

    /// The largest power, a code of the exponential's input, at which this opacity counts.
    #[must_use]
    pub fn of(&self, opacity: u16) -> Option<u32> {
        self.limits[usize::from(opacity)]
    }
}

/// Limits as the unit stores them, rounded up: one for each value of the six bits after the
/// opacity's leading one, and an offset for each place of the leading one.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CoarseLimits {
    /// By the six bits after the leading one, for opacities from 1/2 on.
    pub base: Vec<u32>,
    /// What is subtracted, by the place of the leading one.
    pub less: Vec<u32>,
    /// The place of the leading one below which nothing counts.
    pub least: u32,
}

impl CoarseLimits {
    /// The limits that lie nowhere below the exact ones.
    #[must_use]
    pub fn new(exact: &PowerLimits) -> Self {
        let mut highest = vec![[None; OCTAVES]; 1 << INDEX_BITS];
        for opacity in 1..=u16::MAX {
            let (octave, index) = Self::class(opacity);
            let own = &mut highest[index][octave as usize];
            *own = exact.of(opacity).max(*own);
        }
        let counts = |octave: &usize| highest.iter().any(|own| own[*octave].is_some());
        let least = (0..OCTAVES).find(counts).unwrap_or(OCTAVES) as u32;
        let top = OCTAVES - 1;
        // The smallest distance between an octave and the top one, over all indices.
        let less: Vec<u32> = (0..OCTAVES)
            .map(|octave| {
                let both = highest
                    .iter()
                    .filter_map(|own| Some((own[top]?, own[octave]?)));
                both.map(|(top, own)| top.saturating_sub(own))
                    .min()
                    .unwrap_or(0)
            })
            .collect();
        let base = (highest.iter())
            .map(|own| {
                let all = own
                    .iter()
                    .zip(&less)
                    .filter_map(|(own, less)| Some((*own)? + less));
                all.max().unwrap_or(0)
            })
            .collect();
        Self { base, less, least }
    }

    /// Place of the leading one, and the six bits after it.
    #[must_use]
    pub fn class(opacity: u16) -> (u32, usize) {
        let octave = opacity.max(1).ilog2();
        let moved = u32::from(opacity) << (OCTAVES as u32 - 1 - octave);
        let index = moved >> (OCTAVES as u32 - 1 - INDEX_BITS) & ((1 << INDEX_BITS) - 1);
        (octave, index as usize)
    }

    /// The limit of an opacity, at least the exact one; `None` only where nothing counts.
    #[must_use]
    pub fn of(&self, opacity: u16) -> Option<u32> {
        let (octave, index) = Self::class(opacity);
        if opacity == 0 || octave < self.least {
            return None;
        }
        Some(self.base[index].saturating_sub(self.less[octave as usize]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use potamoi_formats::config::{Config, ExpForm, PRESETS};

    const MIN: i32 = 258;

    fn configs() -> Vec<ExpConfig> {
        let presets = PRESETS.iter().filter_map(|(name, _)| Config::preset(name));
        let presets = presets.map(|config| config.vu.exp);
        let small = |exp: &ExpConfig| exp.input.width() <= 16 && !exp.input.is_signed();
        presets.filter(small).collect()
    }

    /// Every opacity and every power, of every preset: a pair above the limit never counts, and the
    /// pair at the limit does.
    #[test]
    fn exactly_what_counts_is_kept() {
        for config in configs() {
            let twin = ReferenceExponential::new(&config);
            let f = config.output_bits;
            let powers: Vec<i64> = (0..1 << config.input.width())
                .map(|u| twin.exp(u).into())
                .collect();
            let limits = PowerLimits::new(&config, MIN);
            let alpha = |o: u16, u: usize| (i64::from(o) * powers[u] + (1 << (f - 1))) >> f;
            // All opacities at the edge; the powers above by their maximum.
            let mut above = powers.clone();
            for u in (1..above.len()).rev() {
                above[u - 1] = above[u - 1].max(above[u]);
            }
            for o in 0..=u16::MAX {
                let from = limits.of(o).map_or(0, |u| u as usize + 1);
                if let Some(highest) = above.get(from) {
                    let largest = (i64::from(o) * highest + (1 << (f - 1))) >> f;
                    assert!(largest < i64::from(MIN), "{config:?} {o}");
                }
                if let Some(u) = limits.of(o) {
                    assert!(alpha(o, u as usize) >= i64::from(MIN), "{config:?} {o}");
                }
            }
        }
    }

    /// The stored limits of all opacities are nowhere below the exact ones, nearly everywhere within
    /// 1/50 above, and name what never counts.
    #[test]
    fn stored_limits_err_upwards_and_little() {
        for config in configs() {
            let exact = PowerLimits::new(&config, MIN);
            let stored = CoarseLimits::new(&exact);
            assert_eq!(stored.base.len(), 64);
            let unit = f64::from(1u32 << config.input.frac_bits());
            let mut worst = 0.0f64;
            for o in 0..=u16::MAX {
                match (stored.of(o), exact.of(o)) {
                    (Some(stored), Some(exact)) => {
                        assert!(stored >= exact, "{config:?} {o}");
                        worst = worst.max(f64::from(stored - exact) / unit);
                    }
                    (None, of) => assert_eq!(of, None, "{config:?} {o}"),
                    // In the octave of the smallest opacity that counts.
                    (Some(_), None) => assert!(o < 512, "{config:?} {o}"),
                }
            }
            // A class is 1/64 wide; near the smallest opacity that counts the limit falls to 0.
            assert!(worst < 0.1, "{config:?}: {worst}");
        }
    }

    /// Powers that rise with the operand cannot be cut: the printed recurrence, wrong there, keeps
    /// what counts further up.
    #[test]
    fn a_form_that_rises_is_cut_only_above_its_last_power_that_counts() {
        let config = ExpConfig {
            form: ExpForm::Literal,
            ..ExpConfig::default()
        };
        let twin = ReferenceExponential::new(&config);
        let limits = PowerLimits::new(&config, MIN);
        let last = (0..1 << 16)
            .rev()
            .find(|u| (65_535 * i64::from(twin.exp(*u)) + (1 << 15)) >> 16 >= 258);
        assert_eq!(limits.of(65_535), last.map(|u| u as u32));
    }
}
