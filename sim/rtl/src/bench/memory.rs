//! Words of `$readmemh` files.

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
}
