//! Opacities of thin air: `1 - exp(-s)` where `exp` is nearly 1.

use glam::DVec3;
use potamoi_formats::config::Config;
use potamoi_formats::units::OpCode;

use super::exact::exact;
use super::exponential::ulp;
use super::{Case, Measuring, Stop, Worst, cases, codes_of_powers, computes};
use potamoi_base::camera::Camera;
use potamoi_fields::render_float;
use potamoi_fields::voxels::{Grid, Layout, StoredField};
use potamoi_reference::bounds::VectorBounds;
use potamoi_reference::exponential::ReferenceExponential;

cases! {
    "fog";
    thin_fog_in_floats, "1 - exp(-s) down to s = 1e-30, in floats", "";
    thin_fog_in_codes, "1 - exp(-s) in codes, 0 among them", "";
}

/// A picture of one pixel, straight along z through white fog of one density.
fn through_fog(density: f32) -> Result<(f64, u64), Stop> {
    let grid = Grid::bake([2, 2, 40], DVec3::ZERO, 1.0, Layout::Constant, |_, out| {
        out.copy_from_slice(&[density, 1.0, 1.0, 1.0]);
    });
    let eye = DVec3::new(0.5, 0.5, -5.0);
    let camera = Camera::look_at(eye, eye + DVec3::Z, DVec3::Y, 0.1, 1, 1);
    let field = StoredField::new(grid?, 1.0);
    let frame = render_float(&field, &camera, [0.0; 3])?;
    Ok((f64::from(frame.picture.rgb[0][0]), frame.samples))
}

fn thin_fog_in_floats(_: &Config) -> Measuring {
    let (mut fails, mut ours) = (Worst::default(), Worst::default());
    for density in [1e-4f32, 1e-6, 1e-8, 1e-12, 1e-20, 1e-30] {
        let (found, samples) = through_fog(density)?;
        let s = exact(f64::from(density));
        let all = exact(1.0) - (exact(0.0) - s * exact(samples as f64)).exp();
        ours.see(all.relative(found));
        let (mut colour, mut left) = (0f32, 1f32);
        for _ in 0..samples {
            let alpha = 1.0 - (-density).exp();
            colour += left * alpha;
            left *= 1.0 - alpha;
        }
        fails.see(all.relative(f64::from(colour)));
    }
    Ok(Case {
        naive: "1 less the exponential, in 32 bits".into(),
        unit: "relative".into(),
        fails,
        // 40 sums and a picture of 32 bits.
        bound: 2f64.powi(-24) + 200.0 * 2f64.powi(-53),
        from: "half a unit of the picture's 32-bit floats".into(),
        ours,
    })
}

fn thin_fog_in_codes(under: &Config) -> Measuring {
    let exp = codes_of_powers(under)?;
    computes(under, OpCode::OneMinusExp)?;
    super::base_e(exp)?;
    let twin = ReferenceExponential::new(exp);
    let (bits, own) = (exp.one_minus_frac_bits, exp.input.frac_bits());
    let whole = 1 << exp.output_bits;
    let one = f64::from(whole);
    let exact = |a: i32| -(-f64::from(a) * 2f64.powi(-(bits as i32))).exp_m1() * one;
    let codes = || (0..1 << 15).chain((1 << 15..16 << bits).step_by(997));
    // The operand in the exponential's own format, and what it gives for 0.
    let naive = |a: i32| {
        let same = 2f64.powi(own as i32 - bits as i32);
        whole - twin.exp((f64::from(a) * same + 0.5).floor() as i32)
    };
    let off = |f: &dyn Fn(i32) -> i32| Worst::of(codes().map(|a| f64::from(f(a)) - exact(a)));
    Ok(Case {
        naive: "1 less the exponential's result".into(),
        unit: ulp(exp).into(),
        fails: off(&naive),
        bound: VectorBounds::by_formula(exp).one_minus_exp
            + 2f64.powi(exp.output_bits as i32 - bits as i32),
        from: format!("the exponential's budget, and the step of {bits} fraction bits").into(),
        ours: off(&|a| twin.one_minus_exp(a)),
    })
}
