//! Hard cases at the unit. In each the obvious form fails and ours holds on the same rounded
//! inputs, against exact integers or numbers of 256 bits, with a tolerance that follows from the
//! formats. Their table is in docs/explanation/hard-cases.md, made by this suite and compared with
//! it. Pictures, Verilog and system of the same cases are in the root package's tests/hard_cases.
#![allow(clippy::unwrap_used, clippy::panic)]

mod accumulators;
mod compositing;
mod covariance;
mod exact;
mod exponential;
mod fog;
mod hashing;
mod ordering;
mod projection;
mod sampling;
mod search;
mod splat_unit;
mod table;
mod warping;

/// A hard case with the errors of the obvious form and of ours, in one unit.
#[derive(Debug, Clone, PartialEq)]
struct Case {
    /// Name of the case.
    name: &'static str,
    /// The obvious form.
    naive: &'static str,
    /// Unit of the errors.
    unit: &'static str,
    /// Error of the obvious form; infinite if its result is NaN.
    fails: Worst,
    /// Upper bound of our error.
    bound: f64,
    /// Origin of the bound.
    from: &'static str,
    /// Our error.
    ours: Worst,
}

impl Case {
    /// Checks that our form keeps the bound and the obvious form does not.
    fn holds(&self) {
        let (fails, ours) = (self.fails.0, self.ours.0);
        println!(
            "{}: {ours:e} of {:e} {}, {} {fails:e}",
            self.name, self.bound, self.unit, self.naive
        );
        assert!(
            ours <= self.bound,
            "{}: off by {ours:e} {}, at most {:e} ({})",
            self.name,
            self.unit,
            self.bound,
            self.from
        );
        assert!(
            fails > self.bound,
            "{}: {} is off by {fails:e} {} and keeps to the bound: the case does not bite",
            self.name,
            self.naive,
            self.unit
        );
    }
}

/// The largest error seen.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Worst(f64);

impl Worst {
    /// Adds an error; NaN counts as infinite.
    fn see(&mut self, error: f64) {
        let error = error.abs();
        self.0 = self
            .0
            .max(if error.is_nan() { f64::INFINITY } else { error });
    }

    /// Counts wrong results.
    fn count(&mut self, wrong: bool) {
        self.0 += f64::from(u8::from(wrong));
    }

    /// The largest of some errors.
    fn of(errors: impl IntoIterator<Item = f64>) -> Self {
        let mut worst = Self::default();
        errors.into_iter().for_each(|e| worst.see(e));
        worst
    }
}

/// Defines a file's cases: `all` of them, and a test for each.
macro_rules! cases {
    ($($name:ident),+ $(,)?) => {
        pub(super) fn all() -> Vec<crate::hard_cases::Case> {
            vec![$($name()),+]
        }

        mod holds {
            $(#[test]
            fn $name() {
                super::$name().holds();
            })+
        }
    };
}
use cases;

/// A fixed sequence of pseudo-random numbers, 0 to 1.
struct Draws(u64);

impl Draws {
    fn next(&mut self) -> f64 {
        // Knuth's multiplier; the high bits are good.
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        (self.0 >> 11) as f64 / 2f64.powi(53)
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.next()
    }
}
