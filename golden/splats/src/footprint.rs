//! The 2D footprint of a projected Gaussian, computed without cancellation.
//!
//! The projected covariance is `M M^T + d I`, with the 2 x 3 factor `M` of the projection and the
//! dilation `d`. Its determinant is the sum of the squared 2 x 2 minors of `M`, plus
//! `d tr(M M^T) + d^2`. All terms are positive, whereas `xx yy - xy^2` loses every digit on needles. The
//! factors of the inverse follow from it without a subtraction, and the exponent, minus half a sum
//! of two squares, cannot become positive.

use glam::{DVec2, DVec3};

/// `a b - c d` to within 1.5 units in the last place (Kahan's fused form).
fn determinant_of_products(a: f64, b: f64, c: f64, d: f64) -> f64 {
    let product = c * d;
    let lost = (-c).mul_add(d, product);
    a.mul_add(b, -product) + lost
}

/// A projected Gaussian's shape, in pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Footprint {
    /// Covariance xx, xy, yy, including the dilation.
    pub covariance: [f64; 3],
    /// Its determinant, positive.
    pub determinant: f64,
    /// The determinant without the dilation, not negative.
    pub undilated: f64,
    /// L11, L21, L22: the exponent at an offset (x, y) from the mean is
    /// `-(p^2 + q^2) / 2`, `p = L11 x + L21 y`, `q = L22 y`.
    pub factor: [f64; 3],
}

impl Footprint {
    /// The footprint of covariance `M M^T + dilation I`, from the rows of `M`.
    /// `dilation` must be positive.
    #[must_use]
    pub fn new(row_x: DVec3, row_y: DVec3, dilation: f64) -> Self {
        let (sx, sy) = (row_x.length_squared(), row_y.length_squared());
        let minors = DVec3::new(
            determinant_of_products(row_x.y, row_y.z, row_x.z, row_y.y),
            determinant_of_products(row_x.z, row_y.x, row_x.x, row_y.z),
            determinant_of_products(row_x.x, row_y.y, row_x.y, row_y.x),
        );
        let undilated = minors.length_squared();
        let determinant = undilated + dilation * (sx + sy) + dilation * dilation;
        let (xx, xy, yy) = (sx + dilation, row_x.dot(row_y), sy + dilation);
        let l22 = 1.0 / yy.sqrt();
        let root = determinant.sqrt();
        Self {
            covariance: [xx, xy, yy],
            determinant,
            undilated,
            factor: [yy.sqrt() / root, -(xy / root) * l22, l22],
        }
    }

    /// The fraction of an opacity that an antialiased model keeps: the ratio of the areas before
    /// and after dilation, `sqrt(det / det dilated)`. Both determinants are sums of squares, so
    /// that it is accurate for needles and for discs seen from the side, where `xx yy - xy^2` of
    /// the covariance is only rounding error.
    #[must_use]
    pub fn kept(&self) -> f64 {
        (self.undilated / self.determinant).sqrt()
    }

    /// Both eigenvalues of the covariance, the larger first. The smaller is the determinant
    /// divided by the larger, not a difference.
    #[must_use]
    pub fn eigenvalues(&self) -> [f64; 2] {
        let [xx, xy, yy] = self.covariance;
        let large = f64::midpoint(xx, yy) + ((xx - yy) / 2.0).hypot(xy);
        [large, self.determinant / large]
    }

    /// The larger eigenvalue by the formula of the reference rasteriser, with at least 0.1 under
    /// its square root.
    #[must_use]
    pub(crate) fn reference_eigenvalue(&self) -> f64 {
        let [xx, xy, yy] = self.covariance;
        let root = ((xx - yy) / 2.0).hypot(xy);
        f64::midpoint(xx, yy) + root.max(0.1f64.sqrt())
    }

    /// The squared distance `p^2 + q^2` at an offset from the mean.
    #[must_use]
    pub(crate) fn distance_squared(&self, offset: DVec2) -> f64 {
        let [l11, l21, l22] = self.factor;
        let p = l11 * offset.x + l21 * offset.y;
        let q = l22 * offset.y;
        p * p + q * q
    }

