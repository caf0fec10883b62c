//! Error bounds of the fixed-point renderer of voxel grids.

use super::field::StoredField;
use super::formats::Formats;
use crate::FixedOptions;
use crate::volume::Ray;
use potamoi_base::camera::Camera;
use potamoi_march::BACKGROUND;
use potamoi_reference::bounds::VectorBounds;

/// Upper bound of an opacity's error, if the density is off only by its format.
#[must_use]
pub fn opacity_off(formats: &Formats, powers: &VectorBounds, step: f64) -> f64 {
    let unit = powers.one_minus_exp * formats.alpha.ulp();
    step * formats.density.ulp() + formats.depth.ulp() + unit
}

/// Upper bounds of the errors of each pixel's colour and transmittance.
///
/// A feature is off by half a unit where it is coded and half a unit where it leaves the gathering
/// unit; by half of `sum |dw|` times the range in its cell, where `1 + 2 + 4` splits that are off
/// by 2^-W / 2 on both sides make `sum |dw|` at most 7 x 2^-W; and by 2^-13 of its slope along
/// each axis, where its position is rounded. An opacity is off by as much as its optical depth,
/// and by its unit's error. The picture is affine in each opacity. Replacing one opacity, with
/// those behind it replaced already, changes the picture by the transmittance in front of it,
/// times the difference, times at most the brightest colour.
///
/// Where rays stop, each renderer leaves out at most the transmittance of its threshold: the larger
/// of the two is `stop`.
#[must_use]
pub fn error_bounds(
    field: &StoredField,
    formats: &Formats,
    powers: &VectorBounds,
    camera: &Camera,
    options: &FixedOptions,
    stop: f64,
) -> Vec<[f64; 2]> {
    let (grid, step) = (&*field.grid, field.step);
    let ranges = field.ranges();
    let channels = grid.layout().channels();
    let off = |c: usize| ranges.off(formats, c);
    let interpolated = off(0) - formats.density.ulp();
    let alpha_off = opacity_off(formats, powers, step) + step * interpolated;
    let behind = options
        .background
        .iter()
        .fold(0.0, |m, v| f64::max(m, f64::from(*v)));
    let cut_off = if options.terminate { stop } else { 0.0 };
    let n = grid.layout().coefficients();
    let largest = &ranges.largest;
    let span = match n > 1 || ranges.is_negative[1..].contains(&true) {
        true => 2.0,
        false => 1.0,
    };
    let mut out = Vec::new();
    for y in 0..camera.height {
        for x in 0..camera.width {
            let (_, d) = camera.ray(x, y);
            let ray = Ray::new(grid.points(), grid.to_grid(camera.position()), d, step);
            let basis = [1.0, d.x.abs(), d.y.abs(), d.z.abs()];
            let (mut brightest, mut colour_off) = (behind, BACKGROUND.ulp() / 2.0);
            for c in 0..3 {
                let of = |f: &dyn Fn(usize) -> f64| -> f64 {
                    (0..n).map(|i| basis[i] * f(1 + c * n + i)).sum()
                };
                brightest = brightest.max(of(&|i| largest[i]));
                // Directions have 14 fraction bits; their sum is rounded once.
                let turned: f64 = (1..n).map(|i| largest[1 + c * n + i]).sum();
                let rounded = if n == 1 {
                    0.0
                } else {
                    formats.colour.ulp() / 2.0
                };
                colour_off = colour_off.max(of(&off) + turned * 2f64.powi(-15) + rounded);
            }
            let (mut left, mut reach, mut seen) = (1.0, 0.0, 0.0);
            let mut values = vec![0.0; channels];
            for k in 0..ray.samples {
                grid.sample(ray.at(k), &mut values);
                if values[0] + off(0) <= 0.0 {
                    continue;
                }
                reach += left * alpha_off;
                seen += 1.0;
                left *= (-values[0].max(0.0) * step).exp();
            }
            let rounding = seen * 2f64.powi(-(options.transmittance_bits as i32));
            let products = seen * 2f64.powi(-1 - formats.pixel_bits() as i32);
            let written = 2.0 * brightest * 2f64.powi(-24);
            let apart = reach + rounding + cut_off;
            // Both pictures lie between the darkest and the brightest.
            let moved = (brightest * apart + colour_off).min(span * brightest + colour_off);
            out.push([moved + products + written, apart.min(1.0)]);
        }
    }
    out
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use potamoi_formats::config::Config;
    use potamoi_formats::rit::{RitEntry, Vertices};
    use rand::{Rng, SeedableRng};
    use rand_pcg::Pcg64Mcg;

    use super::super::formats::code;
    use super::super::grid::{Grid, Layout};
    use super::super::ranges::Ranges;
    use super::*;
    use glam::DVec3;
    use potamoi_reference::GatherTask;
    use potamoi_reference::exponential::ReferenceExponential;
    use potamoi_reference::gathering_unit::ReferenceGatheringUnit;
    use potamoi_reference::weights::trilinear;

    fn config(text: &str) -> Config {
        Config::from_toml(text, "test").unwrap()
    }

    /// For densities in which each part of the bound dominates in turn, no opacity exceeds its
    /// bound, and the largest error nearly reaches it.
    #[test]
    fn opacities_are_off_by_what_they_may_be_and_hardly_less() {
        let grid = Grid::bake([2; 3], DVec3::ZERO, 1.0, Layout::Constant, |_, out| {
            out.copy_from_slice(&[3.0, 1.0, 1.0, 1.0]);
        })
        .unwrap();
        for (text, least) in [
            ("", 0.25),
            ("[gu]\nfeature_bits = 8", 0.4),
            ("[vu.exp]\niterations = 6", 0.5),
            ("[vu.exp]\none_minus_frac_bits = 10", 0.5),
        ] {
            let config = config(text);
            let formats = Formats::new(&grid, &config).unwrap();
            let twin = ReferenceExponential::new(&config.vu.exp);
            let step = 0.5;
            let off = |i: i32| {
                let density = 3.0 * f64::from(i) / 20_000.0;
                let code = i64::from(code(formats.density, density as f32));
                let depth = (code * i64::from(Formats::step_code(step))) >> formats.depth_shift();
                let alpha = f64::from(twin.one_minus_exp(depth as i32)) * formats.alpha.ulp();
                (alpha + (-density * step).exp_m1()).abs()
            };
            let most = (0..=20_000).map(off).fold(0.0, f64::max);
            let part =
                most / opacity_off(&formats, &VectorBounds::by_formula(&config.vu.exp), step);
            println!("{text:?}: {part:.3} of the bound");
            assert!((least..=1.0).contains(&part), "{text:?}: {part}");
        }
    }

    /// For gathered features with extreme cells and few bits of weights or codes in turn, no
    /// feature exceeds its bound, and the largest error nearly reaches it.
    #[test]
    fn gathered_features_are_off_by_what_they_may_be_and_hardly_less() {
        let mut random = Pcg64Mcg::seed_from_u64(5);
        for (text, least) in [
            ("", 0.25),
            ("[gu]\nweight_bits = 6", 0.25),
            ("[gu]\nfeature_bits = 8", 0.25),
        ] {
            let config = config(text);
            let twin = ReferenceGatheringUnit::new(&config);
            let mut most = 0f64;
            for _ in 0..400 {
                let corners: [f32; 8] =
                    std::array::from_fn(|_| [-1.0, 0.3, 1.0][random.random_range(0..3)]);
                let grid = Grid::bake([2; 3], DVec3::ZERO, 1.0, Layout::Constant, |at, out| {
                    let corner = at.x as usize + 2 * (at.y as usize) + 4 * (at.z as usize);
                    out.fill(corners[corner]);
                })
                .unwrap();
                let formats = Formats::new(&grid, &config).unwrap();
                let bound = Ranges::new(&grid).off(&formats, 1);
                for _ in 0..200 {
                    let at = DVec3::from_array(random.random());
                    let fraction = (at * 4096.0).round().to_array().map(|v| v as u16);
                    let task = GatherTask {
                        vertices: Vertices::Eight,
                        channels: 1,
                        rows: corners.map(|v| code(formats.colour, v)).to_vec(),
                        entries: vec![RitEntry {
                            slot: 0,
                            rows: [0, 1, 2, 3, 4, 5, 6, 7],
                            weights: trilinear(fraction, config.gu.weight_bits),
                        }],
                    };
                    let mut features = vec![];
                    twin.gather(&task, &mut features).unwrap();
                    let mut exact = [0.0; 4];
                    grid.sample(at, &mut exact);
                    let found = f64::from(features[0]) * formats.colour.ulp();
                    most = most.max((found - exact[1]).abs() / bound);
                }
            }
            println!("{text:?}: {most:.3} of the bound");
            assert!((least..=1.0).contains(&most), "{text:?}: {most}");
        }
    }
}
