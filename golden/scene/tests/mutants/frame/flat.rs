//! Binary layouts: fields at known offsets, and arrays of numbers of known widths.

use super::Rng;

/// The type of a field.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    /// A whole number of so many bytes, little-endian.
    Whole(usize),
    /// A number of 4 bytes.
    Float,
    /// A number of 8 bytes.
    Double,
    /// A number of 2 bytes.
    Half,
}

impl Kind {
    pub(crate) const fn bytes(self) -> usize {
        match self {
            Self::Whole(bytes) => bytes,
            Self::Half => 2,
            Self::Float => 4,
            Self::Double => 8,
        }
    }

    /// Overwrites the field with another number.
    pub(crate) fn change(self, place: &mut [u8], rng: &mut Rng) {
        match self {
            Self::Whole(bytes) => {
                let mut all = [0; 16];
                all[..bytes].copy_from_slice(place);
                let near = u128::from_le_bytes(all) as i128;
                place.copy_from_slice(&rng.integer(near).to_le_bytes()[..bytes]);
            }
            Self::Half => {
                let near = half::f16::from_le_bytes([place[0], place[1]]);
                let value = half::f16::from_f64(rng.float(near.into()));
                place.copy_from_slice(&value.to_le_bytes());
            }
            Self::Float => {
                let mut all = [0; 4];
                all.copy_from_slice(place);
                let value = rng.float(f32::from_le_bytes(all).into()) as f32;
                place.copy_from_slice(&value.to_le_bytes());
            }
            Self::Double => {
                let mut all = [0; 8];
                all.copy_from_slice(place);
                let value = rng.float(f64::from_le_bytes(all));
                place.copy_from_slice(&value.to_le_bytes());
            }
        }
    }
}

/// Writes another number over field `at` of an array of equal ones.
pub(crate) fn number(bytes: &mut [u8], kind: Kind, rng: &mut Rng) {
    let count = bytes.len() / kind.bytes();
    if count > 0 {
        let at = rng.below(count) * kind.bytes();
        kind.change(&mut bytes[at..at + kind.bytes()], rng);
    }
}

/// Another header: one of its fields, each at an offset.
pub(crate) fn field(bytes: &mut [u8], fields: &[(usize, Kind)], rng: &mut Rng) {
    let (at, kind) = *rng.pick(fields);
    if let Some(place) = bytes.get_mut(at..at + kind.bytes()) {
        kind.change(place, rng);
    }
}

/// Changes an array of numbers of one of these widths, or its length.
pub(crate) fn change(bytes: &mut Vec<u8>, rng: &mut Rng, widths: &[usize]) {
    let width = *rng.pick(widths);
    match rng.below(10) {
        0 => bytes.truncate(bytes.len().saturating_sub(width)),
        1 => bytes.extend(std::iter::repeat_n(0, width)),
        2 => rng.damage(bytes),
        3 => bytes.fill(0),
        4 => bytes.fill(255),
        5 => {
            // One record over and over.
            let first: Vec<u8> = bytes.iter().take(width).copied().collect();
            bytes
                .iter_mut()
                .zip(first.iter().cycle())
                .for_each(|(own, v)| *own = *v);
        }
        _ => {
            let kind = match width {
                2 => Kind::Half,
                4 => Kind::Float,
                8 => Kind::Double,
                _ => Kind::Whole(1),
            };
            number(bytes, kind, rng);
        }
    }
}
