//! Ports as 32-bit words, low word first.

/// Halfword `i` of a port.
const fn half(words: &[u32], i: usize) -> u16 {
    (words[i / 2] >> (16 * (i % 2))) as u16
}

/// Slot of a port.
pub(super) const fn slot(user: &[u32], port: usize, slot_bits: u32) -> u32 {
    if slot_bits == 32 {
        user[port]
    } else {
        half(user, port) as u32
    }
}

/// Code in a lane of the feature stream, with `lane_bytes` bytes.
pub(super) const fn code(words: &[u32], lane: usize, lane_bytes: usize) -> i32 {
    if lane_bytes == 4 {
        words[lane] as i32
    } else {
        half(words, lane) as i16 as i32
    }
}
