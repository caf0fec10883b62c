//! Opacities of thin air: `1 - exp(-s)` where `exp` is nearly 1.

use glam::DVec3;
use potamoi_formats::config::ExpConfig;

use super::exact::exact;
use super::{Case, Worst, cases};
use potamoi_base::camera::Camera;
use potamoi_fields::render_float;
use potamoi_fields::voxels::{Grid, Layout, StoredField};
use potamoi_reference::exponential::ReferenceExponential;
use potamoi_reference::widths::budget;

cases!(thin_fog_in_floats, thin_fog_in_codes);

/// A picture of one pixel, straight along z through white fog of one density.
fn through_fog(density: f32) -> (f64, u64) {
    let grid = Grid::bake([2, 2, 40], DVec3::ZERO, 1.0, Layout::Constant, |_, out| {
        out.copy_from_slice(&[density, 1.0, 1.0, 1.0]);
    });
    let eye = DVec3::new(0.5, 0.5, -5.0);
    let camera = Camera::look_at(eye, eye + DVec3::Z, DVec3::Y, 0.1, 1, 1);
    let field = StoredField::new(grid.unwrap(), 1.0);
    let frame = render_float(&field, &camera, [0.0; 3]).unwrap();
    (f64::from(frame.picture.rgb[0][0]), frame.samples)
}

fn thin_fog_in_floats() -> Case {
    let (mut fails, mut ours) = (Worst::default(), Worst::default());
    for density in [1e-4f32, 1e-6, 1e-8, 1e-12, 1e-20, 1e-30] {
        let (found, samples) = through_fog(density);
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
    Case {
        name: "1 - exp(-s) down to s = 1e-30, in floats",
        naive: "1 less the exponential, in 32 bits",
        unit: "relative",
        fails,
        // 40 sums and a picture of 32 bits.
        bound: 2f64.powi(-24) + 200.0 * 2f64.powi(-53),
        from: "half a unit of the picture's 32-bit floats",
        ours,
    }
}

fn thin_fog_in_codes() -> Case {
    let config = ExpConfig::default();
    let twin = ReferenceExponential::new(&config);
    let bits = config.one_minus_frac_bits;
    let exact = |a: i32| -(-f64::from(a) * 2f64.powi(-(bits as i32))).exp_m1() * 65_536.0;
    let codes = || (0..1 << 15).chain((1 << 15..16 << bits).step_by(997));
    // The operand in the exponential's own format, and what it gives for 0.
    let naive = |a: i32| 65_536 - twin.exp((a + (1 << (bits - 14))) >> (bits - 13));
    let off = |f: &dyn Fn(i32) -> i32| Worst::of(codes().map(|a| f64::from(f(a)) - exact(a)));
    Case {
        name: "1 - exp(-s) in codes, 0 among them",
        naive: "65,536 less the exponential's result",
        unit: "ulp of U0.16",
        fails: off(&naive),
        bound: budget(&config) + 2f64.powi(16 - 20),
        from: "the exponential's budget, and half the step of 20 fraction bits",
        ours: off(&|a| twin.one_minus_exp(a)),
    }
}
