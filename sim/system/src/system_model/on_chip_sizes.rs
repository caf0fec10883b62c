//! Sizes of the MAC array and of the buffers.

use potamoi_cycles::mac_array::MacArray;

use super::system::System;

/// Sizes of the MAC array and of the buffers around the units: all of a [`System`] that areas and
/// energies on chip depend on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct OnChipSizes {
    /// The MAC array.
    pub array: MacArray,
    /// Whether a unit of the array has two registers for weights.
    pub array_double_buffered: bool,
    /// Bytes of the global feature buffer.
    pub feature_buffer_bytes: u64,
    /// Banks of the global feature buffer.
    pub feature_banks: u32,
    /// Bytes of the weight buffer.
    pub weight_buffer_bytes: u64,
}

impl OnChipSizes {
    /// Why area and energy of the array are not known, where its units are others than the one that was
    /// synthesised.
    pub(super) fn unbuilt_array(&self) -> Option<&'static str> {
        self.array_double_buffered.then_some(
            "its unit was synthesised with one register of weights, and \
             system.array_double_buffered asks for two",
        )
    }
}

impl From<&System> for OnChipSizes {
    fn from(own: &System) -> Self {
        Self {
            array: own.array(),
            array_double_buffered: own.array_double_buffered,
            feature_buffer_bytes: own.feature_buffer_bytes,
            feature_banks: own.feature_banks,
            weight_buffer_bytes: own.weight_buffer_bytes,
        }
    }
}

impl Default for OnChipSizes {
    fn default() -> Self {
        Self::from(&System::default())
    }
}
