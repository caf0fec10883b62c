//! The test of a (tile, Gaussian) pair: whether a pixel of the tile may count.
//!
//! The GPU makes it for each pair of the profile's list, twice: to count the pairs of a Gaussian and
//! to write them. It finds the smallest `p^2 + q^2` over the rectangle of the tile's pixel centres, and
//! leaves the pair out if that exceeds what the opacity's limit allows for
//! ([`StoredLimits`]). With `p = a x + b y` and `q = c y` at the offset (x, y) from the mean, the
//! smallest lies at the mean where the rectangle holds it, or else on one of the two sides that face
//! the mean:
//!
//! - on the side at x, at `y = -(a b / (b^2 + c^2)) x`, held within the rectangle;
//! - on the side at y, at `x = -(b / a) y`, held within the rectangle.
//!
//! All is computed with 32-bit floats. What rounding may add to `sqrt(p^2 + q^2)` widens the limit, so
//! that no pixel that counts is left out: with `u = 2^-24` and `m` the sum of the mean's magnitudes, the
//! picture's longer side and 1,
//!
//! | what is rounded | adds at most, times `(abs a + abs b + abs c) m` |
//! |---|---|
//! | the mean, its distance to pixel 0, and the distances to the rectangle's sides | 3 u |
//! | the two factors, their products with x and y, and the place on a side | 12 u |
//! | p and q | 3 u |
//!
//! of which 32 u are taken, and 2^-16 for the hardware's own forms, which are rounded to 16 fraction
//! bits.

use potamoi_formats::config::{ExpBase, ExpConfig, ExpOutput, SplatOpacity};
use potamoi_formats::record::{FACTOR, MEAN, SplatRecord};
use potamoi_reference::splat_unit::StoredLimits;
use rayon::prelude::*;

use crate::composite::Limits;
use crate::profile::Rules;
use crate::records::Saturations;
use crate::view::View;

/// Most bits of the exponential's input: all its codes are computed.
const MOST_INPUT: u32 = 20;
/// Roundings of 32-bit floats, in units of the last bit of 1: see above.
const ROUNDINGS: f32 = 32.0 * f32::EPSILON / 2.0;
/// What the rounding of the hardware's forms adds.
const FORMS: f32 = 1.0 / 65_536.0;
/// What rounding of squares adds, relatively.
const SQUARES: f32 = 1.0 + 16.0 * f32::EPSILON;

/// The largest power that counts, by opacity, for the test of (tile, Gaussian) pairs. It is rounded up
/// as in the splat unit.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TileLimits {
    stored: StoredLimits,
    opacity: SplatOpacity,
    /// The largest code of the exponential's input, at which all larger powers are held.
    top: u32,
    power_bits: u32,
    alpha_min: i32,
}

impl TileLimits {
    /// The limits of a configuration's exponential and a set of rules. `None` where no pair can be left
    /// out: powers of two, mantissa and exponent, a signed input, or one of more than 20 bits.
    #[must_use]
    pub fn new(exp: &ExpConfig, rules: &Rules, opacity: SplatOpacity) -> Option<Self> {
        let cuts = exp.base == ExpBase::E
            && exp.output == ExpOutput::Alpha
            && !exp.input.is_signed()
            && exp.input.width() <= MOST_INPUT;
        if !cuts {
            return None;
        }
        let alpha_min = Limits::new(rules).alpha_min;
        Some(Self {
            stored: StoredLimits::new(exp, opacity, alpha_min),
            opacity,
            top: (1 << exp.input.width()) - 1,
            power_bits: exp.input.frac_bits(),
            alpha_min,
        })
    }

    /// Whether the limits are those of these rules, or wider.
    pub(crate) fn hold_for(&self, rules: &Rules) -> bool {
        self.alpha_min <= Limits::new(rules).alpha_min
    }

    /// The largest `sqrt(p^2 + q^2)` at which an opacity may count; `None` if it never does. Infinite
    /// where the largest power of all counts, which stands for all larger ones too.
    fn radius(&self, opacity: u16) -> Option<f32> {
        let limit = self.stored.of(opacity)?;
        if limit >= self.top {
            return Some(f32::INFINITY);
        }
        // Half the sum of squares is rounded half up.
        let squared = (2 * limit + 1) as f32 / (1u32 << self.power_bits) as f32;
        Some(squared.sqrt())
    }
}

/// The test of one Gaussian's pairs.
#[derive(Debug, Clone, Copy)]
pub(crate) struct TileTest {
    factor: [f32; 3],
    /// Offset of the centre of pixel 0 from the mean.
    origin: [f32; 2],
    /// x over y of the nearest place on a side at y, and y over x.
    slopes: [f32; 2],
    /// The largest `p^2 + q^2` that may count; negative if none does.
    limit: f32,
}

/// A divisor: none is 0.
fn divisor(value: f32) -> f32 {
    if value == 0.0 { 1e-30 } else { value }
}

