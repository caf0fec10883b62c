//! Thresholds, widths and levels that override a renderer's rules.
//!
//! A rendering knob is a field of [`Precision`] and a row of [`NUMBERS`]: descriptions, refusals
//! and reports follow from the row. Its renderer must honour the field.

use std::ops::RangeInclusive;

use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::file_keys::Fate::Honoured;
use crate::file_keys::Key;

/// Thresholds, widths and levels in place of those of a renderer's rules and of the hardware's
/// formats. By default none is overridden.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Precision {
    /// Early-termination threshold (transmittance). The rules have 1e-4 for splats, 1e-3 for
    /// voxels, DirectVoxGO and EfficientNeRF, 0.01 for Instant-NGP, 1e-6 for TensoRF.
    pub stop_below: Option<f64>,
    /// Alpha threshold: splats with a smaller alpha are skipped. The rules have 1/255.
    pub alpha_min: Option<f64>,
    /// Fraction bits of transmittances in the hardware's formats, by default 20.
    pub transmittance_bits: Option<u32>,
    /// Fraction bits of the conic factors in splat records, by default 30.
    pub conic_bits: Option<u32>,
    /// Number of hashed levels that are gathered in the hardware's formats, from the coarsest on;
    /// the features of finer ones are 0. By default all.
    pub hashed_levels: Option<u32>,
}

/// Every number of a [`Precision`], in the order of its fields.
pub const NUMBERS: [Number; 5] = [
    Number {
        key: key(
            "render.stop_below",
            "the transmittance at which a pixel stops",
        ),
        place: Accessor::Real(|p| &mut p.stop_below, 1e-6..=0.5),
        expected: "1e-6 to 0.5",
        models: &[Models::Splats, Models::Voxels, Models::Fields],
    },
    Number {
        key: key(
            "render.alpha_min",
            "the alpha below which splats are skipped",
        ),
        // What is past the exponential's range has its last result, exp(-8), and a unit of
        // opacity more: drawn, it would cover its tiles.
        place: Accessor::Real(|p| &mut p.alpha_min, 4e-4..=0.5),
        expected: "4e-4, which is above exp(-8), to 0.5",
        models: &[Models::Splats],
    },
    Number {
        key: key(
            "render.transmittance_bits",
            "fraction bits of transmittances",
        ),
        place: Accessor::Count(|p| &mut p.transmittance_bits, 8..=20),
        expected: "8 to 20",
        models: &[Models::Splats, Models::Voxels],
    },
    Number {
        key: key(
            "render.conic_bits",
            "fraction bits of the factors of conics",
        ),
        place: Accessor::Count(|p| &mut p.conic_bits, 8..=30),
        expected: "8 to 30",
        models: &[Models::Splats],
    },
    Number {
        key: key("render.hashed_levels", "hashed levels that are gathered"),
        // As many as the model has, which the scene checks.
        place: Accessor::Count(|p| &mut p.hashed_levels, 0..=u32::MAX),
        expected: "a whole number",
        models: &[Models::Splats, Models::Voxels, Models::Fields],
    },
];

const fn key(name: &'static str, about: &'static str) -> Key {
    let fate = Honoured;
    Key { name, fate, about }
}

/// A number of a [`Precision`]: its name in descriptions, its range, and its purpose.
#[derive(Debug, Clone)]
pub struct Number {
    /// Its name in a description, including the section.
    pub key: Key,
    place: Accessor,
    /// Its range in words.
    expected: &'static str,
    /// Models whose renderers honour it.
    models: &'static [Models],
}

/// Accessor of a number in a [`Precision`], with its range.
#[derive(Debug, Clone)]
enum Accessor {
    Real(fn(&mut Precision) -> &mut Option<f64>, RangeInclusive<f64>),
    Count(fn(&mut Precision) -> &mut Option<u32>, RangeInclusive<u32>),
}

/// Models by their compositing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Models {
    /// Gaussians.
    Splats,
    /// Stored voxels.
    Voxels,
    /// Fields with a perceptron or harmonics.
    Fields,
}

impl Models {
    /// Whether their renderer honours the number with this name in the `[render]` section.
    #[must_use]
    pub fn honour(self, name: &str) -> bool {
        NUMBERS
            .iter()
            .any(|number| number.name() == name && number.models.contains(&self))
    }

    const fn name(self) -> &'static str {
        match self {
            Self::Splats => "splats",
            Self::Voxels => "stored voxels",
            Self::Fields => "fields",
        }
    }
}

