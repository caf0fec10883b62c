//! The Gaussians of a scene as trained and stored.

mod plausible;
mod turn;

pub(crate) use turn::Placement;

use std::cmp::Ordering;
use std::fmt;

use rayon::prelude::*;
use thiserror::Error;

use potamoi_base::sh;

/// The largest log scale: beyond it a scale overflows 32-bit floats.
pub(crate) const MAX_LOG_SCALE: f32 = 88.0;
/// Values that a thread checks at a time.
const BLOCK: usize = 1 << 14;

/// A property of a Gaussian.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Field {
    /// Centre.
    Mean,
    /// Natural logarithm of the standard deviation along each axis.
    LogScale,
    /// Rotation quaternion.
    Rotation,
    /// Opacity before the sigmoid.
    OpacityLogit,
    /// Spherical-harmonics coefficients.
    Colour,
}

impl fmt::Display for Field {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Mean => "mean",
            Self::LogScale => "log scale",
            Self::Rotation => "rotation",
            Self::OpacityLogit => "opacity logit",
            Self::Colour => "colour coefficient",
        })
    }
}

/// Values that do not form a valid cloud.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum CloudError {
    /// No Gaussians.
    #[error("the cloud has no Gaussian: expected at least one")]
    Empty,
    /// The spherical harmonics have a degree above 3.
    #[error("spherical harmonics of degree {0}: expected 0 to {max}", max = sh::MAX_DEGREE)]
    Degree(usize),
    /// A field does not have one value for each Gaussian.
    #[error("{field}: {found} values, expected {expected}; every Gaussian needs one of each field")]
    Length {
        /// The field.
        field: Field,
        /// Values given.
        found: usize,
        /// Values needed.
        expected: usize,
    },
    /// A value is NaN or infinite where this is not allowed.
    #[error("Gaussian {index}: {field}[{component}] is {value}: expected a finite number")]
    NotFinite {
        /// Index of the Gaussian.
        index: usize,
        /// The field.
        field: Field,
        /// Component of the field.
        component: usize,
        /// The value.
        value: f32,
    },
    /// A scale overflows 32-bit floats.
    #[error(
        "Gaussian {index}: log scale[{component}] is {value}: expected at most {MAX_LOG_SCALE}"
    )]
    Scale {
        /// Index of the Gaussian.
        index: usize,
        /// Component of the scale.
        component: usize,
        /// The value.
        value: f32,
    },
}

/// Gaussians with their parameters before activation, one array a field.
///
/// All values are finite, except opacity logits, where plus and minus infinity mean opacity 1 and
/// 0. Quaternions need not be normalised; a zero quaternion means the identity, as in the rotation
/// formula of the reference rasteriser.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Cloud {
    degree: usize,
    means: Vec<[f32; 3]>,
    log_scales: Vec<[f32; 3]>,
    rotations: Vec<[f32; 4]>,
    opacity_logits: Vec<f32>,
    sh: Vec<[f32; 3]>,
    antialiased: bool,
}

impl Cloud {
    /// A cloud of `means.len()` Gaussians. Quaternions are `w, x, y, z`; `sh` holds `(degree +
    /// 1)^2` RGB coefficients for each Gaussian in turn.
    ///
    /// # Errors
    /// There are no Gaussians, the degree is above 3, fields differ in length, a value is not
    /// finite (opacity logits may be infinite), or a log scale is above 88.
    pub fn new(
        degree: usize,
        means: Vec<[f32; 3]>,
        log_scales: Vec<[f32; 3]>,
        rotations: Vec<[f32; 4]>,
        opacity_logits: Vec<f32>,
        sh: Vec<[f32; 3]>,
    ) -> Result<Self, CloudError> {
        if degree > sh::MAX_DEGREE {
            return Err(CloudError::Degree(degree));
        }
        let count = means.len();
        if count == 0 {
            return Err(CloudError::Empty);
        }
        for (field, found, expected) in [
            (Field::LogScale, log_scales.len(), count),
            (Field::Rotation, rotations.len(), count),
            (Field::OpacityLogit, opacity_logits.len(), count),
            (Field::Colour, sh.len(), count * sh::coefficients(degree)),
        ] {
            if found != expected {
                return Err(CloudError::Length {
                    field,
                    found,
                    expected,
                });
            }
        }
        finite(Field::Mean, 1, &means)?;
        finite(Field::LogScale, 1, &log_scales)?;
        finite(Field::Rotation, 1, &rotations)?;
        finite(Field::Colour, sh::coefficients(degree), &sh)?;
        if let Some(index) = opacity_logits.iter().position(|o| o.is_nan()) {
            return Err(CloudError::NotFinite {
                index,
                field: Field::OpacityLogit,
                component: 0,
                value: f32::NAN,
            });
        }
        for (index, scales) in log_scales.iter().enumerate() {
            if let Some(component) = scales.iter().position(|s| *s > MAX_LOG_SCALE) {
                return Err(CloudError::Scale {
                    index,
                    component,
                    value: scales[component],
                });
            }
        }
        Ok(Self {
            degree,
            means,
            log_scales,
            rotations,
            opacity_logits,
            sh,
            antialiased: false,
        })
    }

