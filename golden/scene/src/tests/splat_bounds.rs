//! Bounds of splats' errors, on whole frames.

use potamoi_formats::config::{Config, Layer};

use crate::Scene;
use potamoi_base::effects::{Choices, Effect};
use potamoi_base::precision::Precision;
use potamoi_reference::ReferenceUnits;
use potamoi_reference::bounds::VectorBounds;

/// Largest part of its bound that a pixel takes, and the bounds' mean square, of bounds and a
/// picture each of its scene and configuration.
fn used(bounded: (&Scene, &Config), shown: (&Scene, &Config)) -> (f64, f64) {
    let bounds = bounded.0.error_bounds(bounded.1).unwrap().unwrap();
    let mut without = bounded.0.clone();
    without.set_choices(Choices::default().leave_out(Effect::Exponential));
    assert_eq!(without.error_bounds(bounded.1).unwrap(), None);
    let float = bounded.0.render_float().unwrap().picture;
    let (scene, config) = shown;
    let mut twins = ReferenceUnits::new(config);
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

/// Seen from far and from within; the bound tells a coarser unit.
#[test]
fn no_pixel_is_farther_off_than_its_bound() {
    let configs = [Config::paper(), with("[vu.exp]\ninput = \"U3.10\"")];
    pixels_keep_to_their_bounds(&configs);
    let mut scene = crate::tests::opened("garden");
    scene.set_size(Some(20), Some(17)).unwrap();
    let coarse = with("[vu.exp]\niterations = 4");
    let (most, _) = used((&scene, &configs[0]), (&scene, &coarse));
    assert!(most > 1.0, "{most}");
}

#[test]
#[ignore = "exhaustive; run with make test-full"]
fn no_pixel_is_farther_off_by_any_exponential() {
    pixels_keep_to_their_bounds(&[
        with("[vu.exp]\niterations = 8"),
        with("[vu.exp]\niterations = 9\ntail = true"),
        with("[vu.exp]\nearly_out = true"),
        with("[vu.exp]\nform = \"piecewise\"\npipelined = true"),
        with("[vu.exp]\noutput_bits = 12"),
    ]);
}

/// The bound is no more than a few hundred times what is measured.
fn pixels_keep_to_their_bounds(configs: &[Config]) {
    for name in ["garden", "cairn:splats"] {
        let mut scene = crate::tests::opened(name);
        scene.set_size(Some(20), Some(17)).unwrap();
        for config in configs {
            let (most, squares) = used((&scene, config), (&scene, config));
            println!(
                "{name}: {most:.4} of the bound, {:.1} dB",
                -10.0 * squares.log10()
            );
            assert!(most <= 1.0 && most > 1e-3, "{name}: {most}");
        }
    }
}

/// Coarser transmittances and conics have larger bounds, hold them, and exceed those of finer
/// ones.
#[test]
fn coarser_widths_are_told_from_finer_ones() {
    let mut scene = crate::tests::opened("garden");
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
    let mut scene = crate::tests::opened("garden");
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
        let fixed = own.render_fixed(&config, &mut ReferenceUnits::new(&config));
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
