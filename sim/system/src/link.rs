//! Wireless link to a remote renderer: bytes of its messages, bandwidth and energy (paper,
//! "Experimental Setup").

/// Bandwidth in bytes a second: 10 MB/s.
pub(crate) const BYTES_PER_SECOND: u64 = 10_000_000;
/// Energy in nanojoules of a byte sent or received: 100 nJ.
pub(crate) const NANOJOULES_PER_BYTE: u64 = 100;
/// Bytes of a pixel's colour: three channels of a byte, uncompressed.
pub(crate) const COLOUR_BYTES: u32 = 3;
/// Bytes of a pixel's depth, sent with a reference.
pub(crate) const DEPTH_BYTES: u32 = 2;
/// Bytes of a reference's pixel: colour and depth.
pub const REFERENCE_BYTES: u32 = COLOUR_BYTES + DEPTH_BYTES;
/// Bytes of a request for a reference: a pose of twelve 32-bit numbers.
pub const REQUEST_BYTES: u64 = 48;
