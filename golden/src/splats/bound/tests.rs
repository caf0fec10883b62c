#![allow(clippy::unwrap_used)]

use glam::{DVec2, DVec3};
use potamoi_formats::config::{Config, Layer};
use potamoi_formats::fixed::Rounding;
use potamoi_formats::units::{OpCode, VectorOp};
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64Mcg;

use super::{Alpha, Limits, Off, Projected, alpha};

use crate::effects::{Choices, Effect};
use crate::precision::Precision;
use crate::scene::Scene;
use crate::splats::array::Forms;
use crate::splats::profile::Profile;
use crate::splats::records::record;
use crate::splats::{Footprint, Saturations};
use crate::units::bounds::VectorBounds;
use crate::units::{Twins, Units};

/// Largest part of its bound that a pixel takes, and the bounds' mean square, of bounds and a
/// picture each of its scene and configuration.
fn used(bounded: (&Scene, &Config), shown: (&Scene, &Config)) -> (f64, f64) {
    let bounds = bounded.0.error_bounds(bounded.1).unwrap().unwrap();
    let mut without = bounded.0.clone();
    without.set_choices(Choices::default().leave_out(Effect::Exponential));
    assert_eq!(without.error_bounds(bounded.1).unwrap(), None);
    let float = bounded.0.render_float().unwrap().picture;
    let (scene, config) = shown;
    let mut twins = Twins::new(config);
    let fixed = scene.render_fixed(config, &mut twins).unwrap().picture;
    let off = |i: usize| {
        let both = fixed.rgb[i].iter().zip(float.rgb[i]);
        both.fold(0.0, |m, (a, b)| {
            f64::max(m, (f64::from(*a) - f64::from(b)).abs())
        })
    };
    let most = (0..bounds.len())
        .map(|i| off(i) / bounds[i])
        .fold(0.0, f64::max);
    let squares: f64 = bounds.iter().map(|b| b * b).sum();
    (most, squares / bounds.len() as f64)
}

fn with(toml: &str) -> Config {
    let layer = Layer { derived: &[], toml };
    Config::paper().with(&[layer], "test").unwrap()
}

/// Every form of the exponential, seen from far and from within; the bound is no more than a
/// few hundred times what is measured, and tells a coarser unit.
#[test]
fn no_pixel_is_farther_off_than_its_bound() {
    let configs = [
        Config::paper(),
        with("[vu.exp]\niterations = 8"),
        with("[vu.exp]\niterations = 9\ntail = true"),
        with("[vu.exp]\nearly_out = true"),
        with("[vu.exp]\nform = \"piecewise\"\npipelined = true"),
        with("[vu.exp]\noutput_bits = 12"),
        with("[vu.exp]\ninput = \"U3.10\""),
    ];
    for name in ["garden", "cairn:splats"] {
        let mut scene = Scene::open(name).unwrap();
        scene.set_size(Some(48), Some(40)).unwrap();
        for config in &configs {
            let (most, squares) = used((&scene, config), (&scene, config));
            println!(
                "{name}: {most:.4} of the bound, {:.1} dB",
                -10.0 * squares.log10()
            );
            assert!(most <= 1.0 && most > 1e-3, "{name}: {most}");
        }
    }
    let mut scene = Scene::open("garden").unwrap();
    scene.set_size(Some(48), Some(40)).unwrap();
    let coarse = with("[vu.exp]\niterations = 4");
    let (most, _) = used((&scene, &configs[0]), (&scene, &coarse));
    assert!(most > 1.0, "{most}");
}

/// Coarser transmittances and conics have larger bounds, hold them, and exceed those of finer
/// ones.
#[test]
fn coarser_widths_are_told_from_finer_ones() {
    let mut scene = Scene::open("garden").unwrap();
    scene.set_size(Some(48), Some(40)).unwrap();
    let config = Config::paper();
    let transmittance = Precision {
        transmittance_bits: Some(8),
        ..Precision::default()
    };
    let conic = Precision {
        conic_bits: Some(8),
        ..Precision::default()
    };
    for precision in [transmittance, conic] {
        let mut coarse = scene.clone();
        coarse.set_precision(precision).unwrap();
        let (own, _) = used((&coarse, &config), (&coarse, &config));
        assert!(own <= 1.0, "{precision:?}: {own}");
        let (of_finer, _) = used((&scene, &config), (&coarse, &config));
        assert!(of_finer > 1.0, "{precision:?}: {of_finer}");
    }
}

/// Beside a picture by the rules, frames that stop sooner or leave more out keep to bounds of
/// their own, and exceed those of frames by the rules.
#[test]
fn sooner_stops_and_fainter_gaussians_have_bounds() {
    let mut scene = Scene::open("garden").unwrap();
    scene.set_size(Some(48), Some(40)).unwrap();
    let config = Config::paper();
    let float = scene.render_float().unwrap().picture;
    let plain = scene.error_bounds(&config).unwrap().unwrap();
    for (stop_below, alpha_min) in [
        (Some(0.05), None),
        (Some(0.3), None),
        (Some(1e-6), None),
        (None, Some(0.05)),
        (None, Some(4e-4)),
        (Some(0.02), Some(0.02)),
    ] {
        let precision = Precision {
            stop_below,
            alpha_min,
            ..Precision::default()
        };
        let mut own = scene.clone();
        own.set_precision(precision).unwrap();
        let powers = VectorBounds::by_formula(&config.vu.exp);
        let bounds = own.error_bounds_beside(&config, scene.precision(), &powers);
        let bounds = bounds.unwrap().unwrap();
        let fixed = own.render_fixed(&config, &mut Twins::new(&config));
        let fixed = fixed.unwrap().picture;
        let most = |bounds: &[f64]| {
            let pixels = fixed.rgb.iter().zip(&float.rgb).zip(bounds);
            let parts = pixels.flat_map(|((a, b), bound)| {
                [0, 1, 2].map(|c| f64::from(a[c] - b[c]).abs() / bound)
            });
            parts.fold(0.0, f64::max)
        };
        let (own, plain) = (most(&bounds), most(&plain));
        println!("{precision:?}: {own:.4} of the bound, {plain:.4} of that of the rules");
        assert!(own <= 1.0, "{precision:?}: {own}");
        assert!(plain > 1.0, "{precision:?}: {plain}");
    }
}