impl TileTest {
    /// The test of a record, in a picture whose longer side is `side` pixels. `centre` is the centre of
    /// pixel 0.
    pub(crate) fn new(record: &SplatRecord, limits: &TileLimits, centre: f32, side: u32) -> Self {
        let unit = |bits: u32| 1.0 / (1u64 << bits) as f32;
        let [a, b, c] = record.factor.map(|v| v as f32 * unit(FACTOR.frac_bits()));
        let mean = record.mean.map(|v| v as f32 * unit(MEAN.frac_bits()));
        let far = mean[0].abs() + mean[1].abs() + side as f32 + 1.0;
        let steep = a.abs() + b.abs() + c.abs();
        let limit = limits.radius(record.opacity).map_or(-1.0, |radius| {
            let widened = (steep * far).mul_add(ROUNDINGS, radius + FORMS);
            widened * widened * SQUARES
        });
        Self {
            factor: [a, b, c],
            origin: mean.map(|v| centre - v),
            slopes: [-b / divisor(a), -(a * b) / divisor(b.mul_add(b, c * c))],
            limit,
        }
    }

    /// Whether a pixel of the rectangle may count. `first` and `last` are the places of its first and
    /// last pixel in the picture.
    pub(crate) fn keeps(&self, first: [u32; 2], last: [u32; 2]) -> bool {
        let [a, b, c] = self.factor;
        let [x0, y0] = [0, 1].map(|i| first[i] as f32 + self.origin[i]);
        let [x1, y1] = [0, 1].map(|i| last[i] as f32 + self.origin[i]);
        let squared = |x: f32, y: f32| {
            let (p, q) = (a.mul_add(x, b * y), c * y);
            p.mul_add(p, q * q)
        };
        let (x, y) = (x1.min(0.0).max(x0), y1.min(0.0).max(y0));
        let beside = squared(x, (self.slopes[1] * x).min(y1).max(y0));
        let above = squared((self.slopes[0] * y).min(x1).max(x0), y);
        beside.min(above) <= self.limit
    }
}

impl View {
    /// The same view without the (tile, Gaussian) pairs in whose tile no pixel can count, if the limits
    /// hold for its rules. Ranks stay as they are, so that some may have no tile.
    #[must_use]
    pub fn that_may_count(self, limits: &TileLimits) -> Self {
        if !limits.hold_for(self.rules()) {
            return self;
        }
        let records = self.records(limits.opacity, &mut Saturations::default());
        let kept = kept(&self, &records, limits);
        self.with_pairs(&kept)
    }
}

