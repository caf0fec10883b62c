//! The format of transmittances.

use potamoi_formats::fixed::Format;

/// Format of transmittances.
pub const TRANSMITTANCE: Format = Format::unsigned(1, 20);
