//! Tests of the parts of the error bound.
#![allow(clippy::unwrap_used)]

use potamoi_formats::config::{Config, Layer as Toml};
use potamoi_formats::units::{OpCode, VectorOp};
use proptest::prelude::*;
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64Mcg;

use super::{ErrorInterval, Pair, UnitErrors};
use crate::mac::MacMlp;
use crate::opacity::{Curve, Opacity, rescale};
use crate::{Layer, Mlp, softplus};
use potamoi_march::{Lanes, Work};
use potamoi_reference::ReferenceUnits;
use potamoi_reference::bounds::VectorBounds;

fn with_lanes<T>(run: impl FnOnce(&mut Lanes<'_>) -> T) -> T {
    with_lanes_of(&Config::preset("fields").unwrap(), run)
}

fn with_lanes_of<T>(config: &Config, run: impl FnOnce(&mut Lanes<'_>) -> T) -> T {
    let (mut units, mut work) = (ReferenceUnits::new(config), Work::default());
    run(&mut Lanes {
        units: &mut units,
        work: &mut work,
    })
}

/// The opacity that the units compute for a number.
fn opacity_of_units(opacity: &Opacity, code: i32, frac: i32, config: &Config) -> f64 {
    let alpha = with_lanes_of(config, |lanes| {
        opacity.alphas(&[code], frac, lanes).unwrap()
    })[0];
    f64::from(alpha) * 2f64.powi(-(opacity.alpha_bits() as i32))
}

/// The logistic function that the units compute.
fn logistic_of_units(code: i32, frac: i32, config: &Config) -> f64 {
    let exp = &config.vu.exp;
    let found = with_lanes_of(config, |lanes| {
        let operand = rescale(&[code], frac, exp.input.frac_bits(), lanes).unwrap();
        let op = VectorOp::new(OpCode::Sigmoid);
        lanes.compute_with(op, &operand, 0).unwrap()
    })[0];
    f64::from(found) * 2f64.powi(-(exp.output_bits as i32))
}

/// A perceptron of random weights with layers of these widths.
fn perceptron(random: &mut Pcg64Mcg, widths: &[usize], scale: f32) -> Mlp {
    let layers = widths.windows(2).map(|w| {
        let mut list = |n| (0..n).map(|_| random.random_range(-scale..scale)).collect();
        Layer::new(w[0], list(w[0] * w[1]), list(w[1])).unwrap()
    });
    Mlp::new(layers.collect()).unwrap()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// For any weights and widths, with or without saturation: fixed-point outputs are within
    /// their bounds, for inputs with the largest possible errors.
    #[test]
    fn outputs_in_codes_are_where_their_bound_says(
        seed: u64,
        widths in prop::collection::vec(1usize..24, 2..5),
        scale in prop::sample::select(vec![0.05f32, 0.4, 1.5]),
        held in prop::sample::select(vec![0.3f64, 1.0, 4.0]),
        frac in 6i32..13,
        spread in prop::sample::select(vec![0.0f64, 0.5, 6.0]),
    ) {
        let mut random = Pcg64Mcg::seed_from_u64(seed);
        let mlp = perceptron(&mut random, &widths, scale);
        let unit = 2f64.powi(-frac);
        let exact: Vec<f64> = (0..widths[0]).map(|_| random.random_range(-2.0..2.0)).collect();
        let codes: Vec<i16> = exact
            .iter()
            .map(|v| (v / unit + random.random_range(-spread..=spread)).round() as i16)
            .collect();
        // A part of each difference is known.
        let off: Vec<ErrorInterval> = exact
            .iter()
            .zip(&codes)
            .map(|(v, code)| {
                let all = f64::from(*code) * unit - v;
                let known = all * random.random_range(0.0..=1.0);
                ErrorInterval { known, most: (all - known).abs() }
            })
            .collect();
        let mut largest = vec![0f64; mlp.layers().len()];
        let mut values = exact.clone();
        mlp.run_watched(&mut values, |layer, value| {
            largest[layer] = largest[layer].max(value.abs());
        });
        let largest: Vec<f64> = largest.iter().map(|v| v * held + 1e-3).collect();
        // A lone output that is nearly 0 needs a scale beyond those that there are: refused.
        let Ok(made) = MacMlp::quantise(&mlp, frac, &largest) else {
            return Err(TestCaseError::reject("no scale holds a layer"));
        };
        let found = with_lanes(|lanes| made.run(codes.clone(), lanes).unwrap());
        let bound = Pair::new(&mlp, &made).outputs(&exact, &off);
        let of_code = 2f64.powi(-made.output_frac());
        for ((own, value), (exact, off)) in
            found.iter().zip(&values).zip(bound.values.iter().zip(&bound.off))
        {
            prop_assert!((value - exact).abs() <= 1e-9 * (1.0 + exact.abs()), "{value} {exact}");
            let beyond = (f64::from(*own) * of_code - exact - off.known).abs();
            prop_assert!(beyond <= off.most + 1e-9 * (1.0 + exact.abs()), "{beyond} of {off:?}");
        }
    }

    /// Opacities are within their bounds, for every curve.
    #[test]
    fn opacities_are_where_their_bound_says(
        which in 0usize..3,
        number in -18.0f64..18.0,
        shift in -10.0f64..2.0,
        interval in prop::sample::select(vec![3.7e-5, 1.7e-3, 0.02, 0.5, 9.0]),
        known in -0.2f64..0.2,
        most in prop::sample::select(vec![0.0f64, 1e-3, 0.1, 3.0]),
        within in -1.0f64..=1.0,
        frac in 4i32..20,
    ) {
        let config = Config::preset("fields").unwrap();
        let curve = [Curve::Softplus { shift }, Curve::Relu, Curve::Exp][which];
        let opacity = Opacity::new(curve, interval, &config).unwrap();
        let unit = 2f64.powi(-frac);
        let code = ((number + known + within * most) / unit).round() as i32;
        // What the rounding adds is known.
        let known = f64::from(code) * unit - number - within * most;
        let alpha = opacity_of_units(&opacity, code, frac, &config);
        let depth = interval * match curve {
            Curve::Softplus { shift } => softplus(number + shift),
            Curve::Relu => number.max(0.0),
            Curve::Exp => number.exp(),
        };
        let exact = -(-depth).exp_m1();
        let bound = opacity.off(&UnitErrors::of(&config, &VectorBounds::by_formula(&config.vu.exp)), number, ErrorInterval { known, most }, frac);
        prop_assert!((alpha - exact).abs() <= bound, "{alpha} {exact}: {bound}");
    }

    /// Logistic functions are within their bounds.
    #[test]
    fn colours_are_where_their_bound_says(
        logit in -20.0f64..20.0,
        most in prop::sample::select(vec![0.0f64, 1e-3, 0.1, 3.0]),
        within in -1.0f64..=1.0,
        frac in 4i32..20,
    ) {
        let config = Config::preset("fields").unwrap();
        let unit = 2f64.powi(-frac);
        let code = ((logit + within * most) / unit).round() as i32;
        let known = f64::from(code) * unit - logit - within * most;
        let found = logistic_of_units(code, frac, &config);
        let exact = 1.0 / (1.0 + (-logit).exp());
        let bound = UnitErrors::of(&config, &VectorBounds::by_formula(&config.vu.exp)).logistic(logit, ErrorInterval { known, most }, frac);
        prop_assert!((found - exact).abs() <= bound, "{found} {exact}: {bound}");
    }
}

/// With neurons that are certainly active, known errors stay known; a sum of weight magnitudes
/// would lose them.
#[test]
fn what_is_known_of_inputs_stays_known() {
    let mut random = Pcg64Mcg::seed_from_u64(5);
    let mlp = perceptron(&mut random, &[12, 32, 3], 0.4);
    let made = MacMlp::quantise(&mlp, 10, &[8.0, 8.0]).unwrap();
    let pair = Pair::new(&mlp, &made);
    let inputs: Vec<f64> = (0..12).map(|_| random.random_range(-2.0..2.0)).collect();
    let known: Vec<ErrorInterval> = (0..12)
        .map(|_| ErrorInterval::exactly(random.random_range(-4e-3..4e-3)))
        .collect();
    let unknown: Vec<ErrorInterval> = known
        .iter()
        .map(|off| ErrorInterval::within(off.largest()))
        .collect();
    let most = |off: &[ErrorInterval]| {
        let made = pair.outputs(&inputs, off);
        made.off.iter().map(|off| off.most).fold(0.0, f64::max)
    };
    assert!(
        most(&known) < most(&unknown) / 2.0,
        "{} {}",
        most(&known),
        most(&unknown)
    );
}

/// An output just within its range in floating point, and beyond it in fixed point.
#[test]
fn what_is_held_at_the_end_is_off_by_less_than_is_known_of_its_inputs() {
    let layer = Layer::new(1, vec![1.0], vec![0.0]).unwrap();
    let mlp = Mlp::new(vec![layer]).unwrap();
    let made = MacMlp::quantise(&mlp, 14, &[0.99]).unwrap();
    let unit = 2f64.powi(-made.output_frac());
    let end = f64::from(i16::MAX) * unit;
    let (exact, code) = (end - 0.5 * unit, 16_400);
    let off = ErrorInterval::exactly(f64::from(code) * 2f64.powi(-14) - exact);
    let found = with_lanes(|lanes| made.run(vec![code], lanes).unwrap())[0];
    assert_eq!(found, i32::from(i16::MAX));
    let bound = Pair::new(&mlp, &made).outputs(&[exact], &[off]).off[0];
    let beyond = (end - exact - bound.known).abs();
    assert!(beyond <= bound.most, "{beyond} of {bound:?}");
    // What would be known, were it not held, is farther.
    assert!(off.known > 10.0 * (end - exact), "{off:?}");
}

/// For each part of the units' errors, in a case where it is large: nothing exceeds the bound, and
/// something exceeds it without that part.
#[test]
fn each_part_of_the_units_errors_is_needed() {
    // Settings; a curve and an interval, or a logistic function; numbers from and to.
    type Case = (
        &'static str,
        &'static str,
        Option<(Curve, f64)>,
        [f64; 2],
        fn(&mut UnitErrors),
    );
    let softplus_of = Curve::Softplus { shift: -1.0 };
    let cases: [Case; 6] = [
        (
            "power",
            "iterations = 6",
            Some((Curve::Relu, 0.5)),
            [0.0, 4.0],
            |e| e.power = 0.0,
        ),
        (
            "depth",
            "one_minus_frac_bits = 8",
            Some((Curve::Relu, 0.5)),
            [0.0, 4.0],
            |e| e.depth = 0.0,
        ),
        (
            "softplus",
            "iterations = 4",
            Some((softplus_of, 9.0)),
            [-4.0, 0.0],
            |e| e.softplus = 0.0,
        ),
        (
            "operand",
            "input = \"U3.6\"",
            Some((softplus_of, 1.0)),
            [-4.0, 4.0],
            |e| e.operand = 0.0,
        ),
        ("operand", "input = \"U3.6\"", None, [-4.0, 4.0], |e| {
            e.operand = 0.0
        }),
        ("sigmoid", "iterations = 6", None, [-4.0, 4.0], |e| {
            e.sigmoid = 0.0
        }),
    ];
    for (name, knobs, curve, [from, to], leave_out) in cases {
        let toml = format!("[vu.exp]\n{knobs}");
        let layer = Toml {
            derived: &[],
            toml: &toml,
        };
        let config = Config::preset("fields")
            .unwrap()
            .with(&[layer], "test")
            .unwrap();
        let all = UnitErrors::of(&config, &VectorBounds::by_formula(&config.vu.exp));
        let mut without = all;
        leave_out(&mut without);
        let opacity =
            curve.map(|(curve, interval)| Opacity::new(curve, interval, &config).unwrap());
        let frac = 14;
        let off = |errors: &UnitErrors, number: f64| match &opacity {
            Some(opacity) => opacity.off(errors, number, ErrorInterval::default(), frac),
            None => errors.logistic(number, ErrorInterval::default(), frac),
        };
        let (mut beyond, mut most) = (0u32, 0f64);
        for i in 0..20_000 {
            let code = ((from + (to - from) * f64::from(i) / 20_000.0) * 2f64.powi(frac)) as i32;
            let number = f64::from(code) * 2f64.powi(-frac);
            let (found, exact) = match (&opacity, curve) {
                (Some(opacity), Some((curve, interval))) => {
                    let density = match curve {
                        Curve::Softplus { shift } => softplus(number + shift),
                        Curve::Relu => number.max(0.0),
                        Curve::Exp => number.exp(),
                    };
                    let found = opacity_of_units(opacity, code, frac, &config);
                    (found, -(-interval * density).exp_m1())
                }
                _ => (
                    logistic_of_units(code, frac, &config),
                    1.0 / (1.0 + (-number).exp()),
                ),
            };
            let found = (found - exact).abs();
            assert!(
                found <= off(&all, number),
                "{name}: {number} is off by {found}"
            );
            most = most.max(found / off(&all, number));
            beyond += u32::from(found > off(&without, number));
        }
        println!("{name} {curve:?}: {beyond} beyond, {most:.3} of the bound");
        assert!(
            beyond > 0,
            "{name} is not needed: at most {most} of the bound"
        );
    }
}
