//! Comparison of clouds that differ by the steps of a format.

use super::*;

/// Largest differences that a format's steps allow.
pub(super) struct Near {
    pub(super) mean: f32,
    /// Relative, of sizes.
    pub(super) size: f32,
    pub(super) rotation: f32,
    pub(super) opacity: f64,
    pub(super) constant: f32,
    pub(super) rest: f32,
}

/// Checks that every Gaussian of `found` is that of `expected` with the nearest centre, each once.
#[track_caller]
pub(super) fn check(found: &Cloud, expected: &Cloud, near: &Near) {
    assert_eq!(found.len(), expected.len());
    let square =
        |a: &[f32; 3], b: &[f32; 3]| -> f32 { a.iter().zip(b).map(|(x, y)| (x - y).powi(2)).sum() };
    let order: Vec<usize> = (found.means().iter())
        .map(|mean| {
            let all = 0..expected.len();
            all.min_by(|a, b| {
                square(&expected.means()[*a], mean).total_cmp(&square(&expected.means()[*b], mean))
            })
            .unwrap()
        })
        .collect();
    let mut sorted = order.clone();
    sorted.sort_unstable();
    assert!(sorted.into_iter().eq(0..found.len()), "each Gaussian once");
    let sigmoid = |x: f32| 1.0 / (1.0 + (-f64::from(x)).exp());
    let within = |what: &str, i: usize, a: &[f32], b: &[f32], most: f32| {
        for (a, b) in a.iter().zip(b) {
            assert!(
                (a - b).abs() <= most + 1e-6 * a.abs().max(1.0),
                "{what} {i}: {a} {b}"
            );
        }
    };
    let unit = |q: [f32; 4]| {
        let length = q.iter().map(|v| v * v).sum::<f32>().sqrt();
        q.map(|v| v / length)
    };
    for (i, &j) in order.iter().enumerate() {
        within(
            "mean",
            i,
            &found.means()[i],
            &expected.means()[j],
            near.mean,
        );
        within(
            "size",
            i,
            &found.log_scales()[i],
            &expected.log_scales()[j],
            near.size,
        );
        let [p, q] = [unit(found.rotations()[i]), unit(expected.rotations()[j])];
        // Half a turn about an axis of the ellipsoid changes nothing.
        let cosine = |q: &[f32; 4]| p.iter().zip(q).map(|(a, b)| a * b).sum::<f32>();
        let all = crate::difference::alike(q.map(f64::from)).map(|q| q.map(|v| v as f32));
        let q = all
            .into_iter()
            .max_by(|a, b| cosine(a).abs().total_cmp(&cosine(b).abs()));
        let q = q.unwrap();
        within(
            "rotation",
            i,
            &p,
            &q.map(|v| v * cosine(&q).signum()),
            near.rotation,
        );
        let [a, b] = [found.opacity_logits()[i], expected.opacity_logits()[j]].map(sigmoid);
        assert!((a - b).abs() <= near.opacity + 1e-6, "opacity {i}: {a} {b}");
        let [a, b] = [found.sh(i), expected.sh(j)];
        // Writers drop the colours of wholly transparent Gaussians.
        if found.opacity_logits()[i] > f32::NEG_INFINITY {
            within("constant", i, &a[0], &b[0], near.constant);
        }
        within(
            "rest",
            i,
            a[1..].as_flattened(),
            b[1..].as_flattened(),
            near.rest,
        );
    }
}

/// The first Gaussians of the original.
pub(super) fn first(count: usize) -> Cloud {
    original().select(&(0..count).collect::<Vec<_>>()).unwrap()
}

/// The same Gaussians with coefficients up to a degree.
pub(super) fn of_degree(cloud: &Cloud, degree: usize) -> Cloud {
    let each = sh::coefficients(degree);
    Cloud::new(
        degree,
        cloud.means().to_vec(),
        cloud.log_scales().to_vec(),
        cloud.rotations().to_vec(),
        cloud.opacity_logits().to_vec(),
        (0..cloud.len())
            .flat_map(|i| cloud.sh(i)[..each].to_vec())
            .collect(),
    )
    .unwrap()
}
