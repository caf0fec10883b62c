//! Error bounds of fixed-point pictures against floating-point ones, derived per pixel from the
//! formats and the exponential's own bound, without rendering.
//!
//! | step | error |
//! |---|---|
//! | p, q | half a unit of each factor and of the mean, each times its multiplicand; half a unit of S15.16 |
//! | u | the errors of p and q, half a unit of U3.13 |
//! | e | between `exp(-u - du)` and `exp(-u + du)`, and the [`VectorBounds`]' units |
//! | alpha | half a unit of the opacity, half a unit of its own; 0 where it may be skipped |
//! | alpha, opacity in the power | that of e, with half a unit of the opacity's logarithm, U3.13, in the power |
//! | T' | half a unit of U1.20 a Gaussian |
//! | colour | half a unit of U4.12, the excess over its largest value, and the error of a network |
//!
//! A picture is affine in each alpha. Replacing one alpha, with those behind it replaced already,
//! changes the picture by at most the transmittance in front of it, times the difference, times
//! the brightest colour. If one of the two rays may stop where the other continues, all remaining
//! transmittance counts.

use potamoi_formats::config::{ExpConfig, SplatOpacity};
use potamoi_formats::record::{COLOUR, LOG_OPACITY, MEAN, OPACITY};
use rayon::prelude::*;

use super::composite::Limits;
use super::profile::Rules;
use super::project::Projected;
use super::view::View;
use potamoi_reference::bounds::VectorBounds;

/// Error that 64-bit arithmetic may add to a product of 36 fraction bits.
const FLOAT: f64 = 1e-11;

/// The rules of a fixed-point frame and of the floating-point frame it is compared with.
#[derive(Debug, Clone, Copy)]
pub struct Pair {
    /// Rules of the fixed-point frame.
    pub fixed: Rules,
    /// Rules of the floating-point frame.
    pub float: Rules,
    /// How opacities enter the alphas of the fixed-point frame.
    pub opacity: SplatOpacity,
}

/// Rounding errors of a record's formats and of the values derived from them.
#[derive(Debug, Clone, Copy)]
struct RoundingErrors {
    factor: f64,
    mean: f64,
    form: f64,
    power: f64,
    /// Error of a power of e.
    exponential: f64,
    alpha: f64,
    log_opacity: f64,
    transmittance: f64,
}

impl RoundingErrors {
    fn of(rules: &Rules, exp: &ExpConfig, powers: &VectorBounds) -> Self {
        Self {
            factor: 2f64.powi(-(rules.conic_bits as i32)) / 2.0,
            mean: MEAN.ulp() / 2.0,
            form: 2f64.powi(-17),
            power: exp.input.ulp() / 2.0,
            exponential: powers.exp * 2f64.powi(-(exp.output_bits as i32)),
            alpha: OPACITY.ulp() / 2.0,
            log_opacity: LOG_OPACITY.ulp() / 2.0,
            transmittance: 2f64.powi(-(rules.transmittance_bits as i32)) / 2.0,
        }
    }
}

/// Range of the alpha of a Gaussian at a pixel.
#[derive(Debug, Clone, Copy)]
struct Alpha {
    /// The floating-point value; 0 if it is skipped.
    float: f64,
    /// Lower and upper bound of the fixed-point value.
    fixed: [f64; 2],
}

/// Upper bounds of the error of each pixel's channels, for a frame in exact order with the
/// exponential bounds `exp` and the given error of the Gaussians' colours. The fixed-point and the
/// floating-point frame have their own rules, whose cut-offs must be no lower than those of
/// `view`.
#[must_use]
pub fn error_bounds(
    view: &View,
    rules: &Pair,
    exp: &ExpConfig,
    powers: &VectorBounds,
    background: [f32; 3],
    colours_off: f64,
) -> Vec<f64> {
    let off = RoundingErrors::of(&rules.fixed, exp, powers);
    let (first, ranks) = view.by_tile();
    let [width, height] = view.size();
    let behind = background
        .iter()
        .fold(0.0, |m, v| f64::max(m, f64::from(*v)));
    let tiles: Vec<Vec<([u32; 2], f64)>> = (0..first.len() - 1)
        .into_par_iter()
        .map(|tile| {
            let own = &ranks[first[tile]..first[tile + 1]];
            let splats: Vec<&Projected> = own.iter().map(|r| &view.splats()[*r as usize]).collect();
            let brightest = splats
                .iter()
                .fold(behind, |m, s| m.max(s.colour.max_element() + colours_off));
            let [[left, top], [columns, rows]] = view.tile_pixels(tile);
            let pixels = (0..rows).flat_map(|y| (0..columns).map(move |x| [left + x, top + y]));
            pixels
                .map(|at| {
                    // Weights of colours add up to 1 at most.
                    let own = pixel(rules, &splats, at, &off, brightest);
                    (at, own + colours_off)
                })
                .collect()
        })
        .collect();
    let mut bounds = vec![0.0; width as usize * height as usize];
    for ([x, y], bound) in tiles.into_iter().flatten() {
        bounds[(y * width + x) as usize] = bound;
    }
    bounds
}

