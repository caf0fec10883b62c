//! Derived error bounds of fields in fixed point, against measured errors.

use potamoi_base::picture::Picture;
use potamoi_base::precision::Precision;
use potamoi_formats::config::Config;
use potamoi_reference::ReferenceUnits;
use potamoi_reference::bounds::VectorBounds;
use potamoi_scene::Scene;

use crate::fields_common::{config, scene};

/// Every kind of field: built in, and as other programs wrote them (tools/torch-fixtures,
/// tools/ngp-fixtures).
const SCENES: [&str; 10] = [
    "cairn:dvgo",
    "mist:dvgo",
    "cairn:tensorf",
    "cairn:ngp",
    "cairn:efficientnerf",
    "tensorf/tiny.th",
    "ngp/cube.ingp",
    "ngp/cascades.ingp",
    "mist:ngp",
    "cairn:compact",
];

/// Pictures in floating point and in a configuration's formats.
fn shown(scene: &Scene, config: &Config) -> [Picture; 2] {
    let float = scene.render_float().unwrap().picture;
    let fixed = scene.render_fixed(config, &mut ReferenceUnits::new(config));
    [float, fixed.unwrap().picture]
}

/// The largest error of a channel, the largest bound, and the largest ratio of a pixel's error to
/// its bound, for bounds of a configuration and pictures that need not be its own.
fn used(scene: &Scene, bounded: &Config, [float, fixed]: &[Picture; 2]) -> [f64; 3] {
    let bounds = scene.error_bounds(bounded).unwrap().unwrap();
    let mut most = [0f64; 3];
    for ((a, b), bound) in fixed.rgb.iter().zip(&float.rgb).zip(&bounds) {
        let channels = a.iter().zip(b);
        let off = channels.map(|(a, b)| f64::from((a - b).abs()));
        let off = off.fold(0.0, f64::max);
        most = [
            most[0].max(off),
            most[1].max(*bound),
            most[2].max(off / bound),
        ];
    }
    most
}

/// No pixel exceeds its bound, which is at most a hundred times the measured error and less than
/// the range of colours.
#[test]
fn pixels_keep_to_their_bounds() {
    for name in SCENES {
        let scene = scene(name, 12);
        let own = config("");
        let [off, bound, part] = used(&scene, &own, &shown(&scene, &own));
        println!("{name}: {off:.5} off, {bound:.5} bounded, {part:.3} of it");
        assert!(part <= 1.0, "{name}: {part}");
        assert!(bound < 0.1 && part > 0.01, "{name}: {bound} {part}");
    }
}

/// Coarser formats have larger bounds, keep them, and exceed those of finer ones.
#[test]
fn coarser_formats_are_told_from_finer_ones() {
    let fine = config("");
    for (name, text) in [
        ("cairn:dvgo", "[gu]\nweight_bits = 4"),
        ("cairn:ngp", "[gu]\nweight_bits = 4"),
        ("tensorf/tiny.th", "[gu]\nfeature_bits = 8"),
        ("cairn:efficientnerf", "[gu]\nfeature_bits = 8"),
        ("cairn:compact", "[gu]\nweight_bits = 4"),
    ] {
        let scene = scene(name, 16);
        let coarse = config(text);
        let pictures = shown(&scene, &coarse);
        let [_, bound, part] = used(&scene, &coarse, &pictures);
        assert!(part <= 1.0, "{name}: {part}");
        let [_, finer, beyond] = used(&scene, &fine, &pictures);
        println!("{name}: {bound:.4} and {finer:.4} bounded, {beyond:.2} of the finer one's");
        assert!(
            beyond > 1.0 && bound > finer,
            "{name}: {beyond} {bound} {finer}"
        );
    }
}

/// If one of the two stops at a much higher transmittance, its pixels keep a bound that includes
/// both, and exceed the bound of equal thresholds.
#[test]
fn rays_that_stop_elsewhere_are_in_the_bound() {
    let own = config("");
    let powers = VectorBounds::by_formula(&own.vu.exp);
    for name in [
        "cairn:dvgo",
        "cairn:tensorf",
        "cairn:ngp",
        "cairn:efficientnerf",
    ] {
        let rules = scene(name, 12);
        let mut sooner = rules.clone();
        let precision = Precision {
            stop_below: Some(0.3),
            ..Precision::default()
        };
        sooner.set_precision(precision).unwrap();
        let alike = rules.error_bounds(&own).unwrap().unwrap();
        for [fixed, float] in [[&sooner, &rules], [&rules, &sooner]] {
            let shown = fixed
                .render_fixed(&own, &mut ReferenceUnits::new(&own))
                .unwrap();
            let float_picture = float.render_float().unwrap().picture;
            let beside = fixed.error_bounds_beside(&own, float.precision(), &powers);
            let beside = beside.unwrap().unwrap();
            let mut left = 0;
            for (i, (a, b)) in shown.picture.rgb.iter().zip(&float_picture.rgb).enumerate() {
                let channels = a.iter().zip(b).map(|(a, b)| f64::from((a - b).abs()));
                let off = channels.fold(0.0, f64::max);
                assert!(off <= beside[i], "{name}: {off} {}", beside[i]);
                left += u32::from(off > alike[i]);
            }
            assert!(left > 0, "{name}");
        }
    }
}
