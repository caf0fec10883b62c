//! Each scene rendered by the obvious form, in floats, by the twins and by the Verilated units.

use potamoi_base::picture::Picture;
use potamoi_formats::config::Config;
use potamoi_reference::{ReferenceUnits, Units};
use potamoi_rtl::RtlUnits;
use potamoi_splats::{
    FixedFrame, FixedOptions, FloatFrame, FloatOptions, Profile, View, render_fixed, render_float,
};

use potamoi_analysis::hard_cases::pictures::{HardScene, all, camera, render};

/// What is known of a scene's pictures.
pub(crate) struct Measured {
    /// Of the obvious form to the float picture, in dB; none where it is no number.
    pub(crate) naive: Option<f64>,
    /// Of the hardware's formats to the float picture, in dB.
    pub(crate) fixed: f64,
    /// The largest difference of the latter two.
    pub(crate) worst: f64,
    /// What it may be.
    pub(crate) bound: f64,
}

fn in_floats(scene: &HardScene) -> FloatFrame {
    let options = FloatOptions {
        log_decisions: true,
        depth: true,
        ..FloatOptions::default()
    };
    render_float(&scene.cloud().unwrap(), &camera(), Profile::Inria, &options).unwrap()
}

fn through(scene: &HardScene, units: &mut dyn Units) -> FixedFrame {
    let options = FixedOptions {
        log_decisions: true,
        ..FixedOptions::default()
    };
    render_fixed(
        &scene.cloud().unwrap(),
        &camera(),
        Profile::Inria,
        &options,
        units,
    )
    .unwrap()
}

/// dB between pictures; none where one holds a number that is none.
pub(crate) fn psnr(a: &Picture, b: &Picture) -> Option<f64> {
    let finite = |p: &Picture| p.rgb.iter().flatten().all(|v| v.is_finite());
    (finite(a) && finite(b)).then(|| a.psnr(b, |_| true).unwrap())
}

/// How far a pixel may be off: each Gaussian's alpha once in its own weight and once in the light
/// that it lets through, decisions that flip at 1/255 or at the stop, and codes of colours.
///
/// An alpha is off by what its exponent is: p and q by half units of the mean (2^-13 in both axes,
/// times the largest factor, 1 / sqrt 0.3), of the factors (2^-31 each, times the distance from
/// the mean) and their own (2^-17), which a Gaussian passes on by e^-1/2 at most; then half a unit
/// of U3.13, one of the exponential, and half of opacity and product.
fn bound(scene: &HardScene, float: &FloatFrame, fixed: &FixedFrame) -> f64 {
    let view = View::new(&scene.cloud().unwrap(), &camera(), Profile::Inria).unwrap();
    let most = |values: &mut dyn Iterator<Item = f64>| values.fold(0.0, f64::max);
    let splats = view.splats();
    let reach = 2.0 * most(&mut splats.iter().map(|s| s.mean.abs().max_element())) + 64.0;
    let bright = most(&mut splats.iter().map(|s| s.colour.max_element()));
    let root = 2f64.sqrt();
    let vector = root * 2f64.powi(-13) / 0.3f64.sqrt()
        + 3f64.sqrt() * 2f64.powi(-31) * reach
        + root * 2f64.powi(-17);
    let alpha = (-0.5f64).exp() * vector + 2f64.powi(-14) + 2.0 * 2f64.powi(-16);
    // Weights sum to at most 1, so that relative errors of alphas do not add up over layers that
    // are faint: a layer's share is at most its alpha's error, with a transmittance behind it.
    let layers = splats.len() as f64;
    let flips = fixed
        .decisions
        .as_ref()
        .and_then(|d| d.flips(float.decisions.as_ref()?));
    let flips = flips.unwrap();
    let flipped = flips.skip as f64 * (1.0 / 255.0 + alpha) + flips.stop as f64;
    bright * (layers * (2.0 * alpha + 2f64.powi(-21)) + flipped) + 2f64.powi(-12)
}

pub(crate) fn measure(scene: &HardScene) -> Measured {
    let float = in_floats(scene);
    let mut twins = ReferenceUnits::new(&Config::paper());
    let fixed = through(scene, &mut twins);
    assert_eq!(twins.gather_flags(), 0, "{}", scene.name);
    let drawn = float.stats.unwrap().drawn;
    assert!(drawn > 50, "{}: {:?}", scene.name, float.stats);
    let depth = float.depth.as_ref().unwrap();
    assert!(depth.iter().all(|d| *d > 0.0), "{}: a depth", scene.name);
    let values = |f: &Picture| f.rgb.concat();
    let off = values(&fixed.picture)
        .into_iter()
        .zip(values(&float.picture));
    let worst = off.map(|(a, b)| f64::from(a - b).abs());
    // A difference that is no number is none that a maximum may drop.
    let worst = worst.fold(0.0, |most: f64, v| if v <= most { most } else { v });
    Measured {
        naive: psnr(&render(&scene.gaussians, scene.form), &float.picture),
        fixed: psnr(&fixed.picture, &float.picture).expect("finite pictures"),
        worst,
        bound: bound(scene, &float, &fixed),
    }
}

/// The obvious form, ours and 64-bit floats, a scene each.
pub(crate) fn columns() -> Vec<[Picture; 3]> {
    let column = |scene: &HardScene| {
        let fixed = through(scene, &mut ReferenceUnits::new(&Config::paper()));
        [
            render(&scene.gaussians, scene.form),
            fixed.picture,
            in_floats(scene).picture,
        ]
    };
    all().iter().map(column).collect()
}

/// Ours keeps the formats' promise and its bound; the obvious form keeps neither.
#[test]
fn scenes_keep_their_promise_and_the_obvious_form_does_not() {
    for scene in all() {
        let found = measure(&scene);
        let Measured {
            naive,
            fixed,
            worst,
            bound,
        } = found;
        println!(
            "{}: {fixed:.1} dB, naive {naive:?}, {worst:e} of {bound:e}",
            scene.name
        );
        assert!(fixed >= scene.promise, "{}: {fixed} dB", scene.name);
        assert!(worst <= bound, "{}: {worst} > {bound}", scene.name);
        assert!(
            naive.is_none_or(|naive| naive < scene.promise - 10.0),
            "{}: {naive:?} dB: the case does not bite",
            scene.name
        );
    }
}

/// No bit depends on the order of the file, ties or not.
#[test]
fn any_order_of_the_file_gives_the_same_pictures() {
    for scene in all() {
        let mut other = HardScene {
            gaussians: scene.gaussians.clone(),
            ..scene
        };
        other.gaussians.reverse();
        let n = other.gaussians.len();
        other.gaussians.rotate_left(n / 3);
        assert_eq!(in_floats(&other), in_floats(&scene), "{}", scene.name);
        let [a, b] =
            [&other, &scene].map(|s| through(s, &mut ReferenceUnits::new(&Config::paper())));
        assert_eq!(a, b, "{}", scene.name);
    }
}

/// The Verilated units give the twins' pictures, bit by bit, without raising a flag.
#[test]
fn the_hardware_renders_the_same_pictures() {
    let config = Config::paper();
    let mut rtl = RtlUnits::new(&config);
    for scene in all() {
        let found = through(&scene, &mut rtl);
        assert_eq!(
            found,
            through(&scene, &mut ReferenceUnits::new(&config)),
            "{}",
            scene.name
        );
        assert_eq!(rtl.gather_flags(), 0, "{}", scene.name);
    }
    assert!(rtl.counts().feature_vectors > 100);
}
