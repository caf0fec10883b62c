//! Compositing: long products, opacities of 0 and 1, and early termination.

use glam::DVec3;
use potamoi_formats::config::Config;
use potamoi_formats::fixed::Rounding;
use potamoi_formats::units::{OpCode, VectorOp};

use super::exact::exact;
use super::{
    Case, Draws, Measuring, Stop, Worst, cases, computes, eight_vertices, ensure, rendered, unless,
};
use potamoi_base::camera::Camera;
use potamoi_fields::voxels::{Grid, Layout, StoredField};
use potamoi_fields::{self as fields, FixedField};
use potamoi_gaussians::{Cloud, CloudError, sigmoid};
use potamoi_reference::ReferenceUnits;
use potamoi_reference::vector_unit::{ReferenceVectorUnit, VectorError};
use potamoi_scene::{Model, Rendered, Scene};
use potamoi_splats::{FloatOptions, Limits, Profile, render_float};

cases! {
    "compositing";
    long_transmittances, "transmittance over 65,536 samples", "";
    sums_of_4096_weights, "sum of 4096 weights and what is left", "";
    the_least_alpha, "the least alpha that counts, 1/255", "";
    the_stop, "the stop at a transmittance of 1e-4", "";
    opacities_of_none_and_all, "opacities of exactly 0 and 1", "";
    depth_of_nothing, "depth where all alphas are 0", "";
}

const ONE: f64 = 1_048_576.0;
const SAMPLES: usize = 65_536;

fn transmittance(unit: &ReferenceVectorUnit, t: i32, alpha: i32) -> Result<i32, VectorError> {
    let op = VectorOp {
        code: OpCode::Multiply,
        shift: 16,
        rounding: Rounding::HalfUp,
    };
    unit.element(op, t, 65_536 - alpha)
}

fn long_transmittances(under: &Config) -> Measuring {
    computes(under, OpCode::Multiply)?;
    let unit = ReferenceVectorUnit::new(&under.vu);
    let (mut fails, mut ours) = (Worst::default(), Worst::default());
    for alpha in [1, 2, 3, 16, 257, 655] {
        let factor = exact(f64::from(65_536 - alpha) / 65_536.0);
        let (mut t, mut short) = (1 << 20, 65_536i64);
        for k in 1..=SAMPLES {
            t = transmittance(&unit, t, alpha)?;
            short = (short * i64::from(65_536 - alpha)) >> 16;
            if k % 4096 == 0 {
                let exact = factor.powi(k);
                ours.see(exact.error(f64::from(t) / ONE));
                fails.see(exact.error(short as f64 / 65_536.0));
            }
        }
    }
    Ok(Case {
        naive: "U0.16, cut off".into(),
        unit: "absolute".into(),
        fails,
        // Half a unit a sample, which what follows lets through.
        bound: 2f64.powi(-21) * SAMPLES as f64 * (1.0 - (-1f64).exp()),
        from: "half a unit of U1.20 a sample, by what the samples behind let through".into(),
        ours,
    })
}

/// Fog of one colour and changing density in a line of 4096 samples, nothing behind it.
fn sums_of_4096_weights(under: &Config) -> Measuring {
    eight_vertices(under)?;
    let mut draws = Draws(5);
    let points = [2, 2, 1025];
    let mut thin = vec![0f32; points[2]];
    thin.fill_with(|| draws.between(0.0, 0.004) as f32);
    let grid = Grid::bake(points, DVec3::ZERO, 1.0, Layout::Constant, |at, out| {
        out.copy_from_slice(&[thin[at.z as usize], 0.5, 0.5, 0.5]);
    });
    let field = StoredField::new(grid?, 0.25);
    let eye = DVec3::new(0.5, 0.5, -5.0);
    let camera = Camera::look_at(eye, eye + DVec3::Z, DVec3::Y, 1e-4, 2, 2);
    let options = fields::FixedOptions {
        terminate: false,
        background: [0.5; 3],
        ..fields::FixedOptions::default()
    };
    computes(under, OpCode::OneMinusExp)?;
    computes(under, OpCode::Multiply)?;
    let fixed = FixedField::new(&field, under)?;
    let frame = fixed.render(&camera, &options, &mut ReferenceUnits::new(under))?;
    let made = frame.stats.outcomes.composited;
    ensure(made > 4 * 4000, || format!("{made} samples composited"))?;
    // All weights and what is left, times one colour: that colour where they sum to 1.
    let unit = 0.5 / ONE;
    let sums = frame.picture.rgb.iter().flatten();
    let ours = Worst::of(sums.map(|v| (f64::from(*v) - 0.5) / unit));
    let (mut t, mut sum) = (1i64 << 20, 0);
    let mut draws = Draws(5);
    for _ in 0..4096 {
        let alpha = draws.between(0.0, 65.0).round() as i64;
        sum += (t * alpha) >> 16;
        t = (t * (65_536 - alpha) + (1 << 15)) >> 16;
    }
    Ok(Case {
        naive: "weights T alpha, each cut off to U1.20".into(),
        unit: "ulp of U1.20".into(),
        fails: Worst((sum + t - (1 << 20)).abs() as f64),
        bound: 0.0,
        from: "weights are differences of T: an identity of integers".into(),
        ours,
    })
}

