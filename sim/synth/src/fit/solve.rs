//! Least squares of relative errors.

use nalgebra::{DMatrix, DVector, DVectorView};
use schemars::JsonSchema;
use serde::Serialize;

use super::terms::{Numbers, Term};

/// A value to fit.
#[derive(Debug, Clone, Copy)]
pub(super) struct Value {
    pub(super) numbers: Numbers,
    pub(super) value: f64,
    /// Denominator of its relative error, above 0.
    pub(super) of: f64,
}

/// A term of a formula and its coefficient.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct Addend {
    /// Term: `1`, or a product of numbers: banks B, ports M, feature bits f, weight bits w,
    /// depth of the FIFO d, banks with a channel a; lanes L, iterations n, bits of an
    /// exponential's result o, accumulator r and constants k, `all` 1 where a lane has all
    /// operations.
    pub term: &'static str,
    /// Its coefficient.
    pub coefficient: f64,
}

/// A sum of terms, each with a coefficient.
#[derive(Debug, Clone)]
pub(super) struct Sum {
    terms: &'static [Term],
    coefficients: Vec<f64>,
}

/// Singular values below this share of the largest belong to terms that the points do not
/// distinguish.
const SINGULAR: f64 = 1e-12;

impl Sum {
    /// The sum with the least squares of relative errors; `None` with fewer values than terms.
    pub(super) fn fit(terms: &'static [Term], values: &[Value]) -> Option<Self> {
        if values.len() < terms.len() {
            return None;
        }
        let (rows, columns) = (values.len(), terms.len());
        let matrix = DMatrix::from_fn(rows, columns, |i, j| {
            (terms[j].of)(&values[i].numbers) / values[i].of
        });
        // Columns of one size: terms are of many orders of magnitude.
        let size = |column: DVectorView<'_, f64>| column.norm().max(f64::MIN_POSITIVE);
        let sizes: Vec<f64> = matrix.column_iter().map(size).collect();
        let even = DMatrix::from_fn(rows, columns, |i, j| matrix[(i, j)] / sizes[j]);
        let svd = even.svd(true, true);
        let least = SINGULAR * svd.singular_values.max();
        let right = DVector::from_fn(rows, |i, _| values[i].value / values[i].of);
        let found = svd.solve(&right, least).ok()?;
        let coefficients = found.iter().zip(&sizes).map(|(c, size)| c / size);
        Some(Self {
            terms,
            coefficients: coefficients.collect(),
        })
    }

    /// Terms with their coefficients.
    pub(super) fn addends(&self) -> Vec<Addend> {
        let terms = self.terms.iter().zip(&self.coefficients);
        terms
            .map(|(term, coefficient)| Addend {
                term: term.name,
                coefficient: *coefficient,
            })
            .collect()
    }

    pub(super) fn at(&self, numbers: &Numbers) -> f64 {
        let values = self.terms.iter().map(|term| (term.of)(numbers));
        values.zip(&self.coefficients).map(|(v, c)| v * c).sum()
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use potamoi_formats::config::Config;

    const TERMS: &[Term] = &[
        Term {
            name: "1",
            of: |_| 1.0,
        },
        Term {
            name: "M B",
            of: Numbers::all,
        },
    ];

    fn values(of: fn(f64) -> f64) -> Vec<Value> {
        let value = |banks: u32| {
            let config = Config::from_toml(&format!("gu.banks = {banks}\n"), "test").unwrap();
            let numbers = Numbers::new(&config, 13);
            let value = of(f64::from(2 * banks));
            let of = value;
            Value { numbers, value, of }
        };
        [4, 8, 16, 64].map(value).to_vec()
    }

    #[test]
    fn what_is_a_sum_of_the_terms_is_found() {
        let values = values(|x| 1e-9 + 3e-6 * x);
        let sum = Sum::fit(TERMS, &values).unwrap();
        for value in &values {
            assert!((sum.at(&value.numbers) / value.value - 1.0).abs() < 1e-9);
        }
        let [one, all] = &sum.addends()[..] else {
            unreachable!("two terms")
        };
        assert_eq!((one.term, all.term), ("1", "M B"));
        assert!((one.coefficient / 1e-9 - 1.0).abs() < 1e-6);
        assert!((all.coefficient / 3e-6 - 1.0).abs() < 1e-9);
    }

    /// Errors are relative: small values count as much as large ones.
    #[test]
    fn relative_errors_are_least() {
        let values = values(|x| x * x);
        let relative = Sum::fit(TERMS, &values).unwrap();
        let plain: Vec<Value> = values.iter().map(|v| Value { of: 1.0, ..*v }).collect();
        let plain = Sum::fit(TERMS, &plain).unwrap();
        let squares = |sum: &Sum| -> f64 {
            let error = |v: &Value| (sum.at(&v.numbers) / v.value - 1.0).powi(2);
            values.iter().map(error).sum()
        };
        assert!(squares(&relative) < 0.1 * squares(&plain));
        for i in 0..TERMS.len() {
            for by in [0.99, 1.01] {
                let mut other = relative.clone();
                other.coefficients[i] *= by;
                assert!(squares(&relative) <= squares(&other));
            }
        }
    }

    #[test]
    fn fewer_values_than_terms_are_too_few() {
        assert!(Sum::fit(TERMS, &values(|x| x)[..1]).is_none());
    }
}
