//! Real spherical harmonics in the convention of 3D Gaussian splatting.

use glam::DVec3;

/// The highest degree that is evaluated.
pub const MAX_DEGREE: usize = 3;
/// The constant basis function, `1 / (2 sqrt(pi))`.
pub const CONSTANT: f64 = 0.282_094_791_773_878_14;

/// Number of coefficients up to a degree, `(degree + 1)^2`.
#[must_use]
pub const fn coefficients(degree: usize) -> usize {
    (degree + 1) * (degree + 1)
}

/// The 16 basis functions of degree 0 to 3 in the unit direction `d`, band by
/// band, orders ascending, with the signs of 3D Gaussian splatting (the
/// Condon-Shortley phase: `-y, z, -x` in band 1).
#[must_use]
pub fn basis(d: DVec3) -> [f64; 16] {
    let DVec3 { x, y, z } = d;
    let (xx, yy, zz) = (x * x, y * y, z * z);
    [
        CONSTANT,
        -0.488_602_511_902_919_9 * y,
        0.488_602_511_902_919_9 * z,
        -0.488_602_511_902_919_9 * x,
        1.092_548_430_592_079_2 * (x * y),
        -1.092_548_430_592_079_2 * (y * z),
        0.315_391_565_252_520_05 * (2.0 * zz - xx - yy),
        -1.092_548_430_592_079_2 * (x * z),
        0.546_274_215_296_039_6 * (xx - yy),
        -0.590_043_589_926_643_5 * (y * (3.0 * xx - yy)),
        2.890_611_442_640_554 * (x * y * z),
        -0.457_045_799_464_465_8 * (y * (4.0 * zz - xx - yy)),
        0.373_176_332_590_115_4 * (z * (2.0 * zz - 3.0 * xx - 3.0 * yy)),
        -0.457_045_799_464_465_8 * (x * (4.0 * zz - xx - yy)),
        1.445_305_721_320_277 * (z * (xx - yy)),
        -0.590_043_589_926_643_5 * (x * (xx - 3.0 * yy)),
    ]
}

/// The colour seen along the unit direction `d`, from the camera to the Gaussian: the expansion
/// plus 0.5, at least 0, without an upper limit.
#[must_use]
pub fn colour(coefficients: &[[f32; 3]], d: DVec3) -> DVec3 {
    let add = |sum: DVec3, (c, b): (&[f32; 3], f64)| sum + b * DVec3::from(c.map(f64::from));
    let sum = match coefficients {
        // The only one that asks for no direction.
        [constant] => add(DVec3::splat(0.5), (constant, CONSTANT)),
        all => all.iter().zip(basis(d)).fold(DVec3::splat(0.5), add),
    };
    sum.max(DVec3::ZERO)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Directions of a Fibonacci lattice: equal areas, so that means over them
    /// are integrals over the sphere to about 1 / n.
    fn lattice(n: usize) -> impl Iterator<Item = DVec3> {
        let golden = std::f64::consts::PI * (3.0 - 5f64.sqrt());
        (0..n).map(move |i| {
            let z = 1.0 - (2 * i + 1) as f64 / n as f64;
            let r = (1.0 - z * z).sqrt();
            let (s, c) = (golden * i as f64).sin_cos();
            DVec3::new(r * c, r * s, z)
        })
    }

    #[test]
    fn the_basis_is_orthonormal() {
        let n = 40_000;
        let mut gram = [[0.0; 16]; 16];
        for d in lattice(n) {
            let b = basis(d);
            for i in 0..16 {
                for j in 0..16 {
                    gram[i][j] += b[i] * b[j] * 4.0 * std::f64::consts::PI / n as f64;
                }
            }
        }
        for (i, row) in gram.iter().enumerate() {
            for (j, v) in row.iter().enumerate() {
                let expected = f64::from(i == j);
                assert!((v - expected).abs() < 1e-4, "{i} {j}: {v}");
            }
        }
    }

    #[test]
    fn signs_and_clamp_are_the_references() {
        let mut c = [[0.0f32; 3]; 4];
        c[1] = [1.0, 0.0, 0.0];
        c[2] = [0.0, 1.0, 0.0];
        c[3] = [0.0, 0.0, 10.0];
        let k = 0.488_602_511_902_919_9;
        let seen = colour(&c, DVec3::new(0.6, 0.48, 0.64));
        let expected = DVec3::new(0.5 - 0.48 * k, 0.5 + 0.64 * k, 0.0);
        assert!((seen - expected).length() < 1e-12, "{seen}");
        // No upper clamp.
        assert!((colour(&c, DVec3::NEG_X).z - (0.5 + 10.0 * k)).abs() < 1e-12);
    }
}