fn the_least_alpha(_: &Config) -> Measuring {
    let limits = Limits::new(&Profile::Inria.rules());
    let naive = (65_536.0f64 / 255.0).round() as i32;
    let wrong = |least: i32| {
        let codes = 0..65_536i32;
        Worst(codes.filter(|a| (*a < least) != (a * 255 < 65_536)).count() as f64)
    };
    Ok(Case {
        naive: "the nearest code".into(),
        unit: "codes of 65,536 decided wrongly".into(),
        fails: wrong(naive),
        bound: 0.0,
        from: "the least code that is not below: a comparison of integers".into(),
        ours: wrong(limits.alpha_min),
    })
}

fn camera() -> Camera {
    Camera::look_at(DVec3::ZERO, DVec3::Z, DVec3::NEG_Y, 0.9, 16, 16)
}

/// White Gaussians, one behind the other, that fill the frame evenly.
fn layers(logits: Vec<f32>) -> Result<Cloud, CloudError> {
    let n = logits.len();
    let white = (0.5 / potamoi_base::sh::CONSTANT) as f32;
    Cloud::new(
        0,
        (0..n).map(|i| [0.0, 0.0, 1.0 + i as f32]).collect(),
        vec![[10.0; 3]; n],
        vec![[1.0, 0.0, 0.0, 0.0]; n],
        logits,
        vec![[white; 3]; n],
    )
}

fn fixed(cloud: Cloud, under: &Config) -> Result<Rendered, Stop> {
    let model = Model::Splats(cloud);
    let scene = Scene::of("layers", model, camera(), DVec3::Y, [0.0; 3]);
    rendered(&scene, under)
}

fn drawn(frame: &Rendered) -> u64 {
    frame.counts.splats.map_or(0, |own| own.pairs_drawn)
}

/// The second capped layer would leave 0.9989e-4, which rounds to 105 codes of T, 1.0014e-4.
fn the_stop(under: &Config) -> Measuring {
    let bits = under.vu.exp.output_bits;
    unless(bits == 16, || {
        format!("vu.exp.output_bits = {bits}: the opacities of the case are chosen for 16")
    })?;
    let frame = fixed(layers(vec![f32::INFINITY; 5])?, under)?;
    let layers = drawn(&frame) as f64 / 256.0;
    let cap = 65_536 - 64_881i64;
    let mut t = 1i64 << 20;
    let mut passed = 0;
    while passed < 5 {
        let next = (t * cap + (1 << 15)) >> 16;
        if (next as f64) / ONE < 1e-4 {
            break;
        }
        t = next;
        passed += 1;
    }
    Ok(Case {
        naive: "the rounded product compared".into(),
        unit: "layers drawn past it".into(),
        fails: Worst(f64::from(passed) - 1.0),
        bound: 0.0,
        from: "the exact product is compared".into(),
        ours: Worst((layers - 1.0).abs()),
    })
}

fn opacities_of_none_and_all(under: &Config) -> Measuring {
    let logits = [
        f32::NEG_INFINITY,
        -1e30,
        -104.0,
        -89.0,
        0.0,
        40.0,
        89.0,
        f32::INFINITY,
    ];
    let (mut fails, mut ours) = (Worst::default(), Worst::default());
    for logit in logits {
        let value = f64::from(logit);
        let right = match logit {
            f32::INFINITY => exact(1.0),
            f32::NEG_INFINITY | -1e30 => exact(0.0),
            _ => exact(1.0) / (exact(1.0) + exact(-value).exp()),
        };
        ours.see(right.error(sigmoid(value)));
        let e = logit.exp();
        fails.see(right.error(f64::from(e / (1.0 + e))));
    }
    // In the picture: nothing of nothing, and the cap of all.
    let frame = fixed(layers(vec![f32::NEG_INFINITY])?, under)?;
    let is_void = drawn(&frame) == 0 && frame.picture.rgb.iter().flatten().all(|v| *v == 0.0);
    ensure(is_void, || "an opacity of 0 draws something".to_owned())?;
    let frame = fixed(layers(vec![f32::INFINITY])?, under)?;
    let unit = 2f64.powi(-(under.vu.exp.output_bits.min(12) as i32));
    let values = frame.picture.rgb.iter().flatten();
    let off = Worst::of(values.map(|v| f64::from(*v) - 0.99));
    ensure(off.0 <= 2.0 * unit, || {
        format!("an opacity of 1 is off its cap by {}", off.0)
    })?;
    Ok(Case {
        naive: "e^x / (1 + e^x) in 32 bits".into(),
        unit: "absolute".into(),
        fails,
        bound: 4.0 * 2f64.powi(-53),
        from: "four roundings of 64 bits".into(),
        ours,
    })
}

/// The weighted mean depth of a pixel in which no sample has a weight.
fn depth_of_nothing(_: &Config) -> Measuring {
    let options = FloatOptions {
        depth: true,
        ..FloatOptions::default()
    };
    let cloud = layers(vec![f32::NEG_INFINITY; 3])?;
    let frame = render_float(&cloud, &camera(), Profile::Inria, &options)?;
    let mut ours = Worst::default();
    for depth in frame.depth.unwrap_or_default() {
        ours.count(depth != f64::INFINITY);
    }
    let (moment, weight) = (0.0f64, 0.0f64);
    let mut fails = Worst::default();
    for _ in 0..256 {
        fails.count(moment / weight != f64::INFINITY);
    }
    Ok(Case {
        naive: "the mean by weight, 0 / 0".into(),
        unit: "pixels of 256 that are not void".into(),
        fails,
        bound: 0.0,
        from: "infinite by definition".into(),
        ours,
    })
}
