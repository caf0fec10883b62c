//! Needles: nearly singular covariances, and their consequences.

use glam::{DVec2, DVec3};
use potamoi_formats::config::Config;
use potamoi_formats::record::{FACTOR, MEAN, OPACITY};

use super::exact::{Exact, exact};
use super::{Case, Measuring, Worst, cases};
use potamoi_splats::{Footprint, Projected, RecordForm, Saturations, record};

cases! {
    "covariances";
    near_singular_determinants, "determinants of nearly singular covariances", "";
    the_small_eigenvalue, "the small eigenvalue, 0.3 of a needle", "";
    powers_of_needles, "alpha on needles across the frame", "";
}

/// Half a unit in the last place of a double, relative.
const U: f64 = 1.0 / (1u64 << 53) as f64;
/// Upper bound of the relative error of a determinant.
pub(super) const DETERMINANT: f64 = 12.0 * U;
const DILATION: f64 = 0.3;

/// The two rows of a needle's factor, rounded to 32 bits: 3 to 3000 pixels long.
fn needles() -> impl Iterator<Item = [DVec3; 2]> {
    let lengths = [3.0, 30.0, 300.0, 1e3, 3e3];
    lengths.into_iter().flat_map(|length| {
        (0..60).map(move |i| {
            let (s, c) = ((f64::from(i) + 0.37) * 0.0523).sin_cos();
            let round = |v: f64| f64::from(v as f32);
            let row = |a: f64, b: f64| DVec3::new(round(a), round(b), 0.0);
            [row(length * c, -0.02 * s), row(length * s, 0.02 * c)]
        })
    })
}

/// Covariance xx, xy, yy.
fn covariance([x, y]: [DVec3; 2], dilation: f64) -> [Exact; 3] {
    let dot = |a: DVec3, b: DVec3| {
        let terms = a.to_array().into_iter().zip(b.to_array());
        terms.fold(exact(0.0), |sum, (a, b)| sum + exact(a) * exact(b))
    };
    [
        dot(x, x) + exact(dilation),
        dot(x, y),
        dot(y, y) + exact(dilation),
    ]
}

/// The determinant of the covariance of two rows, exactly.
pub(super) fn determinant(rows: [DVec3; 2], dilation: f64) -> Exact {
    let [xx, xy, yy] = covariance(rows, dilation);
    xx * yy - xy.clone() * xy
}

/// The reference rasteriser's entries, in 32 bits.
pub(super) fn in_32_bits([x, y]: [DVec3; 2]) -> [f32; 3] {
    let (x, y) = (x.as_vec3(), y.as_vec3());
    [x.dot(x) + 0.3, x.dot(y), y.dot(y) + 0.3]
}

fn near_singular_determinants(_: &Config) -> Measuring {
    let (mut fails, mut ours) = (Worst::default(), Worst::default());
    for rows in needles() {
        let exact = determinant(rows, DILATION);
        let [xx, xy, yy] = in_32_bits(rows);
        fails.see(exact.relative(f64::from(xx * yy - xy * xy)));
        ours.see(exact.relative(Footprint::new(rows[0], rows[1], DILATION).determinant));
    }
    Ok(Case {
        naive: "xx yy - xy xy in 32 bits".into(),
        unit: "relative".into(),
        fails,
        bound: DETERMINANT,
        from: "a sum of positive terms: a minor's 3 roundings doubled by its square, 6 of sums"
            .into(),
        ours,
    })
}

fn the_small_eigenvalue(_: &Config) -> Measuring {
    let (mut fails, mut ours) = (Worst::default(), Worst::default());
    for rows in needles() {
        let [xx, xy, yy] = covariance(rows, DILATION);
        let half = exact(0.5);
        let (mid, off) = ((xx.clone() + yy.clone()) * half.clone(), (xx - yy) * half);
        let small = mid.clone() - (off.clone() * off + xy.clone() * xy).sqrt();
        let footprint = Footprint::new(rows[0], rows[1], DILATION);
        ours.see(small.relative(footprint.eigenvalues()[1]));
        let [xx, xy, yy] = in_32_bits(rows);
        let mid = 0.5 * (xx + yy);
        let root = (mid * mid - (xx * yy - xy * xy)).max(0.0).sqrt();
        fails.see(small.relative(f64::from(mid - root)));
    }
    Ok(Case {
        naive: "mid - sqrt(mid^2 - det) in 32 bits".into(),
        unit: "relative".into(),
        fails,
        bound: 20.0 * U,
        from: "the determinant's 12 roundings over the large one's 8".into(),
        ours,
    })
}

/// Alpha along and across needles up to the frame's far side, from the record's codes.
fn powers_of_needles(_: &Config) -> Measuring {
    let (mut fails, mut ours) = (Worst::default(), Worst::default());
    for rows in needles() {
        let [xx, xy, yy] = covariance(rows, DILATION);
        let along = rows.map(|r| r.x / rows[0].x.hypot(rows[1].x));
        let footprint = Footprint::new(rows[0], rows[1], DILATION);
        let mean = DVec2::new(311.013_7, 97.77);
        let splat = Projected {
            index: 0,
            depth: 1.0,
            mean,
            footprint,
            opacity: 0.75,
            colour: DVec3::ONE,
        };
        let record = record(
            &splat,
            0,
            RecordForm::default(),
            &mut Saturations::default(),
        );
        let held = DVec2::from(record.mean.map(|m| MEAN.value(m.into())));
        let [l11, l21, l22] = record.factor.map(|l| FACTOR.value(l.into()));
        let opacity = OPACITY.value(record.opacity.into());
        let det = determinant(rows, DILATION);
        let [fxx, fxy, fyy] = in_32_bits(rows);
        let scale = 1.0 / (fxx * fyy - fxy * fxy);
        let [a, b, c] = [fyy * scale, -fxy * scale, fxx * scale];
        for k in -30..=30 {
            let at = f64::from(k) * 16.0;
            for across in [0.0, 0.5, -1.2] {
                let d = DVec2::new(
                    at * along[0] - across * along[1],
                    at * along[1] + across * along[0],
                );
                let [x, y] = [exact(d.x), exact(d.y)];
                let form = yy.clone() * x.clone() * x.clone()
                    - exact(2.0) * xy.clone() * x.clone() * y.clone()
                    + xx.clone() * y.clone() * y;
                let power = (form / det.clone() * exact(-0.5)).to_f64();
                let exact = 0.75 * power.exp();
                let o = mean + d - held;
                let (p, q) = (l11 * o.x + l21 * o.y, l22 * o.y);
                ours.see(opacity * (-0.5 * (p * p + q * q)).exp() - exact);
                let f = d.as_vec2();
                let power = -0.5 * (a * f.x * f.x + c * f.y * f.y) - b * f.x * f.y;
                fails.see(f64::from(0.75 * power.exp()) - exact);
            }
        }
    }
    // At a Gaussian's steepest slope, e^-1/2 over the least sigma: half a unit of the mean in
    // both axes and of three factors at 500 pixels, then half a unit of the opacity.
    let slope = (-0.5f64).exp() / DILATION.sqrt();
    Ok(Case {
        naive: "the conic in 32 bits, a positive power among them".into(),
        unit: "alpha".into(),
        fails,
        bound: slope * (2f64.sqrt() * 2f64.powi(-13) + 1500.0 * 2f64.powi(-31)) + 2f64.powi(-17),
        from: "half a unit of mean, factors and opacity at the steepest slope".into(),
        ours,
    })
}
