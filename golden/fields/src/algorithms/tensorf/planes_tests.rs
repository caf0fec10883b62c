#![allow(clippy::unwrap_used)]

use super::*;
use crate::Field as _;
use crate::algorithms::tensorf::tests::gathered;
use glam::DVec3;

const POINTS: [usize; 3] = [6, 5, 4];

/// Every vertex of the grid, x fastest.
fn every() -> Vec<[usize; 3]> {
    let [nx, ny, nz] = POINTS;
    let all = (0..nx * ny * nz).map(|i| [i % nx, i / nx % ny, i / (nx * ny)]);
    all.collect()
}

/// Numbers without a pattern, from -1 to 1.
fn noise(seed: u64, count: usize) -> Vec<f32> {
    let value = |i: u64| {
        let bits = (i + seed * 7919).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        ((bits ^ bits >> 29).wrapping_mul(0xbf58_476d_1ce4_e5b9) >> 40) as f32 / 8_388_608.0 - 1.0
    };
    (0..count as u64).map(value).collect()
}

/// The sum that the factors stand for, term by term, in 64 bits.
fn by_hand(lines: &Lines, planes: &Planes, at: [usize; 3]) -> f64 {
    let mut sum = 0.0;
    for mode in 0..3 {
        let [a, b] = PLANES[mode];
        for term in 0..lines.terms {
            let line = lines.values[mode][at[LINES[mode]] * lines.terms + term];
            let vertex = at[b] * POINTS[a] + at[a];
            let plane = planes[mode][vertex * lines.terms + term];
            sum += f64::from(line) * f64::from(plane);
        }
    }
    sum
}

/// Planes without a pattern.
fn any_planes(lines: &Lines) -> Planes {
    let mut planes = lines.empty();
    for (mode, plane) in planes.iter_mut().enumerate() {
        *plane = noise(mode as u64 + 1, plane.len());
    }
    planes
}

#[test]
fn factors_give_the_sum_of_their_products() {
    let lines = Lines::new(POINTS, 7, 3);
    let (planes, at) = (any_planes(&lines), every());
    let weights = noise(9, at.len());
    let mut found = vec![0.0; at.len()];
    lines.apply(&planes, &at, &weights, &mut found);
    for ((vertex, weight), found) in at.iter().zip(&weights).zip(found) {
        let expected = by_hand(&lines, &planes, *vertex) * f64::from(*weight);
        assert!((f64::from(found) - expected).abs() < 1e-5, "{vertex:?}");
    }
}

/// `<A p, v> = <p, A' v>`, and damping takes its share of the planes away.
#[test]
fn the_transpose_is_the_transpose() {
    let lines = Lines::new(POINTS, 6, 1);
    let (planes, at) = (any_planes(&lines), every());
    let (weights, values) = (noise(4, at.len()), noise(5, at.len()));
    let mut forth = vec![0.0; at.len()];
    lines.apply(&planes, &at, &weights, &mut forth);
    let inner =
        |a: &[f32], b: &[f32]| -> f64 { a.iter().zip(b).map(|(a, b)| f64::from(a * b)).sum() };
    let of_planes = |a: &Planes, b: &Planes| -> f64 { (0..3).map(|m| inner(&a[m], &b[m])).sum() };
    let back = lines.transpose(&values, &at, &weights, &lines.empty());
    let [here, there] = [inner(&forth, &values), of_planes(&planes, &back)];
    assert!(
        here.abs() > 0.1 && (here - there).abs() < 1e-4,
        "{here} {there}"
    );
    let damped = lines.transpose(&values, &at, &weights, &planes);
    let taken = of_planes(&planes, &back) - of_planes(&planes, &damped);
    let expected = f64::from(DAMPING) * of_planes(&planes, &planes);
    assert!((taken / expected - 1.0).abs() < 1e-2, "{taken} {expected}");
}

/// Half of the lines are the cosine transform's, of which the first is constant
/// and two are orthogonal; all squares together sum to about 1.
#[test]
fn lines_are_cosines_and_seeded_noise() {
    let (terms, points) = (8, [64, 48, 32]);
    let lines = Lines::new(points, terms, 5);
    for (mode, axis) in LINES.into_iter().enumerate() {
        let of = |term: usize| (0..points[axis]).map(move |v| (v, term));
        let value = |(v, term): (usize, usize)| f64::from(lines.values[mode][v * terms + term]);
        let size = points[axis] as f64 / (3.0 * terms as f64);
        for a in 1..terms / 2 {
            for b in 1..terms / 2 {
                let product: f64 = of(a).zip(of(b)).map(|(a, b)| value(a) * value(b)).sum();
                let expected = if a == b { size } else { 0.0 };
                assert!(
                    (product - expected).abs() < 1e-4,
                    "{mode} {a} {b} {product}"
                );
            }
        }
        assert!(of(0).all(|at| (value(at) - value((0, 0))).abs() < 1e-6));
        for term in terms / 2..terms {
            let square: f64 = of(term).map(|at| value(at).powi(2)).sum::<f64>() / size;
            assert!((0.4..2.0).contains(&square), "{mode} {term} {square}");
        }
    }
    assert_eq!(Lines::new(points, terms, 5).values, lines.values);
    assert_ne!(Lines::new(points, terms, 6).values, lines.values);
}

