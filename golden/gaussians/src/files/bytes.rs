//! Little-endian numbers at places of a byte string that is known to hold them.

use half::f16;

/// The byte at a place; 0 beyond the end.
pub(super) fn byte(bytes: &[u8], at: usize) -> u8 {
    bytes.get(at).copied().unwrap_or_default()
}

fn array<const N: usize>(bytes: &[u8], at: usize) -> [u8; N] {
    let found = bytes.get(at..).and_then(<[u8]>::first_chunk);
    found.copied().unwrap_or([0; N])
}

/// The whole number of 16 bits at a place; 0 where the end is passed.
pub(super) fn u16(bytes: &[u8], at: usize) -> u16 {
    u16::from_le_bytes(array(bytes, at))
}

/// The whole number of 32 bits at a place.
pub(super) fn u32(bytes: &[u8], at: usize) -> u32 {
    u32::from_le_bytes(array(bytes, at))
}

/// The float of 32 bits at a place.
pub(super) fn f32(bytes: &[u8], at: usize) -> f32 {
    f32::from_bits(u32(bytes, at))
}

/// The float of 16 bits at a place.
pub(super) fn half(bytes: &[u8], at: usize) -> f32 {
    f16::from_bits(u16(bytes, at)).to_f32()
}