impl Number {
    /// Its name in the `[render]` section.
    #[must_use]
    pub fn name(&self) -> &'static str {
        self.key
            .name
            .strip_prefix("render.")
            .unwrap_or(self.key.name)
    }

    /// Its value as text, and whether it is in its range.
    fn given(&self, mut precision: Precision) -> Option<(String, bool)> {
        match &self.place {
            Accessor::Real(place, range) => {
                // Not a number is in no range.
                place(&mut precision).map(|v| (v.to_string(), range.contains(&v)))
            }
            Accessor::Count(place, range) => {
                place(&mut precision).map(|v| (v.to_string(), range.contains(&v)))
            }
        }
    }
}

/// A number is out of range or does not apply to the model.
#[derive(Debug, Clone, PartialEq, Error)]
#[error("{field}: {value}: expected {expected}")]
pub struct PrecisionError {
    /// Name of the number in a description.
    pub field: &'static str,
    /// Its value.
    pub value: String,
    /// Allowed values.
    pub expected: String,
}

impl Precision {
    /// No overrides.
    pub const RULES: Self = Self {
        stop_below: None,
        alpha_min: None,
        transmittance_bits: None,
        conic_bits: None,
        hashed_levels: None,
    };

    /// These numbers, overridden by the given numbers of another.
    #[must_use]
    pub fn and(mut self, mut other: Self) -> Self {
        for number in &NUMBERS {
            match number.place {
                Accessor::Real(place, _) => {
                    *place(&mut self) = place(&mut other).or(*place(&mut self));
                }
                Accessor::Count(place, _) => {
                    *place(&mut self) = place(&mut other).or(*place(&mut self));
                }
            }
        }
        self
    }

    /// The numbers that are given, with their names in the `[render]` section.
    #[must_use]
    pub fn given(&self) -> Vec<(&'static str, String)> {
        let given = |number: &Number| Some((number.name(), number.given(*self)?.0));
        NUMBERS.iter().filter_map(given).collect()
    }

    /// Checks the ranges.
    ///
    /// # Errors
    /// The first number out of range.
    pub fn check(&self) -> Result<(), PrecisionError> {
        for number in &NUMBERS {
            if let Some((value, false)) = number.given(*self) {
                return Err(PrecisionError {
                    field: number.key.name,
                    value,
                    expected: number.expected.to_owned(),
                });
            }
        }
        Ok(())
    }

    /// Checks that the renderer of these models honours all given numbers.
    ///
    /// # Errors
    /// The first number that it does not honour.
    pub fn check_for(&self, models: Models) -> Result<(), PrecisionError> {
        for number in NUMBERS.iter().filter(|n| !n.models.contains(&models)) {
            if let Some((value, _)) = number.given(*self) {
                let fit = NUMBERS.iter().filter(|n| n.models.contains(&models));
                // Levels are checked against those that the model has.
                let fit = fit
                    .map(Number::name)
                    .filter(|name| *name != "hashed_levels");
                let fit: Vec<_> = fit.collect();
                return Err(PrecisionError {
                    field: "render",
                    value: format!("{} = {value}", number.name()),
                    expected: format!("{} alone, of {}", fit.join(" and "), models.name()),
                });
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    /// A field without a row would be read and then checked, joined and told nowhere.
    #[test]
    fn every_field_has_a_row_that_leads_to_it() {
        let fields = serde_json::to_value(Precision::default()).unwrap();
        let fields: Vec<_> = fields.as_object().unwrap().keys().cloned().collect();
        let rows: Vec<_> = NUMBERS.iter().map(Number::name).collect();
        assert_eq!(fields, rows);
        assert_eq!(Precision::RULES, Precision::default());
        for name in rows {
            let number = serde_json::json!({ name: 1 });
            let own: Precision = serde_json::from_value(number).unwrap();
            assert_eq!(own.given(), [(name, "1".to_owned())]);
            assert_eq!(Precision::default().and(own), own);
            assert_eq!(own.and(Precision::default()), own);
        }
    }

    #[test]
    fn numbers_are_held_to_their_range_and_their_models() {
        let own = Precision {
            conic_bits: Some(12),
            ..Precision::default()
        };
        assert_eq!(own.check(), Ok(()));
        assert_eq!(own.check_for(Models::Splats), Ok(()));
        let said = own.check_for(Models::Voxels).unwrap_err().to_string();
        assert_eq!(
            said,
            "render: conic_bits = 12: expected stop_below and transmittance_bits alone, of stored voxels"
        );
        let wide = Precision {
            conic_bits: Some(31),
            ..Precision::default()
        };
        let said = wide.check().unwrap_err().to_string();
        assert_eq!(said, "render.conic_bits: 31: expected 8 to 30");
        let lost = Precision {
            alpha_min: Some(f64::NAN),
            ..Precision::default()
        };
        assert!(lost.check().is_err());
    }
}
