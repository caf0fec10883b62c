//! How much two clouds differ, Gaussian by Gaussian and property by property.

use glam::DVec3;
use rayon::prelude::*;

use crate::nearest::Tree;
use crate::{Cloud, sigmoid};
use potamoi_base::sh;

/// The largest root of mean squared distances of centres, as a share of the cloud's extent, at which the
/// order of both files is taken to be the same.
const SAME_ORDER: f64 = 1e-3;

/// Differences of a property over all pairs of Gaussians.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub struct Difference {
    /// The property.
    pub what: &'static str,
    /// Unit of the differences.
    pub unit: &'static str,
    /// The largest difference.
    pub most: f64,
    /// The root of the mean square.
    pub rms: f64,
}

/// How Gaussians were paired.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Pairing {
    /// By their order in both clouds.
    Order,
    /// Each of the first cloud with the nearest centre of the second.
    Nearest,
}

/// Differences of two clouds.
#[derive(Debug, Clone, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub struct Differences {
    /// How Gaussians were paired.
    pub pairing: Pairing,
    /// Gaussians of the second cloud that are in exactly one pair.
    pub in_one_pair: u64,
    /// One property each.
    pub properties: Vec<Difference>,
}

/// The differences between two clouds of equally many Gaussians; `None` if one has more. `shift` is what
/// the second cloud's centres have to be moved by to be in the world of the first.
#[must_use]
pub fn differences(one: &Cloud, other: &Cloud, shift: DVec3) -> Option<Differences> {
    if one.len() != other.len() {
        return None;
    }
    let centre = |cloud: &Cloud, i: usize| DVec3::from(cloud.means()[i].map(f64::from));
    let [low, high] = one.bounds().map(|own| DVec3::from(own.map(f64::from)));
    let squares =
        (0..one.len()).map(|i| (centre(other, i) + shift - centre(one, i)).length_squared());
    let off = (squares.sum::<f64>() / one.len() as f64).sqrt();
    let (pairing, partner) = match off <= SAME_ORDER * (high - low).length() {
        true => (Pairing::Order, (0..one.len()).collect()),
        false => {
            let tree = Tree::of((0..other.len()).map(|i| centre(other, i) + shift).collect());
            let nearest = (0..one.len())
                .into_par_iter()
                .map(|i| tree.nearest(centre(one, i)));
            (Pairing::Nearest, nearest.collect::<Vec<usize>>())
        }
    };
    let mut times = vec![0u32; other.len()];
    partner.iter().for_each(|j| times[*j] += 1);
    let over = |what, unit, of: &(dyn Fn(usize, usize) -> f64 + Sync)| {
        let mut most = 0f64;
        let mut sum = 0f64;
        for (i, j) in partner.iter().enumerate() {
            let own = of(i, *j);
            most = most.max(own);
            sum += own * own;
        }
        let rms = (sum / partner.len() as f64).sqrt();
        Difference {
            what,
            unit,
            most,
            rms,
        }
    };
    let coefficients = |i: usize, j: usize, from: usize| {
        let [a, b] = [one.sh(i), other.sh(j)];
        let of =
            |all: &[[f32; 3]], k: usize, c: usize| all.get(k).map_or(0.0, |rgb| f64::from(rgb[c]));
        let until = if from == 0 { 1 } else { a.len().max(b.len()) };
        let all = (from..until).flat_map(|k| (0..3).map(move |c| (k, c)));
        all.map(|(k, c)| (of(a, k, c) - of(b, k, c)).abs())
            .fold(0.0, f64::max)
    };
    let mut properties = vec![
        over("centre", "scene units", &|i, j| {
            (centre(other, j) + shift - centre(one, i)).length()
        }),
        over("size", "ln", &|i, j| {
            let pairs = one.log_scales()[i].into_iter().zip(other.log_scales()[j]);
            let all = pairs.map(|(a, b)| (f64::from(a) - f64::from(b)).abs());
            all.fold(0.0, f64::max)
        }),
        over("rotation", "degrees", &|i, j| {
            angle(one.rotations()[i], other.rotations()[j])
        }),
        over("opacity", "of 1", &|i, j| {
            let [a, b] = [one.opacity_logits()[i], other.opacity_logits()[j]];
            (sigmoid(a.into()) - sigmoid(b.into())).abs()
        }),
        over("colour", "of 1", &|i, j| {
            coefficients(i, j, 0) * sh::CONSTANT
        }),
    ];
    if one.degree().max(other.degree()) > 0 {
        properties.push(over("other coefficients", "-", &|i, j| {
            coefficients(i, j, 1)
        }));
    }
    Some(Differences {
        pairing,
        in_one_pair: times.iter().filter(|n| **n == 1).count() as u64,
        properties,
    })
}