    /// Whether the cloud was trained with antialiasing, where the opacity compensates for the area
    /// that the pixel filter adds to a footprint.
    #[must_use]
    pub const fn is_antialiased(&self) -> bool {
        self.antialiased
    }

    /// The same Gaussians with the antialiasing flag set to `antialiased`.
    #[must_use]
    pub const fn antialiased(mut self, antialiased: bool) -> Self {
        self.set_antialiased(antialiased);
        self
    }

    /// Sets the antialiasing flag.
    pub const fn set_antialiased(&mut self, antialiased: bool) {
        self.antialiased = antialiased;
    }

    /// Number of Gaussians, at least one.
    #[must_use]
    #[allow(clippy::len_without_is_empty)]
    pub fn len(&self) -> usize {
        self.means.len()
    }

    /// Degree of the spherical harmonics, 0 to 3.
    #[must_use]
    pub fn degree(&self) -> usize {
        self.degree
    }

    /// Centres in world coordinates.
    #[must_use]
    pub fn means(&self) -> &[[f32; 3]] {
        &self.means
    }

    /// Natural logarithms of the standard deviations along the three axes.
    #[must_use]
    pub fn log_scales(&self) -> &[[f32; 3]] {
        &self.log_scales
    }

    /// Quaternions `w, x, y, z`, as stored.
    #[must_use]
    pub fn rotations(&self) -> &[[f32; 4]] {
        &self.rotations
    }

    /// Opacities before the sigmoid.
    #[must_use]
    pub fn opacity_logits(&self) -> &[f32] {
        &self.opacity_logits
    }

    /// The `(degree + 1)^2` RGB coefficients of Gaussian `index`.
    #[must_use]
    pub fn sh(&self, index: usize) -> &[[f32; 3]] {
        let n = sh::coefficients(self.degree);
        &self.sh[index * n..(index + 1) * n]
    }

    /// Smallest and largest coordinates of the centres.
    #[must_use]
    pub fn bounds(&self) -> [[f32; 3]; 2] {
        let mut low = [f32::INFINITY; 3];
        let mut high = [f32::NEG_INFINITY; 3];
        for mean in &self.means {
            for axis in 0..3 {
                low[axis] = low[axis].min(mean[axis]);
                high[axis] = high[axis].max(mean[axis]);
            }
        }
        [low, high]
    }

    /// The same Gaussians with view-independent colours, given as one finite coefficient of the
    /// constant basis function each.
    pub fn recoloured(&self, constants: Vec<[f32; 3]>) -> Self {
        debug_assert_eq!(constants.len(), self.len());
        Self {
            degree: 0,
            sh: constants,
            ..self.clone()
        }
    }

    /// The Gaussians at the indices `order`, in that order.
    ///
    /// # Errors
    /// `order` is empty or has an index out of range.
    pub fn select(&self, order: &[usize]) -> Result<Self, CloudError> {
        if let Some(&found) = order.iter().find(|i| **i >= self.len()) {
            return Err(CloudError::Length {
                field: Field::Mean,
                found,
                expected: self.len(),
            });
        }
        let sh = order
            .iter()
            .flat_map(|&i| self.sh(i).iter().copied())
            .collect();
        Self::new(
            self.degree,
            order.iter().map(|&i| self.means[i]).collect(),
            order.iter().map(|&i| self.log_scales[i]).collect(),
            order.iter().map(|&i| self.rotations[i]).collect(),
            order.iter().map(|&i| self.opacity_logits[i]).collect(),
            sh,
        )
        .map(|cloud| cloud.antialiased(self.antialiased))
    }

    /// The Gaussians of all clouds, one cloud after another, with coefficients of 0 where a cloud has a
    /// lower degree than another. They are antialiased if the first cloud is.
    ///
    /// # Errors
    /// There is no cloud.
    pub(crate) fn joined(mut parts: Vec<Self>) -> Result<Self, CloudError> {
        if parts.len() == 1 {
            return parts.pop().ok_or(CloudError::Empty);
        }
        let degree = parts.iter().map(Self::degree).max();
        let degree = degree.ok_or(CloudError::Empty)?;
        let each = sh::coefficients(degree);
        let mut all = Self {
            degree,
            means: vec![],
            log_scales: vec![],
            rotations: vec![],
            opacity_logits: vec![],
            sh: vec![],
            antialiased: parts.first().is_some_and(Self::is_antialiased),
        };
        for part in parts {
            for own in part.sh.chunks(sh::coefficients(part.degree)) {
                all.sh.extend(own);
                all.sh.resize(all.sh.len() + each - own.len(), [0.0; 3]);
            }
            all.means.extend(part.means);
            all.log_scales.extend(part.log_scales);
            all.rotations.extend(part.rotations);
            all.opacity_logits.extend(part.opacity_logits);
        }
        Ok(all)
    }

