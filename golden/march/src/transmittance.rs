//! The format of transmittances.

use potamoi_formats::fixed::Format;

/// U1.20: 1 is representable, and each of 255 samples may take its part of it.
pub const TRANSMITTANCE: Format = Format::unsigned(1, 20);