/// The angle between two ellipsoids' axes in degrees, at most 90 about each of them: an ellipsoid turned by
/// 180 degrees about one of its axes is the same. A quaternion of length 0 is no rotation.
fn angle(a: [f32; 4], b: [f32; 4]) -> f64 {
    let unit = |q: [f32; 4]| {
        let q = q.map(f64::from);
        let length = q.iter().map(|v| v * v).sum::<f64>().sqrt();
        match length > 0.0 {
            true => q.map(|v| v / length),
            false => [1.0, 0.0, 0.0, 0.0],
        }
    };
    let [a, b] = [unit(a), unit(b)];
    let angles = alike(b).map(|b| {
        let cosine: f64 = a.iter().zip(&b).map(|(p, q)| p * q).sum();
        let apart: f64 = (a.iter().zip(&b))
            .map(|(p, q)| (p - q * cosine.signum()).powi(2))
            .sum();
        // By the chord, which small angles are exact in.
        4.0 * (apart.sqrt() / 2.0).clamp(0.0, 1.0).asin().to_degrees()
    });
    angles.into_iter().fold(f64::INFINITY, f64::min)
}

/// The rotations that give an ellipsoid the same axes: this one, and it after half a turn about x, y or z.
pub(crate) fn alike([w, x, y, z]: [f64; 4]) -> [[f64; 4]; 4] {
    [[w, x, y, z], [-x, w, z, -y], [-y, -z, w, x], [-z, y, -x, w]]
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn cloud(seed: u32, count: u32) -> Cloud {
        let value = |i: u32, p: u32| {
            let own = (i * 31 + p + seed).wrapping_mul(0x9e37_79b1) >> 8;
            own as f32 / (1u32 << 24) as f32
        };
        let three = |i: u32, p: u32| [value(i, p), value(i, p + 1), value(i, p + 2)];
        Cloud::new(
            0,
            (0..count).map(|i| three(i, 0)).collect(),
            (0..count).map(|i| three(i, 3)).collect(),
            (0..count)
                .map(|i| [0.5, value(i, 6), value(i, 7), value(i, 8)])
                .collect(),
            (0..count).map(|i| value(i, 9)).collect(),
            (0..count).map(|i| three(i, 10)).collect(),
        )
        .unwrap()
    }

    fn of<'a>(found: &'a Differences, what: &str) -> &'a Difference {
        found
            .properties
            .iter()
            .find(|own| own.what == what)
            .unwrap()
    }

    #[test]
    fn equal_clouds_differ_in_nothing_in_any_order() {
        let own = cloud(1, 500);
        let back: Vec<usize> = (0..500).rev().collect();
        let turned = own.select(&back).unwrap();
        let expected = [Pairing::Order, Pairing::Nearest];
        for (other, pairing) in [&own, &turned].into_iter().zip(expected) {
            let found = differences(&own, other, DVec3::ZERO).unwrap();
            assert_eq!((found.pairing, found.in_one_pair), (pairing, 500));
            assert!(
                found.properties.iter().all(|own| own.most < 1e-12),
                "{found:?}"
            );
        }
        assert!(differences(&own, &cloud(1, 499), DVec3::ZERO).is_none());
    }

    #[test]
    fn each_property_is_compared_in_its_unit() {
        let one = cloud(2, 2);
        let mut rotations = one.rotations().to_vec();
        let [w, x, y, z] = rotations[0];
        // A turn by 60 degrees about x before it, and the opposite quaternion, the same rotation.
        let (c, s) = (3f32.sqrt() / 2.0, 0.5f32);
        rotations[0] = [w * c - x * s, x * c + w * s, y * c + z * s, z * c - y * s];
        // Half a turn about its own y, too.
        let [w, x, y, z] = rotations[1];
        rotations[1] = [y, z, -w, -x];
        let mut means = one.means().to_vec();
        means[1][0] += 1e-4;
        let mut scales = one.log_scales().to_vec();
        scales[0][2] += 0.5;
        let colours = (0..2).map(|i| one.sh(i)[0].map(|v| v + 0.1)).collect();
        let other =
            Cloud::new(0, means, scales, rotations, vec![f32::INFINITY; 2], colours).unwrap();
        let found = differences(&one, &other, DVec3::ZERO).unwrap();
        let near = |what: &str, most: f64, rms: f64| {
            let own = of(&found, what);
            assert!(
                (own.most - most).abs() < 1e-5 && (own.rms - rms).abs() < 1e-5,
                "{own:?}"
            );
        };
        near("centre", 1e-4, 1e-4 / 2f64.sqrt());
        near("size", 0.5, 0.5 / 2f64.sqrt());
        near("rotation", 60.0, 60.0 / 2f64.sqrt());
        near("colour", 0.1 * sh::CONSTANT, 0.1 * sh::CONSTANT);
        assert!(of(&found, "opacity").most > 0.2);
        let shifted = differences(&one, &one, DVec3::X * 1e-4).unwrap();
        assert!((of(&shifted, "centre").most - 1e-4).abs() < 1e-9);
    }
}