    /// Orders two Gaussians by all their values: a tie-break that does not depend on their
    /// positions in the file. Gaussians that compare equal are interchangeable.
    #[must_use]
    pub fn compare_content(&self, a: usize, b: usize) -> Ordering {
        let lexical = |x: &[f32], y: &[f32]| {
            x.iter()
                .zip(y)
                .map(|(p, q)| p.total_cmp(q))
                .find(|o| o.is_ne())
                .unwrap_or(Ordering::Equal)
        };
        lexical(&self.means[a], &self.means[b])
            .then_with(|| lexical(&self.log_scales[a], &self.log_scales[b]))
            .then_with(|| lexical(&self.rotations[a], &self.rotations[b]))
            .then_with(|| self.opacity_logits[a].total_cmp(&self.opacity_logits[b]))
            .then_with(|| lexical(self.sh(a).as_flattened(), self.sh(b).as_flattened()))
    }
}

fn finite<const N: usize>(
    field: Field,
    per_gaussian: usize,
    values: &[[f32; N]],
) -> Result<(), CloudError> {
    let wrong = |value: &[f32; N]| value.iter().position(|v| !v.is_finite());
    // A block without a branch first; the first value that is wrong is told, whichever thread was first.
    let all = values.par_chunks(BLOCK).enumerate();
    let found = all.find_map_first(|(block, own)| {
        let values = own.as_flattened().iter();
        let is_wrong = values.fold(false, |any, v| any | !v.is_finite());
        let first = || own.iter().position(|value| wrong(value).is_some());
        is_wrong.then(first).flatten().map(|at| block * BLOCK + at)
    });
    match found {
        None => Ok(()),
        Some(i) => {
            let c = wrong(&values[i]).unwrap_or(0);
            Err(CloudError::NotFinite {
                index: i / per_gaussian,
                field,
                component: i % per_gaussian * N + c,
                value: values[i][c],
            })
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn two() -> Cloud {
        Cloud::new(
            0,
            vec![[0.0; 3], [1.0, -2.0, 3.0]],
            vec![[0.0; 3]; 2],
            vec![[1.0, 0.0, 0.0, 0.0]; 2],
            vec![f32::INFINITY, f32::NEG_INFINITY],
            vec![[0.5; 3]; 2],
        )
        .unwrap()
    }

    #[test]
    fn infinite_opacity_logits_are_legal_and_nan_is_not() {
        let c = two();
        assert_eq!(c.bounds(), [[0.0, -2.0, 0.0], [1.0, 0.0, 3.0]]);
        let nan = Cloud::new(
            0,
            vec![[0.0; 3]],
            vec![[0.0; 3]],
            vec![[0.0; 4]],
            vec![f32::NAN],
            vec![[0.0; 3]],
        );
        assert!(matches!(
            nan,
            Err(CloudError::NotFinite {
                field: Field::OpacityLogit,
                ..
            })
        ));
    }

    #[test]
    fn every_field_is_checked_and_named() {
        let build = |degree, n: [usize; 4], bad: f32, scale: f32| {
            Cloud::new(
                degree,
                vec![[0.0; 3]; 2],
                vec![[scale; 3]; n[0]],
                vec![[0.0, 0.0, bad, 0.0]; n[1]],
                vec![0.0; n[2]],
                vec![[0.0; 3]; n[3]],
            )
        };
        let text = |r: Result<Cloud, CloudError>| r.unwrap_err().to_string();
        assert!(build(1, [2, 2, 2, 8], 0.0, 0.0).is_ok());
        assert!(text(build(4, [2, 2, 2, 50], 0.0, 0.0)).contains("degree 4"));
        assert!(text(build(1, [1, 2, 2, 8], 0.0, 0.0)).contains("log scale: 1 values, expected 2"));
        assert!(text(build(1, [2, 2, 2, 2], 0.0, 0.0)).contains("colour coefficient: 2"));
        assert!(text(build(1, [2, 2, 2, 8], f32::NAN, 0.0)).contains("Gaussian 0: rotation[2]"));
        assert!(text(build(1, [2, 2, 2, 8], 0.0, 89.0)).contains("log scale[0] is 89"));
        assert_eq!(
            Cloud::new(0, vec![], vec![], vec![], vec![], vec![]),
            Err(CloudError::Empty)
        );
    }

    #[test]
    fn selecting_permutes_and_refuses_what_is_not_there() {
        let c = two();
        let swapped = c.select(&[1, 0]).unwrap();
        assert_eq!(swapped.select(&[1, 0]).unwrap(), c);
        assert_ne!(swapped, c);
        assert!(c.select(&[2]).is_err());
        assert_eq!(c.compare_content(0, 1), Ordering::Less);
        assert_eq!(swapped.compare_content(0, 1), Ordering::Greater);
        assert_eq!(c.compare_content(1, 1), Ordering::Equal);
    }
}
