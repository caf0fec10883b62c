//! Words of `$readmemh` files.

use std::ops::Range;

use serde::Serialize;

/// Description of one memory file.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct MemoryFile {
    /// Width of a word in bits.
    pub width: u32,
    /// Number of words.
    pub count: usize,
    /// Fields of a word with their widths, highest first.
    pub fields: Vec<(String, u32)>,
}

/// A memory under construction.
pub(super) struct Memory {
    pub(super) fields: Vec<(String, u32)>,
    pub(super) text: String,
    pub(super) count: usize,
}

impl Memory {
    pub(super) fn new(fields: Vec<(String, u32)>) -> Self {
        Self {
            fields,
            text: String::new(),
            count: 0,
        }
    }

    pub(super) fn width(&self) -> u32 {
        self.fields.iter().map(|f| f.1).sum()
    }

    /// The bits of a field in a word, `HIGH:LOW`.
    pub(super) fn place_of(&self, name: &str) -> String {
        let below = self.fields.iter().rev().take_while(|field| field.0 != name);
        let low: u32 = below.map(|field| field.1).sum();
        let own = self.fields.iter().find(|field| field.0 == name);
        let width = own.map_or(0, |field| field.1);
        format!("{}:{low}", (low + width).saturating_sub(1))
    }

    /// Appends a word; `values` are the fields' words, low first, highest field first. Bits past a
    /// field's width are dropped, missing ones are 0.
    pub(super) fn push<'a>(&mut self, values: impl IntoIterator<Item = &'a [u32]>) {
        let width = self.width();
        let mut word = vec![0u32; width.div_ceil(32) as usize];
        let mut at = width;
        for ((_, bits), value) in self.fields.iter().zip(values) {
            at -= bits;
            for i in 0..*bits {
                let bit = value
                    .get((i / 32) as usize)
                    .map_or(0, |w| w >> (i % 32) & 1);
                word[((at + i) / 32) as usize] |= bit << ((at + i) % 32);
            }
        }
        let digits: String = word.iter().rev().map(|w| format!("{w:08x}")).collect();
        let keep = width.div_ceil(4) as usize;
        self.text.push_str(&digits[digits.len() - keep..]);
        self.text.push('\n');
        self.count += 1;
    }

    /// Where the words of another memory of these fields lie in this one. They are appended unless they
    /// are there, one after the other.
    pub(super) fn place(&mut self, words: &Self) -> Range<usize> {
        let line = self.width().div_ceil(4) as usize + 1;
        match self.text.find(&words.text).map(|at| at / line) {
            Some(from) => from..from + words.count,
            None => {
                self.text.push_str(&words.text);
                let from = self.count;
                self.count += words.count;
                from..self.count
            }
        }
    }

    /// Appends a word of fields of at most 64 bits.
    pub(super) fn push_values(&mut self, values: &[u64]) {
        let words: Vec<_> = values
            .iter()
            .map(|v| [*v as u32, (*v >> 32) as u32])
            .collect();
        self.push(words.iter().map(|w| &w[..]));
    }

    pub(super) fn description(&self) -> MemoryFile {
        MemoryFile {
            width: self.width(),
            count: self.count,
            fields: self.fields.clone(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_lie_highest_first_and_digits_fill_the_width() {
        let fields = [("last", 1), ("data", 36)];
        let mut memory = Memory::new(fields.map(|(name, bits)| (name.to_owned(), bits)).to_vec());
        memory.push([&[1][..], &[0xdead_beef, 0xff][..]]);
        memory.push([&[2][..], &[5][..]]);
        assert_eq!(memory.text, "1fdeadbeef\n0000000005\n");
        assert_eq!(memory.description().count, 2);
    }

    #[test]
    fn words_that_are_there_are_not_written_again() {
        let of = |values: &[u32]| {
            let mut memory = Memory::new(vec![("data".to_owned(), 12)]);
            values.iter().for_each(|v| memory.push([&[*v][..]]));
            memory
        };
        let mut memory = of(&[0x123, 0x456, 0x789]);
        assert_eq!(memory.place(&of(&[0x456, 0x789])), 1..3);
        assert_eq!(memory.place(&of(&[0x456, 0x123])), 3..5);
        assert_eq!(memory.place(&of(&[])).len(), 0);
        assert_eq!(memory.text, "123\n456\n789\n456\n123\n");
    }
}