fn pixel(
    rules: &Pair,
    splats: &[&Projected],
    at: [u32; 2],
    off: &RoundingErrors,
    brightest: f64,
) -> f64 {
    let limits = Limits::new(&rules.fixed);
    let limits = (&limits, rules.opacity);
    let stop = [
        rules.float.stop_below,
        limits.0.stop as f64 * 2f64.powi(-36),
    ];
    // Transmittance in floating point, and in the hardware's formats, least and most.
    let (mut light, mut fixed) = (1.0f64, [1.0f64; 2]);
    // What was collected, and the most with a stop that only one of the two makes.
    let (mut sum, mut worst) = (0.0, 0.0f64);
    let mut drawn = 0.0;
    for splat in splats {
        let Some(alpha) = alpha(&rules.float, splat, at, off, limits) else {
            continue;
        };
        let left = light * (1.0 - alpha.float);
        let least = fixed[0] * (1.0 - alpha.fixed[1]);
        let most = fixed[1] * (1.0 - alpha.fixed[0]);
        let stops =
            alpha.float > 0.0 && (left < stop[0] || (rules.float.stop_at_equal && left <= stop[0]));
        let may_stop = alpha.fixed[1] > 0.0 && least - FLOAT < stop[1];
        let may_go_on = alpha.fixed[0] == 0.0 || most + FLOAT >= stop[1];
        if stops {
            if may_go_on {
                worst = worst.max(sum + fixed[1].max(light) * brightest);
            }
            break;
        }
        if may_stop {
            worst = worst.max(sum + fixed[1].max(light) * brightest);
        }
        let [low, high] = alpha.fixed;
        sum += light * (alpha.float - low).max(high - alpha.float) * brightest;
        // Colours are held at the end of their format.
        let held = (splat.colour.max_element() - COLOUR.value(COLOUR.max())).max(0.0);
        sum += light * alpha.float * held;
        light = left;
        fixed = [
            (least - off.transmittance).max(0.0),
            (most + off.transmittance).min(1.0),
        ];
        drawn += 1.0;
    }
    let rounded = drawn * 2.0 * off.transmittance * brightest;
    // Colours, the background's 12 bits, and both pictures' 32-bit floats.
    let shown = COLOUR.ulp() + brightest * 2f64.powi(-22);
    sum.max(worst) + rounded + shown
}

/// `None` if both frames skip the Gaussian.
fn alpha(
    rules: &Rules,
    splat: &Projected,
    at: [u32; 2],
    off: &RoundingErrors,
    (limits, opacity): (&Limits, SplatOpacity),
) -> Option<Alpha> {
    let centre = |v: u32| f64::from(v) + rules.pixel_centre;
    let [x, y] = [0, 1].map(|a| centre(at[a]) - splat.mean[a]);
    let [l11, l21, l22] = splat.footprint.factor;
    let (p, q) = (l11 * x + l21 * y, l22 * y);
    // A mean that its format does not hold is off by more.
    let limit = MEAN.value(MEAN.max());
    let mean = [0, 1].map(|a| off.mean + (splat.mean[a].abs() - limit).max(0.0));
    let dp = (x.abs() + y.abs() + mean[0] + mean[1]) * off.factor
        + l11.abs() * mean[0]
        + l21.abs() * mean[1]
        + off.form;
    let dq = (y.abs() + mean[1]) * off.factor + l22.abs() * mean[1] + off.form;
    let u = (p * p + q * q) / 2.0;
    let du = p.abs() * dp + q.abs() * dq + (dp * dp + dq * dq) / 2.0 + off.power;
    let exact = splat.opacity * (-u).exp();
    let float = match exact >= rules.alpha_min {
        true => exact.min(rules.alpha_cap),
        false => 0.0,
    };
    let exponentials = |u: f64, du: f64| {
        let most = ((-(u - du).max(0.0)).exp() + off.exponential).min(1.0);
        let least = ((-(u + du)).exp() - off.exponential).max(0.0);
        [least, most]
    };
    let [low, high] = match opacity {
        SplatOpacity::Multiplied => {
            let [least, most] = exponentials(u, du);
            // An opacity that rounds to 1 is held below it.
            let held = off.alpha.max(splat.opacity - OPACITY.value(OPACITY.max()));
            let low = (splat.opacity - held) * least - off.alpha;
            [low, (splat.opacity + off.alpha) * most + off.alpha]
        }
        SplatOpacity::InPower => exponentials(u - splat.opacity.ln(), du + off.log_opacity),
    };
    let cap = f64::from(limits.alpha_cap) * OPACITY.ulp();
    let skip = f64::from(limits.alpha_min) * OPACITY.ulp();
    let [low, high] = [low, high].map(|alpha| alpha.min(cap));
    if high < skip && float == 0.0 {
        return None;
    }
    Some(Alpha {
        float,
        fixed: [
            if low < skip { 0.0 } else { low },
            if high < skip { 0.0 } else { high },
        ],
    })
}

#[cfg(test)]
mod tests;
