//! Tabulated functions of one number, for those that are evaluated often.

/// A function over an interval, tabulated at evenly spaced points and linear between them.
pub(super) struct Curve {
    from: f64,
    per_unit: f64,
    /// The value at each point, and the difference to the next.
    points: Vec<[f64; 2]>,
}

impl Curve {
    /// Tabulates `function` over `range`, which ascends, in `pieces` pieces.
    pub(super) fn new(range: [f64; 2], pieces: u32, function: impl Fn(f64) -> f64) -> Self {
        let [from, to] = range;
        let at = |i: u32| function(from + (to - from) * f64::from(i) / f64::from(pieces));
        let piece = |i: u32| [at(i), at(i + 1) - at(i)];
        Self {
            from,
            per_unit: f64::from(pieces) / (to - from),
            points: (0..pieces).map(piece).collect(),
        }
    }

    /// The value at `x`, which is clamped to the interval.
    pub(super) fn at(&self, x: f64) -> f64 {
        let last = self.points.len() - 1;
        let place = ((x - self.from) * self.per_unit).clamp(0.0, self.points.len() as f64);
        let piece = (place as usize).min(last);
        let [value, growth] = self.points[piece];
        value + growth * (place - piece as f64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_curve_is_exact_at_its_points_and_near_between() {
        let curve = Curve::new([-1.0, 1.0], 1024, f64::sin);
        for i in 0..=4096 {
            let x = -1.0 + f64::from(i) / 2048.0;
            let error = (curve.at(x) - x.sin()).abs();
            let limit = if i % 4 == 0 { 1e-15 } else { 5e-7 };
            assert!(error <= limit, "{x}: {error}");
        }
        assert!((curve.at(5.0) - 1f64.sin()).abs() < 1e-15);
        assert_eq!(curve.at(-5.0), (-1f64).sin());
    }
}
