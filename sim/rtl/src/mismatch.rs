//! First difference between hardware and prediction.

use schemars::JsonSchema;
use serde::Serialize;
use thiserror::Error;

/// The first difference of a run.
#[derive(Debug, Clone, PartialEq, Eq, Error, Serialize, JsonSchema)]
#[error("{module}, cycle {cycle}: {signal} is {found}, expected {expected} ({place})")]
pub struct Mismatch {
    /// The unit.
    pub module: &'static str,
    /// Cycles since the first after reset.
    pub cycle: u64,
    /// Port, and the part of it.
    pub signal: String,
    /// Value by the golden model or the cycle model.
    pub expected: String,
    /// Value on the hardware.
    pub found: String,
    /// The piece of work that it belongs to.
    pub place: String,
}

/// Returns a mismatch if the values differ.
pub(super) fn same<T: PartialEq + std::fmt::Display>(
    found: T,
    expected: T,
    differs: impl FnOnce(String, String) -> Mismatch,
) -> Result<(), Box<Mismatch>> {
    if found == expected {
        Ok(())
    } else {
        Err(Box::new(differs(found.to_string(), expected.to_string())))
    }
}

/// The first bit set in `mask` in which `found` and `expected` differ, or that is unknown.
pub(super) fn first_difference(
    found: &[u32],
    unknown: Option<&[u32]>,
    expected: &[u32],
    mask: &[u32],
) -> Option<usize> {
    for (i, ((f, e), m)) in found.iter().zip(expected).zip(mask).enumerate() {
        let open = unknown.map_or(0, |u| u[i]);
        let bits = ((f ^ e) | open) & m;
        if bits != 0 {
            return Some(32 * i + bits.trailing_zeros() as usize);
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_masked_bits_count_and_unknown_ones_always_differ() {
        let all = [u32::MAX; 2];
        assert_eq!(first_difference(&[1, 8], None, &[1, 0], &all), Some(35));
        assert_eq!(
            first_difference(&[1, 8], None, &[1, 0], &[u32::MAX, 7]),
            None
        );
        let unknown = [0b1_0000, 0];
        assert_eq!(
            first_difference(&[1, 8], Some(&unknown), &[1, 8], &all),
            Some(4)
        );
    }
}