/// What factors made is found again, at vertices of which many are left out,
/// and the more the heavier they weigh.
#[test]
fn known_values_are_met() {
    let lines = Lines::new(POINTS, 6, 2);
    let at: Vec<_> = every().into_iter().step_by(2).collect();
    let values = noise(8, at.len());
    let even = vec![1.0; at.len()];
    let planes = lines.planes(&at, &values, &even);
    let worst = |planes: &Planes, range: std::ops::Range<usize>| {
        let off = range.map(|i| (by_hand(&lines, planes, at[i]) - f64::from(values[i])).abs());
        off.fold(0.0, f64::max)
    };
    let all = worst(&planes, 0..at.len());
    assert!(all < 0.02, "{all}");
    // With one term a mode not all can be met: the heavy ones are.
    let lines = Lines::new(POINTS, 1, 2);
    let worst = |planes: &Planes, range: std::ops::Range<usize>| {
        let off = range.map(|i| (by_hand(&lines, planes, at[i]) - f64::from(values[i])).abs());
        off.fold(0.0, f64::max)
    };
    let mut heavy = vec![0.01; at.len()];
    heavy[..8].fill(10.0);
    let [light, heavy] = [&even, &heavy].map(|w| worst(&lines.planes(&at, &values, w), 0..8));
    assert!(heavy < 0.1 * light, "{heavy} {light}");
}

/// A density and two channels, known everywhere.
fn known() -> KnownValues {
    let count = every().len();
    KnownValues {
        points: POINTS,
        places: every(),
        density: noise(11, count),
        seen: every(),
        appearance: vec![noise(12, count), noise(13, count)],
        filled: vec![true; count],
    }
}

fn through(known: &KnownValues, ranks: [usize; 2], slots: &[usize]) -> Result<Tensorf, FieldError> {
    let rules = Rules {
        feature_frequencies: 0,
        view_frequencies: 0,
        ..Rules::new([DVec3::ZERO, DVec3::new(5.0, 4.0, 3.0)])
    };
    // Three features and the direction.
    let mlp = Mlp::new(vec![Layer::new(6, vec![0.1; 18], vec![0.0; 3])?])?;
    Tensorf::through(known, ranks, (3, slots), mlp, rules)
}

/// The model's own density and features at vertices are what was known there,
/// each channel in its slot; a vertex is one unit wide.
#[test]
fn a_model_goes_through_what_is_known() {
    let known = known();
    let field = through(&known, [24, 50], &[2, 0]).unwrap();
    assert_eq!(field.points(), POINTS);
    let mut out = vec![];
    let mut worst = [0f64; 3];
    for (i, vertex) in every().into_iter().enumerate() {
        let at = DVec3::from(vertex.map(|v| v as f64));
        let features = gathered(&field, at).unwrap();
        let off = field.density(&features) - f64::from(known.density[i]);
        worst[0] = worst[0].max(off.abs());
        field.appearance(&features, &mut out);
        assert_eq!((out.len(), out[1]), (3, 0.0));
        for (channel, slot) in [2, 0].into_iter().enumerate() {
            let off = out[slot] - f64::from(known.appearance[channel][i]);
            worst[1 + channel] = worst[1 + channel].max(off.abs());
        }
    }
    assert!(worst.iter().all(|w| *w < 0.02), "{worst:?}");
    let inside = DVec3::new(2.5, 2.0, 1.5);
    assert!(field.holds(inside) && !field.holds(-inside));
}

#[test]
fn what_makes_no_model_is_refused_by_name() {
    let refused = |change: &dyn Fn(&mut KnownValues), ranks, slots: &[usize], part: &str| {
        let mut wrong = known();
        change(&mut wrong);
        let error = through(&wrong, ranks, slots).unwrap_err().to_string();
        assert!(error.contains(&format!("`{part}` is ")), "{part}: {error}");
    };
    let (ranks, slots) = ([4, 4], &[0usize, 1][..]);
    assert!(through(&known(), ranks, slots).is_ok());
    refused(&|_| (), ranks, &[0], "slots");
    refused(&|_| (), ranks, &[0, 3], "slots");
    refused(&|k| k.appearance.clear(), ranks, &[], "slots");
    refused(&|_| (), [0, 4], slots, "ranks");
    refused(&|_| (), [4, 1], slots, "ranks");
    refused(&|_| (), [1025, 4], slots, "ranks");
    refused(&|_| (), [4, 1025], slots, "ranks");
    refused(&|k| k.places[7] = [6, 0, 0], ranks, slots, "vertices");
    refused(&|k| k.seen[7] = [0, 0, 4], ranks, slots, "vertices");
    refused(&|k| k.density.truncate(119), ranks, slots, "known");
    refused(&|k| k.appearance[1].truncate(119), ranks, slots, "known");
    refused(&|k| k.filled.truncate(119), ranks, slots, "known");
}
