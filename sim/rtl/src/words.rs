//! Ports as words of 32 bits, low word first.

/// Halfword `i` of words.
const fn half(words: &[u32], i: usize) -> u16 {
    (words[i / 2] >> (16 * (i % 2))) as u16
}

/// The slot of a port.
pub(super) const fn slot(user: &[u32], port: usize, slot_bits: u32) -> u32 {
    if slot_bits == 32 {
        user[port]
    } else {
        half(user, port) as u32
    }
}

/// The code in a lane of the feature stream, of so many bytes.
pub(super) const fn code(words: &[u32], lane: usize, lane_bytes: usize) -> i32 {
    if lane_bytes == 4 {
        words[lane] as i32
    } else {
        half(words, lane) as i16 as i32
    }
}