    /// The least [`Footprint::distance_squared`] over a box of offsets.
    #[must_use]
    pub(crate) fn distance_to_box(&self, low: DVec2, high: DVec2) -> f64 {
        if low.x <= 0.0 && low.y <= 0.0 && high.x >= 0.0 && high.y >= 0.0 {
            return 0.0;
        }
        let [xx, xy, yy] = self.covariance;
        // Along a line of constant x the least distance is at y = x xy / xx,
        // and the distance is convex, so clamping to the edge is exact.
        let on_x = |x: f64| {
            let y = (x * (xy / xx)).clamp(low.y, high.y);
            self.distance_squared(DVec2::new(x, y))
        };
        let on_y = |y: f64| {
            let x = (y * (xy / yy)).clamp(low.x, high.x);
            self.distance_squared(DVec2::new(x, y))
        };
        on_x(low.x)
            .min(on_x(high.x))
            .min(on_y(low.y))
            .min(on_y(high.y))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// A needle of `length` pixels at `angle`, no thickness of its own.
    fn needle(length: f64, angle: f64) -> Footprint {
        let (s, c) = angle.sin_cos();
        Footprint::new(
            DVec3::new(length * c, 0.0, 0.0),
            DVec3::new(length * s, 0.0, 0.0),
            0.3,
        )
    }

    #[test]
    fn the_fused_difference_holds_where_the_plain_one_fails() {
        // Exact in 128-bit integers: a = b = 2^27 + 1, c d = a^2 - 1.
        let a = f64::from((1 << 27) + 1);
        let (c, d) = (a + 1.0, a - 1.0);
        assert_eq!(determinant_of_products(a, a, c, d), 1.0);
        assert_ne!(a * a - c * d, 1.0);
    }

    #[test]
    fn f32_determinants_of_rounded_needles_need_the_fused_form() {
        // Same rounded f32 inputs for all; the oracle is exact in f64.
        let fused = |a: f32, b: f32, c: f32| {
            let w = b * b;
            let e = (-b).mul_add(b, w);
            a.mul_add(c, -w) + e
        };
        let (mut worst_naive, mut worst_fused) = (0.0f64, 0.0f64);
        for i in 1..2000 {
            let angle = f64::from(i) * 1.57 / 2000.0;
            let [xx, xy, yy] = needle(200.0, angle).covariance.map(|v| v as f32);
            let exact = f64::from(xx) * f64::from(yy) - f64::from(xy) * f64::from(xy);
            let off = |v: f32| (f64::from(v) / exact - 1.0).abs();
            worst_naive = worst_naive.max(off(xx * yy - xy * xy));
            worst_fused = worst_fused.max(off(fused(xx, xy, yy)));
        }
        assert!(worst_naive > 1e-3, "{worst_naive}");
        assert!(worst_fused < 1.5 * f64::from(f32::EPSILON), "{worst_fused}");
    }

    #[test]
    fn a_long_needle_keeps_its_determinant_and_small_eigenvalue() {
        // Length 1e9: eigenvalues 1e18 + 0.3 and exactly 0.3.
        let f = needle(1e9, 0.7);
        let [xx, xy, yy] = f.covariance;
        let expected = 0.3 * (1e18 + 0.3);
        assert!((f.determinant / expected - 1.0).abs() < 1e-14);
        assert!((f.eigenvalues()[1] - 0.3).abs() < 1e-14);
        let naive = xx * yy - xy * xy;
        assert!((naive / expected - 1.0).abs() > 1.0, "{naive}");
        let mid = f64::midpoint(xx, yy);
        let naive_small = mid - (mid * mid - f.determinant).max(0.0).sqrt();
        assert!((naive_small - 0.3).abs() > 0.2, "{naive_small}");
        // The form stays a form: 1 / 0.3 across the needle, one pixel away.
        let across = f.distance_squared(DVec2::new(-0.7f64.sin(), 0.7f64.cos()));
        assert!((across * 0.3 - 1.0).abs() < 1e-6, "{across}");
    }

    #[test]
    fn the_small_eigenvalue_in_f32_fails_as_a_difference() {
        let mut worst = 0.0f64;
        for i in 1..100 {
            let f = needle(2000.0, f64::from(i) * 0.0157);
            let [xx, xy, yy] = f.covariance.map(|v| v as f32);
            let mid = 0.5 * (xx + yy);
            let naive = mid - (mid * mid - (xx * yy - xy * xy)).max(0.0).sqrt();
            worst = worst.max((f64::from(naive) - 0.3).abs());
            assert!((f.eigenvalues()[1] - 0.3).abs() < 1e-12);
        }
        // A quarter of the value.
        assert!(worst > 0.05, "{worst}");
    }

    /// A disc of 600 pixels that is seen from the side, a thousandth of a pixel thick, at an angle:
    /// its area is that of an ellipse, 600 times 0.001, and the covariance's determinant as
    /// `xx yy - xy^2` has no digit of it.
    #[test]
    fn the_kept_part_of_flat_ellipses_needs_the_minors() {
        let (length, width) = (600.0f64, 1e-3f64);
        let mut worst = 0.0f64;
        for i in 1..40 {
            let (s, c) = (f64::from(i) * 0.0377).sin_cos();
            let f = Footprint::new(
                DVec3::new(length * c, -width * s, 0.0),
                DVec3::new(length * s, width * c, 0.0),
                0.3,
            );
            let dilated = (length * length + 0.3) * (width * width + 0.3);
            let exact = length * width / dilated.sqrt();
            assert!(
                (f.kept() / exact - 1.0).abs() < 1e-9,
                "{} {exact}",
                f.kept()
            );
            // As renderers have it, of a covariance in 32 bits.
            let [xx, xy, yy] = [
                f.covariance[0] - 0.3,
                f.covariance[1],
                f.covariance[2] - 0.3,
            ];
            let [xx, xy, yy] = [xx as f32, xy as f32, yy as f32];
            let naive = (f64::from(xx * yy - xy * xy).max(0.0) / f.determinant).sqrt();
            worst = worst.max((naive / exact - 1.0).abs());
        }
        assert!(worst > 0.9, "{worst}");
        let point = Footprint::new(DVec3::ZERO, DVec3::ZERO, 0.3);
        assert_eq!(point.kept(), 0.0);
    }

    proptest! {
        #[test]
        fn factors_invert_the_covariance(
            a in -1e3f64..1e3, b in -1e3f64..1e3, c in -1e3f64..1e3, d in -1e3f64..1e3,
            x in -50f64..50.0, y in -50f64..50.0
        ) {
            let f = Footprint::new(DVec3::new(a, b, 0.5), DVec3::new(c, d, -0.25), 0.3);
            let [l11, l21, l22] = f.factor;
            // The bound that keeps S1.30 from saturating.
            for l in f.factor {
                prop_assert!(l.abs() <= (1.0f64 / 0.3).sqrt() * (1.0 + 1e-12));
            }
            let [xx, xy, yy] = f.covariance;
            // (L11 x + L21 y)^2 + (L22 y)^2 against the adjugate, where both
            // are well scaled.
            let adjugate = (yy * x * x - 2.0 * xy * x * y + xx * y * y) / f.determinant;
            let form = f.distance_squared(DVec2::new(x, y));
            let scale = (l11 * x).powi(2) + (l21 * y).powi(2) + (l22 * y).powi(2) + 1e-9;
            let lost = (yy * x * x + xx * y * y) / f.determinant;
            prop_assert!((adjugate - form).abs() <= 1e-12 * (scale + lost), "{adjugate} {form}");
            prop_assert!(form >= 0.0);
            let [large, small] = f.eigenvalues();
            prop_assert!(small >= 0.3 * (1.0 - 1e-12) && large >= small * (1.0 - 1e-12));
        }

        #[test]
        fn no_point_of_a_box_is_nearer_than_the_box(
            a in -30f64..30.0, b in -30f64..30.0, c in -30f64..30.0,
            x in -60f64..60.0, y in -60f64..60.0, u in 0f64..=1.0, v in 0f64..=1.0
        ) {
            let f = Footprint::new(DVec3::new(a, b, 0.0), DVec3::new(c, 0.5, 1.0), 0.3);
            let low = DVec2::new(x, y);
            let nearest = f.distance_to_box(low, low + 15.0);
            let inside = f.distance_squared(low + DVec2::new(u, v) * 15.0);
            prop_assert!(nearest <= inside * (1.0 + 1e-9) + 1e-12, "{nearest} {inside}");
        }
    }
}
