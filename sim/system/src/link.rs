//! What goes over the wireless link to a renderer elsewhere, and what a byte costs (paper, "Experimental
//! Setup").

/// Bytes a second: 10 MB/s.
pub const BYTES_PER_SECOND: u64 = 10_000_000;
/// Energy of a byte that is sent or received: 100 nJ.
pub const NANOJOULES_PER_BYTE: u64 = 100;
/// Bytes of a pixel: three colours, uncompressed.
pub const COLOUR_BYTES: u32 = 3;
/// Bytes of the depth that a reference is sent with, a pixel.
pub const DEPTH_BYTES: u32 = 2;
/// Bytes of a pixel of a reference.
pub const REFERENCE_BYTES: u32 = COLOUR_BYTES + DEPTH_BYTES;
/// Bytes that ask for a reference: a pose of twelve 32-bit numbers.
pub const REQUEST_BYTES: u64 = 48;
