//! Random numbers that find the limits of words.

use crate::choices::Random;
use num_bigint::BigInt;
use potamoi_netlist::Ty;

impl Random {
    pub(crate) fn flip(&mut self) -> bool {
        self.next() & 1 == 1
    }

    /// Bits with long runs of ones and zeros, or a single bit, or anything.
    pub(crate) fn words(&mut self, width: u32) -> Vec<u32> {
        let mut words: Vec<u32> = (0..width.div_ceil(32))
            .map(|_| self.next() as u32)
            .collect();
        match self.below(10) {
            0 => words.fill(0),
            1 => words.fill(u32::MAX),
            2 => {
                words.fill(0);
                let bit = self.below(width as usize);
                words[bit / 32] = 1 << (bit % 32);
            }
            3 => {
                words.fill(u32::MAX);
                words[(width as usize - 1) / 32] = !(1 << ((width - 1) % 32));
            }
            4 => words.iter_mut().for_each(|w| *w &= 0x8000_0001),
            5 => {
                words.fill(u32::MAX);
                let bit = self.below(width as usize);
                words[bit / 32] = !(1 << (bit % 32));
            }
            6 => {
                // A narrower number with its sign, or none.
                let from = self.below(width as usize);
                let ones = self.flip();
                for bit in from..width as usize {
                    words[bit / 32] &= !(1 << (bit % 32));
                    words[bit / 32] |= u32::from(ones) << (bit % 32);
                }
            }
            _ => {}
        }
        if !width.is_multiple_of(32)
            && let Some(last) = words.last_mut()
        {
            *last &= (1 << (width % 32)) - 1;
        }
        words
    }

    /// A value of a type.
    pub(crate) fn value(&mut self, ty: Ty) -> BigInt {
        let words = self.words(ty.width);
        let code = BigInt::from(num_bigint::BigUint::new(words));
        if ty.signed && code.bit(u64::from(ty.width - 1)) {
            code - (BigInt::from(1) << ty.width)
        } else {
            code
        }
    }
}
