//! The largest power at which the alpha of an opacity still counts.
//!
//! `alpha = o e(u)` counts if it is at least the alpha threshold. For each opacity `o` there is a
//! largest `u` that counts, and every larger one is dropped before the exponential. It is found by
//! a scan over the exponential's own codes, from the top, so that it holds for any form: nothing is
//! assumed of `e`, not even that it falls.
//!
//! With the opacity in the power, `alpha = e(u - ln o)`, one largest power holds for all, and the limit of
//! `u` is that less the record's `-ln o`.

use crate::exponential::ReferenceExponential;
use potamoi_formats::config::{ExpConfig, SplatOpacity};

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
    /// The limits of an exponential and an alpha threshold, U0.16, by the opacity's code in records. `config`
    /// has alpha output and an unsigned input.
    #[must_use]
    pub fn new(config: &ExpConfig, opacity_form: SplatOpacity, alpha_min: i32) -> Self {
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
        let last = |counts: &dyn Fn(i64) -> bool| {
            let counted = above.partition_point(|power| counts(*power));
            (counted as u32).checked_sub(1)
        };
        let most = last(&|power| of_exponential(power, bits) >= min);
        let limit = |opacity: u32| match opacity_form {
            SplatOpacity::Multiplied => last(&|power| counts(opacity.into(), power)),
            SplatOpacity::InPower => most.and_then(|most| most.checked_sub(opacity)),
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

/// An exponential of so many fraction bits, 16 at most, as an alpha, U0.16.
pub(super) const fn of_exponential(power: i64, bits: u32) -> i64 {
    power << (16 - bits)
}

/// Limits as the unit stores them.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum StoredLimits {
    /// By classes of opacities.
    Classes(CoarseLimits),
    /// The largest power that counts, of which the record's `-ln o` is a part; `None` if none does.
    Sum(Option<u32>),
}

impl StoredLimits {
    /// The limits of an exponential and an alpha threshold, U0.16.
    #[must_use]
    pub fn new(config: &ExpConfig, opacity: SplatOpacity, alpha_min: i32) -> Self {
        let exact = PowerLimits::new(config, opacity, alpha_min);
        match opacity {
            SplatOpacity::Multiplied => Self::Classes(CoarseLimits::new(&exact)),
            SplatOpacity::InPower => Self::Sum(exact.of(0)),
        }
    }

    /// The limit of an opacity, a code of records: at least the exact one; `None` only where nothing
    /// counts.
    #[must_use]
    pub fn of(&self, opacity: u16) -> Option<u32> {
        match self {
            Self::Classes(limits) => limits.of(opacity),
            Self::Sum(most) => most.and_then(|most| most.checked_sub(opacity.into())),
        }
    }

    /// Words of the unit's table by address. The bit above the `power_bits` of a word says whether any
    /// power counts: in the words from 64 on, or in the only one.
    #[must_use]
    pub fn words(&self, power_bits: u32) -> Vec<u32> {
        let counting = |word: u32, counts: bool| word | u32::from(counts) << power_bits;
        match self {
            Self::Classes(limits) => {
                let places = (0u32..).zip(&limits.less);
                let less = places.map(|(place, word)| counting(*word, place >= limits.least));
                limits.base.iter().copied().chain(less).collect()
            }
            Self::Sum(most) => vec![counting(most.unwrap_or(0), most.is_some())],
        }
    }
}

/// Limits by classes of opacities, rounded up: one for each value of the six bits after the
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
            let limits = PowerLimits::new(&config, SplatOpacity::Multiplied, MIN);
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
            let exact = PowerLimits::new(&config, SplatOpacity::Multiplied, MIN);
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

    /// With the opacity in the power, every opacity and every power of every preset: the limit is exact.
    #[test]
    fn of_an_opacity_in_the_power_the_limit_is_exact() {
        for config in configs() {
            let twin = ReferenceExponential::new(&config);
            let counts = |power: u32| {
                let e = twin.exp(power as i32);
                of_exponential(e.into(), config.output_bits) >= i64::from(MIN)
            };
            let stored = StoredLimits::new(&config, SplatOpacity::InPower, MIN);
            let exact = PowerLimits::new(&config, SplatOpacity::InPower, MIN);
            let last = (0..1u32 << config.input.width()).rfind(|power| counts(*power));
            for opacity in 0..=u16::MAX {
                let own = last.and_then(|last| last.checked_sub(opacity.into()));
                assert_eq!(stored.of(opacity), own, "{config:?} {opacity}");
                assert_eq!(exact.of(opacity), own, "{config:?} {opacity}");
            }
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
        let limits = PowerLimits::new(&config, SplatOpacity::Multiplied, MIN);
        let last = (0..1 << 16)
            .rev()
            .find(|u| (65_535 * i64::from(twin.exp(*u)) + (1 << 15)) >> 16 >= 258);
        assert_eq!(limits.of(65_535), last.map(|u| u as u32));
    }
}