/// Whether each (tile, Gaussian) pair of a view, rank after rank, may count. `records` are those of the
/// view.
pub(crate) fn kept(view: &View, records: &[SplatRecord], limits: &TileLimits) -> Vec<bool> {
    let side = view.size().into_iter().max().unwrap_or_default();
    let centre = view.rules().pixel_centre as f32;
    let of = |rank: usize| {
        let test = TileTest::new(&records[rank], limits, centre, side);
        view.tiles_of(rank).iter().map(move |tile| {
            let [first, size] = view.tile_pixels(*tile as usize);
            test.keeps(first, [0, 1].map(|i| first[i] + size[i] - 1))
        })
    };
    let ranks = (0..records.len()).into_par_iter();
    ranks.flat_map_iter(of).collect()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use std::sync::LazyLock;

    use potamoi_formats::config::Config;
    use potamoi_reference::exponential::ReferenceExponential;
    use potamoi_reference::splat_unit::{Forms, TILE};
    use proptest::prelude::*;

    use super::*;
    use crate::Profile;

    /// The paper's exponential and coarse ones, with their limits, which are the same of all profiles.
    static CONFIGS: LazyLock<Vec<(Config, TileLimits)>> = LazyLock::new(|| {
        let texts = [
            "",
            "[vu.exp]\niterations = 3",
            "[vu.exp]\nform = \"piecewise\"\npipelined = true\npieces = 64",
            "[vu.exp]\niterations = 5",
        ];
        let of = |text: &str| {
            let config = Config::from_toml(text, "test").unwrap();
            let limits = TileLimits::new(
                &config.vu.exp,
                &Profile::Inria.rules(),
                SplatOpacity::Multiplied,
            )
            .unwrap();
            (config, limits)
        };
        texts.into_iter().map(of).collect()
    });

    /// Whether a pixel of the rectangle counts, by the vector unit's own steps; and whether the test
    /// keeps the pair.
    fn both(
        record: &SplatRecord,
        ((config, own), rules): (&(Config, TileLimits), &Rules),
        (first, size): ([u32; 2], [u32; 2]),
    ) -> [bool; 2] {
        let (exp, limits) = (&config.vu.exp, Limits::new(rules));
        let twin = ReferenceExponential::new(exp);
        let half = (rules.pixel_centre * 4096.0) as i64;
        let forms = Forms::new(record, first.map(|v| (i64::from(v) << 12) + half));
        let (shift, f) = (33 - exp.input.frac_bits(), exp.output_bits);
        let counts = |x: u32, y: u32| {
            let [p, q] = forms.at(x, y).map(i128::from);
            let u = (p * p + q * q + (1 << (shift - 1))) >> shift;
            let e = i64::from(twin.exp(u.min(i32::MAX.into()) as i32));
            let alpha = (i64::from(record.opacity) * e + (1 << (f - 1))) >> f;
            alpha >= i64::from(limits.alpha_min)
        };
        let counted = (0..size[1]).any(|y| (0..size[0]).any(|x| counts(x, y)));
        let centre = rules.pixel_centre as f32;
        let last = [0, 1].map(|i| first[i] + size[i] - 1);
        let test = TileTest::new(record, own, centre, 1 << 15);
        [counted, test.keeps(first, last)]
    }

    fn record(mean: [i32; 2], factor: [i32; 3], opacity: u16) -> SplatRecord {
        SplatRecord {
            mean,
            factor,
            opacity,
            colour: [0; 3],
            rank: 0,
        }
    }

    proptest! {
        /// Any record, near the tile and far from it, needles too: a pair in whose tile a pixel counts
        /// is kept, whatever the exponential.
        #[test]
        fn no_pixel_that_counts_is_left_out(
            mean in any::<[i32; 2]>(), near in 0u32..20, factor in any::<[i32; 3]>(),
            thin in 0u32..31, tile in any::<[u8; 2]>(), opacity in any::<u16>(),
            faint in 0u32..9, columns in 1u32..=TILE, rows in 1u32..=TILE, which in 0usize..4,
            centred in any::<bool>()
        ) {
            let first = tile.map(|t| u32::from(t) * TILE);
            let mean = [0, 1].map(|i| ((first[i] << 12) as i32).wrapping_add(mean[i] >> near));
            let factor = [factor[0] >> (thin / 2), factor[1] >> thin, factor[2] >> (thin / 2)];
            let profile = if centred { Profile::Gsplat } else { Profile::Inria };
            let of = record(mean, factor, opacity >> faint);
            let config = &CONFIGS[which];
            let place = (first, [columns, rows]);
            let [counted, kept] = both(&of, (config, &profile.rules()), place);
            prop_assert!(!counted || kept, "{of:?} at {place:?}: {:?}", config.0.vu.exp);
        }
    }

    /// Needles of any direction that pass a tile by at about the distance at which they count no more:
    /// none that counts is left out, and of those that do not, few are kept.
    #[test]
    fn the_edge_is_met() {
        let (config, rules) = (&CONFIGS[0], Profile::Inria.rules());
        let (mut kept, mut counted) = (0, 0);
        for turn in 0..60 {
            let (s, c) = (f64::from(turn) * 0.1).sin_cos();
            for step in 0..200 {
                let (long, short) = (40.0 + f64::from(step), 0.6 + f64::from(step % 7));
                let footprint = crate::Footprint::new(
                    glam::DVec3::new(long * c, -short * s, 0.0),
                    glam::DVec3::new(long * s, short * c, 0.0),
                    0.3,
                );
                let factor = footprint.factor.map(|v| (v * f64::from(1 << 30)) as i32);
                // Across the needle, from its middle line.
                let off = f64::from(step) / 200.0 * (4.0 * short + 12.0);
                let mean = [100.0 - off * s, 100.0 + off * c].map(|v| (v * 4096.0) as i32);
                let of = record(mean, factor, 60_000);
                let found = both(&of, (config, &rules), ([92, 92], [16, 16]));
                assert!(!found[0] || found[1], "{of:?}");
                counted += u32::from(found[0]);
                kept += u32::from(found[1]);
            }
        }
        assert!(counted > 1000 && counted < 11_000, "{counted}");
        assert!(
            f64::from(kept) < 1.03 * f64::from(counted),
            "{kept} {counted}"
        );
    }

    #[test]
    fn exponentials_without_a_cut_have_no_limits() {
        let rules = Profile::Inria.rules();
        let text = "[vu.exp]\ninput = \"U3.18\"\nconstant_bits = 24";
        let wide = Config::from_toml(text, "test").unwrap().vu.exp;
        let paper = Config::default().vu.exp;
        let general = ExpConfig {
            output: ExpOutput::General,
            ..paper.clone()
        };
        let two = ExpConfig {
            base: ExpBase::Two,
            ..paper
        };
        for exp in [wide, general, two] {
            assert_eq!(
                TileLimits::new(&exp, &rules, SplatOpacity::Multiplied),
                None,
                "{exp:?}"
            );
        }
    }

    #[test]
    fn limits_of_another_threshold_do_not_hold() {
        let (rules, config) = (Profile::Inria.rules(), Config::default());
        let limits = TileLimits::new(&config.vu.exp, &rules, SplatOpacity::Multiplied).unwrap();
        let of = |alpha_min| Rules { alpha_min, ..rules };
        assert!(limits.hold_for(&rules) && limits.hold_for(&of(0.01)));
        assert!(!limits.hold_for(&of(0.003)));
    }
}
