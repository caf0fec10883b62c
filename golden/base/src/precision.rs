//! How finely frames are composited where it is not by their renderer's rules.

use thiserror::Error;

/// Cut-offs, widths and levels, in place of those of a renderer's rules and of the
/// hardware's formats. By default all are theirs.
#[derive(Debug, Clone, Copy, PartialEq, Default, serde::Serialize)]
pub struct Precision {
    /// A pixel or a ray stops where less light is left: 1e-6 to 0.5. The rules have 1e-4 of splats,
    /// 1e-3 of voxels, DirectVoxGO and EfficientNeRF, 0.01 of Instant-NGP, 1e-6 of TensoRF.
    pub stop_below: Option<f64>,
    /// Splats are skipped where their alpha is smaller: 4e-4 to 0.5. The rules have 1/255.
    pub alpha_min: Option<f64>,
    /// Fraction bits of transmittances in the hardware's formats, 8 to 20, which they have.
    pub transmittance_bits: Option<u32>,
    /// Fraction bits of the factors of splats' conics in their records, 8 to 30, which they have.
    pub conic_bits: Option<u32>,
    /// Levels of a hash grid whose vertices share entries that are gathered in the hardware's
    /// formats, from the coarsest; the features of finer ones are 0. All, by default.
    pub hashed_levels: Option<u32>,
}

/// A number outside its range.
#[derive(Debug, Clone, PartialEq, Error)]
#[error("{field}: {value}: expected {expected}")]
pub struct PrecisionError {
    /// The number, by its name in a description.
    pub field: &'static str,
    /// Its value.
    pub value: String,
    /// What would be right.
    pub expected: &'static str,
}

impl Precision {
    /// These numbers, and another's where those are given.
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        Self {
            stop_below: other.stop_below.or(self.stop_below),
            alpha_min: other.alpha_min.or(self.alpha_min),
            transmittance_bits: other.transmittance_bits.or(self.transmittance_bits),
            conic_bits: other.conic_bits.or(self.conic_bits),
            hashed_levels: other.hashed_levels.or(self.hashed_levels),
        }
    }

    /// The numbers that are given, by their names in a description's `[render]`.
    #[must_use]
    pub fn given(&self) -> Vec<(&'static str, String)> {
        let text = |v: Option<f64>| v.map(|v| v.to_string());
        let count = |v: Option<u32>| v.map(|v| v.to_string());
        let all = [
            ("stop_below", text(self.stop_below)),
            ("alpha_min", text(self.alpha_min)),
            ("transmittance_bits", count(self.transmittance_bits)),
            ("conic_bits", count(self.conic_bits)),
            ("hashed_levels", count(self.hashed_levels)),
        ];
        let given = all.into_iter();
        given.filter_map(|(name, v)| Some((name, v?))).collect()
    }

    /// Checks the ranges.
    ///
    /// # Errors
    /// The first number outside its range.
    pub fn check(&self) -> Result<(), PrecisionError> {
        let cuts = [
            (
                "render.stop_below",
                self.stop_below,
                1e-6..=0.5,
                "1e-6 to 0.5",
            ),
            // What is past the exponential's range has its last result, exp(-8), and a unit of
            // opacity more: drawn, it would cover its tiles.
            (
                "render.alpha_min",
                self.alpha_min,
                4e-4..=0.5,
                "4e-4, which is above exp(-8), to 0.5",
            ),
        ];
        for (field, given, range, expected) in cuts {
            // Not a number is in no range.
            if let Some(value) = given.filter(|value| !range.contains(value)) {
                return Err(PrecisionError {
                    field,
                    value: value.to_string(),
                    expected,
                });
            }
        }
        let widths = [
            (
                "render.transmittance_bits",
                self.transmittance_bits,
                8..=20,
                "8 to 20",
            ),
            ("render.conic_bits", self.conic_bits, 8..=30, "8 to 30"),
        ];
        for (field, given, range, expected) in widths {
            if let Some(value) = given.filter(|value| !range.contains(value)) {
                return Err(PrecisionError {
                    field,
                    value: value.to_string(),
                    expected,
                });
            }
        }
        Ok(())
    }
}
