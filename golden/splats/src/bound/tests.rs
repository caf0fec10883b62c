#![allow(clippy::unwrap_used)]

use glam::{DVec2, DVec3};
use potamoi_formats::config::{Config, Layer, SplatOpacity};
use potamoi_formats::fixed::Rounding;
use potamoi_formats::units::{OpCode, VectorOp};
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64Mcg;

use super::{Alpha, Limits, Projected, RoundingErrors, alpha};

use crate::profile::Profile;
use crate::records::{RecordForm, record};
use crate::{Footprint, Saturations};
use potamoi_reference::bounds::VectorBounds;
use potamoi_reference::splat_unit::Forms;
use potamoi_reference::{ReferenceUnits, Units};

fn with(toml: &str) -> Config {
    let layer = Layer { derived: &[], toml };
    Config::paper().with(&[layer], "test").unwrap()
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

/// The alpha that the units compute, before cap and skip.
fn alpha_of_units(
    splat: &Projected,
    form: RecordForm,
    config: &Config,
    twins: &mut ReferenceUnits,
) -> f64 {
    let record = record(splat, 0, form, &mut Saturations::default());
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
    let opacity = i32::from(record.opacity);
    if form.opacity == SplatOpacity::InPower {
        let sum = (power + opacity).min((1 << exp.input.width()) - 1);
        let alpha = run(OpCode::Exp, 0, sum, 0);
        return f64::from(alpha) * 2f64.powi(-(exp.output_bits as i32));
    }
    let exponential = run(OpCode::Exp, 0, power, 0);
    f64::from(run(OpCode::Multiply, exp.output_bits, opacity, exponential)) / 65536.0
}

/// For each part of an alpha's bound, in a case where it is large: no alpha exceeds the bound, and
/// some exceed it without that part.
#[test]
fn each_part_of_an_alphas_bound_is_needed() {
    type Part = fn(&mut RoundingErrors);
    let cases: [(&str, &str, u32, f64, bool, Part); 7] = [
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
        (
            "logarithm of the opacity",
            "output_bits = 20\nconstant_bits = 24",
            30,
            0.01,
            true,
            |off| off.log_opacity = 0.0,
        ),
    ];
    for (name, knobs, conic_bits, size, round, leave_out) in cases {
        let config = with(&format!("[vu.exp]\n{knobs}"));
        let opacity = match name {
            "logarithm of the opacity" => SplatOpacity::InPower,
            _ => SplatOpacity::Multiplied,
        };
        let rules = crate::profile::Rules {
            conic_bits,
            alpha_min: 1e-3,
            ..Profile::Gsplat.rules()
        };
        let powers = VectorBounds::by_formula(&config.vu.exp);
        let off = RoundingErrors::of(&rules, &config.vu.exp, &powers);
        let mut without = off;
        leave_out(&mut without);
        let limits = Limits::new(&rules);
        let mut twins = ReferenceUnits::new(&config);
        let mut random = Pcg64Mcg::seed_from_u64(7);
        let (mut beyond, mut most) = (0u32, 0f64);
        for _ in 0..200_000 {
            let splat = any_splat(&mut random, size, round);
            let at = |off: &RoundingErrors| alpha(&rules, &splat, [8, 8], off, (&limits, opacity));
            let Some(Alpha { float, fixed }) = at(&off) else {
                continue;
            };
            if fixed[0] == 0.0 || float == rules.alpha_cap {
                continue;
            }
            let form = RecordForm {
                conic_bits,
                opacity,
            };
            let found = alpha_of_units(&splat, form, &config, &mut twins);
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
