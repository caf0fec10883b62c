//! Whole numbers in any notation: `4` and `4.0` are the same.

use std::fmt;

use serde::Deserialize;
use serde::de::{Deserializer, Error, Unexpected, Visitor};

struct Whole(u32);

impl<'de> Deserialize<'de> for Whole {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Numbers;
        impl Visitor<'_> for Numbers {
            type Value = Whole;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a whole number")
            }

            fn visit_u64<E: Error>(self, value: u64) -> Result<Whole, E> {
                let wrong = |_| E::invalid_value(Unexpected::Unsigned(value), &self);
                u32::try_from(value).map(Whole).map_err(wrong)
            }

            fn visit_i64<E: Error>(self, value: i64) -> Result<Whole, E> {
                let wrong = |_| E::invalid_value(Unexpected::Signed(value), &self);
                u32::try_from(value).map(Whole).map_err(wrong)
            }

            fn visit_f64<E: Error>(self, value: f64) -> Result<Whole, E> {
                if value.fract() == 0.0 && (0.0..=f64::from(u32::MAX)).contains(&value) {
                    return Ok(Whole(value as u32));
                }
                Err(E::invalid_value(Unexpected::Float(value), &self))
            }
        }
        // Whatever it is, so that another kind of value can be told.
        deserializer.deserialize_any(Numbers)
    }
}

pub(super) fn whole<'de, D: Deserializer<'de>>(deserializer: D) -> Result<u32, D::Error> {
    Whole::deserialize(deserializer).map(|whole| whole.0)
}

pub(super) fn maybe_whole<'de, D: Deserializer<'de>>(
    deserializer: D,
) -> Result<Option<u32>, D::Error> {
    Option::<Whole>::deserialize(deserializer).map(|whole| whole.map(|whole| whole.0))
}
