//! The fixed-point format of transmittances.

use potamoi_formats::fixed::Format;

/// U1.20: it represents 1 exactly.
pub const TRANSMITTANCE: Format = Format::unsigned(1, 20);
