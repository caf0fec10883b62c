//! Storage of ports in the C++ model.

use crate::{Direction, Port};

/// The storage of one port inside the C++ model.
#[derive(Debug, Clone, Copy)]
pub(super) struct Slot {
    pub(super) at: *mut u8,
    /// The bits of the value, or of its last word above 64 bits.
    pub(super) mask: u64,
    pub(super) words: u32,
    pub(super) store: Store,
    pub(super) output: bool,
}

/// Verilator's type of a port.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Store {
    U8,
    U16,
    U32,
    U64,
    Words,
}

impl Store {
    pub(super) fn of(bits: u32) -> Self {
        match bits {
            0..=8 => Store::U8,
            9..=16 => Store::U16,
            17..=32 => Store::U32,
            33..=64 => Store::U64,
            _ => Store::Words,
        }
    }

    pub(super) fn align(self) -> usize {
        match self {
            Store::U8 => 1,
            Store::U16 => 2,
            Store::U32 | Store::Words => 4,
            Store::U64 => 8,
        }
    }
}

impl Slot {
    pub(super) fn new(at: *mut u8, port: &Port) -> Self {
        let last = match port.bits {
            0..=64 => port.bits,
            wide => (wide - 1) % 32 + 1,
        };
        Slot {
            at,
            mask: u64::MAX >> (64 - last.max(1)),
            words: port.words() as u32,
            store: Store::of(port.bits),
            output: port.dir == Direction::Output,
        }
    }

    /// # Safety
    /// The port has at most 64 bits, its model is live, and nothing else reaches it.
    #[inline]
    pub(super) unsafe fn store(self, value: u64) {
        let value = value & self.mask;
        // SAFETY: the caller's promise, with the size that the shim asserts for this width and
        // the alignment that `Model::new` checked.
        unsafe {
            match self.store {
                Store::U8 => self.at.write(value as u8),
                Store::U16 => self.at.cast::<u16>().write(value as u16),
                Store::U32 => self.at.cast::<u32>().write(value as u32),
                Store::U64 | Store::Words => self.at.cast::<u64>().write(value),
            }
        }
    }

    /// # Safety
    /// The port has at most 64 bits, its model is live, and nothing writes to it.
    #[inline]
    pub(super) unsafe fn load(self) -> u64 {
        // SAFETY: as in `store`.
        unsafe {
            match self.store {
                Store::U8 => u64::from(self.at.read()),
                Store::U16 => u64::from(self.at.cast::<u16>().read()),
                Store::U32 => u64::from(self.at.cast::<u32>().read()),
                Store::U64 | Store::Words => self.at.cast::<u64>().read(),
            }
        }
    }

    /// # Safety
    /// The port has more than 64 bits, its model lives for `'a`, and nothing writes to it then.
    #[inline]
    pub(super) unsafe fn array<'a>(self) -> &'a [u32] {
        // SAFETY: the caller's promise, and the shim asserts that there are as many words.
        unsafe { std::slice::from_raw_parts(self.at.cast::<u32>(), self.words as usize) }
    }
}

/// Copies without a function call: most ports are too short for one.
#[inline]
pub(super) fn copy_words(to: &mut [u32], from: &[u32]) {
    const CHUNK: usize = 8;
    let (to, to_rest) = to.as_chunks_mut::<CHUNK>();
    let (from, from_rest) = from.as_chunks::<CHUNK>();
    for (to, from) in to.iter_mut().zip(from) {
        *to = *from;
    }
    for (to, from) in to_rest.iter_mut().zip(from_rest) {
        *to = *from;
    }
}
