#![allow(clippy::unwrap_used)]

use glam::DVec3;
use rand::{Rng as _, SeedableRng as _};
use rand_pcg::Pcg64Mcg;

use super::super::tests::gathered;
use super::*;
use crate::fields::Field as _;

/// The sum of `rank` random terms a mode.
fn limited(points: [usize; 3], channels: usize, rank: usize, seed: u64) -> Dense {
    let mut random = Pcg64Mcg::seed_from_u64(seed);
    let mut some =
        |count: usize| -> Vec<f64> { (0..count).map(|_| random.random_range(-1.0..1.0)).collect() };
    let mut made = Dense::sampled(points, channels, |_, v| v.fill(0.0)).unwrap();
    for mode in 0..3 {
        let [a, b] = PLANES[mode].map(|axis| points[axis]);
        let terms: Vec<_> = (0..rank)
            .map(|_| Term {
                line: some(points[LINES[mode]]),
                plane: some(a * b),
                // A term that is weak beside others would be found slowly.
                channels: some(channels).iter().map(|v| 1.0 + v / 2.0).collect(),
            })
            .collect();
        add(&mut made, mode, &terms, 1.0);
    }
    made
}

#[test]
fn what_has_the_rank_comes_back() {
    for (channels, rank, allowed) in [(1, 1, 1), (1, 3, 3), (3, 1, 3), (3, 2, 6)] {
        let function = limited([22, 20, 18], channels, rank, 5);
        let factors = Factors::of(&function, [allowed; 3]).unwrap();
        println!("{channels} channels, rank {rank}: {:.1e}", factors.error());
        assert!(factors.error() < 1e-5, "{}", factors.error());
        // What it says of itself is so.
        let mut left = function.clone();
        for (mode, terms) in factors.modes.iter().enumerate() {
            assert!(terms.len() <= allowed);
            add(&mut left, mode, terms, -1.0);
        }
        let error = left.norm() / function.norm();
        assert!((error - factors.error()).abs() < 1e-9);
        if rank > 1 {
            // And less does not do.
            let fewer = Factors::of(&function, [(rank - 1) * channels; 3]).unwrap();
            assert!(fewer.error() > 0.02, "{}", fewer.error());
        }
    }
}

/// A ball with a rim, and a colour that turns about it: of no finite rank.
fn ball(points: [usize; 3], channels: usize) -> Dense {
    Dense::sampled(points, channels, |vertex, out| {
        let at = |axis: usize| 2.0 * vertex[axis] as f64 / (points[axis] - 1) as f64 - 1.0;
        let [x, y, z] = [at(0), at(1), at(2)];
        let level = 12.0 / (1.0 + ((x * x + y * y + z * z).sqrt() * 10.0 - 6.0).exp());
        for (c, value) in out.iter_mut().enumerate() {
            *value = level * (1.0 + c as f64 * (x + 2.0 * y * z).sin());
        }
    })
    .unwrap()
}

#[test]
fn the_error_falls_with_the_rank() {
    for channels in [1, 3] {
        let function = ball([17, 16, 15], channels);
        let errors = [1, 2, 4, 8].map(|rank| {
            Factors::of(&function, [rank * channels; 3])
                .unwrap()
                .error()
        });
        println!("{channels} channels: {errors:?}");
        assert!(errors.windows(2).all(|e| e[1] < 0.7 * e[0]), "{errors:?}");
        let again = Factors::of(&function, [4 * channels; 3]).unwrap();
        assert_eq!(again.error(), errors[2]);
    }
}

/// The model of a function shows the function: density and features at every
/// vertex.
#[test]
fn a_model_has_the_functions_values() {
    let points = [10, 9, 8];
    let (density, appearance) = (limited(points, 1, 1, 3), limited(points, 3, 1, 4));
    let mut weights = vec![0.0; 3 * 6];
    for i in 0..3 {
        weights[i * 6 + i] = 1.0;
    }
    let mlp = Mlp::new(vec![Layer::new(6, weights, vec![0.0; 3]).unwrap()]).unwrap();
    let rules = Rules {
        feature_frequencies: 0,
        view_frequencies: 0,
        ..Rules::new([DVec3::ZERO, DVec3::new(9.0, 8.0, 7.0)])
    };
    let field = Tensorf::from_dense(&density, &appearance, [2, 3], mlp.clone(), rules).unwrap();
    let mut scratch = vec![];
    for z in 0..8 {
        for y in 0..9 {
            for x in 0..10 {
                let features = gathered(&field, DVec3::new(x as f64, y as f64, z as f64)).unwrap();
                let exact = density.values[density.offset([x, y, z])];
                assert!((field.density(&features) - exact).abs() < 1e-4);
                let exact = &appearance.values[appearance.offset([x, y, z])..][..3];
                let colour = field.colour(&features, DVec3::X, &mut scratch);
                for (found, exact) in colour.to_array().iter().zip(exact) {
                    assert!((found - 1.0 / (1.0 + (-exact).exp())).abs() < 1e-4);
                }
            }
        }
    }
    let other = limited([10, 9, 7], 3, 1, 4);
    let error = Tensorf::from_dense(&density, &other, [1, 1], mlp, rules);
    assert!(
        error
            .unwrap_err()
            .to_string()
            .contains("as the appearance has")
    );
}

#[test]
fn what_is_no_function_is_refused() {
    let error = |points, channels, value: f64| {
        let made = Dense::sampled(points, channels, |_, v| v.fill(value));
        made.unwrap_err().to_string()
    };
    assert!(error([1, 4, 4], 1, 0.0).contains("points"));
    assert!(error([4, 4, 2000], 1, 0.0).contains("points"));
    assert!(error([4; 3], 0, 0.0).contains("channels"));
    assert!(error([512; 3], 256, 0.0).contains("values"));
    assert!(error([4; 3], 1, f64::NAN).contains("at vertex [0, 0, 0]"));
    let zero = Dense::sampled([4; 3], 1, |_, v| v.fill(0.0)).unwrap();
    assert_eq!(Factors::of(&zero, [2; 3]).unwrap().error(), 0.0);
    assert!(Factors::of(&zero, [0, 1, 1]).is_err());
}