/// A Gaussian whose factors are about this, near a pixel; `round`: formats hold its mean, factors
/// and opacity.
fn any_splat(random: &mut Pcg64Mcg, size: f64, round: bool) -> Projected {
    let mut any = |from: f64, to: f64| random.random_range(from..to);
    let mut factor = [any(0.3, 1.8), any(-0.5, 0.5), any(0.3, 1.8)].map(|v| v * size);
    let mut mean = [any(-1.5, 1.5), any(-1.5, 1.5)].map(|v| v / size + 8.5);
    if round {
        mean = mean.map(|v| (v * 4096.0).round() / 4096.0);
        factor = factor.map(|v| (v * 65536.0).round() / 65536.0);
    }
    Projected {
        index: 0,
        depth: 1.0,
        mean: DVec2::from(mean),
        footprint: Footprint {
            covariance: [1.0, 0.0, 1.0],
            determinant: 1.0,
            undilated: 0.0,
            factor,
        },
        opacity: any(0.5, 0.99),
        colour: DVec3::ONE,
    }
}

/// What the units make of an alpha, before cap and skip.
fn alpha_of_units(splat: &Projected, conic_bits: u32, config: &Config, twins: &mut Twins) -> f64 {
    let record = record(splat, 0, conic_bits, &mut Saturations::default());
    let half = 1 << 11;
    let [p, q] = Forms::new(&record, [half, half]).at(8, 8);
    let exp = &config.vu.exp;
    let mut run = |code, shift: u32, a: i32, b: i32| {
        let op = VectorOp {
            code,
            shift: shift as u8,
            rounding: Rounding::HalfUp,
        };
        let mut out = [0];
        twins.vector(op, &[a], &[b], &mut out).unwrap();
        out[0]
    };
    let power = run(OpCode::SquareSum, 33 - exp.input.frac_bits(), p, q);
    let exponential = run(OpCode::Exp, 0, power, 0);
    let opacity = i32::from(record.opacity);
    f64::from(run(OpCode::Multiply, exp.output_bits, opacity, exponential)) / 65536.0
}

/// Each part of an alpha's bound where it is a large one: no alpha is beyond the bound, and some
/// are beyond it without that part.
#[test]
fn each_part_of_an_alphas_bound_is_needed() {
    type Part = fn(&mut Off);
    let cases: [(&str, &str, u32, f64, bool, Part); 6] = [
        ("factor", "", 10, 0.3, false, |off| off.factor = 0.0),
        ("mean", "", 30, 1.0, false, |off| off.mean = 0.0),
        (
            "form",
            "input = \"U3.17\"\noutput_bits = 20\niterations = 27",
            30,
            0.01,
            true,
            |off| off.form = 0.0,
        ),
        ("power", "input = \"U3.6\"", 30, 0.3, false, |off| {
            off.power = 0.0
        }),
        ("exponential", "iterations = 6", 30, 0.3, false, |off| {
            off.exponential = 0.0
        }),
        (
            "alpha",
            "input = \"U3.17\"\noutput_bits = 20\niterations = 27",
            30,
            0.01,
            true,
            |off| off.alpha = 0.0,
        ),
    ];
    for (name, knobs, conic_bits, size, round, leave_out) in cases {
        let config = with(&format!("[vu.exp]\n{knobs}"));
        let rules = crate::splats::profile::Rules {
            conic_bits,
            alpha_min: 1e-3,
            ..Profile::Gsplat.rules()
        };
        let powers = VectorBounds::by_formula(&config.vu.exp);
        let off = Off::of(&rules, &config.vu.exp, &powers);
        let mut without = off;
        leave_out(&mut without);
        let limits = Limits::new(&rules);
        let mut twins = Twins::new(&config);
        let mut random = Pcg64Mcg::seed_from_u64(7);
        let (mut beyond, mut most) = (0u32, 0f64);
        for _ in 0..200_000 {
            let splat = any_splat(&mut random, size, round);
            let at = |off: &Off| alpha(&rules, &splat, [8, 8], off, &limits);
            let Some(Alpha { float, fixed }) = at(&off) else {
                continue;
            };
            if fixed[0] == 0.0 || float == rules.alpha_cap {
                continue;
            }
            let found = alpha_of_units(&splat, conic_bits, &config, &mut twins);
            assert!(
                (fixed[0]..=fixed[1]).contains(&found.min(rules.alpha_cap)),
                "{name}: {found} beside {float}, bound {fixed:?}, of {splat:?}"
            );
            let side = if found > float {
                fixed[1] - float
            } else {
                float - fixed[0]
            };
            most = most.max((found - float).abs() / side);
            let less = at(&without).map_or([0.0; 2], |less| less.fixed);
            beyond += u32::from(!(less[0]..=less[1]).contains(&found));
        }
        println!("{name}: {beyond} beyond, {most:.3} of the bound");
        assert!(
            beyond > 0,
            "{name} is not needed: at most {most} of the bound"
        );
    }
}
