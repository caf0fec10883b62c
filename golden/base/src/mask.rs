//! Some pixels of a picture.

/// Pixels that are meant, of a picture of a size.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Mask {
    size: [u32; 2],
    pixels: Vec<bool>,
}

impl Mask {
    /// The pixels that `has` tells of, by their number from the top left, row by
    /// row.
    #[must_use]
    pub fn new(size: [u32; 2], has: impl Fn(usize) -> bool) -> Self {
        let count = size[0] as usize * size[1] as usize;
        Self {
            size,
            pixels: (0..count).map(has).collect(),
        }
    }

    /// Pixels a row, and rows.
    #[must_use]
    pub const fn size(&self) -> [u32; 2] {
        self.size
    }

    /// Whether a pixel is meant; none outside of the picture is.
    #[must_use]
    pub fn has(&self, pixel: usize) -> bool {
        self.pixels.get(pixel).copied().unwrap_or(false)
    }

    /// How many are.
    #[must_use]
    pub fn count(&self) -> usize {
        self.pixels.iter().filter(|p| **p).count()
    }
}
