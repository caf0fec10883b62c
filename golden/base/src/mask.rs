//! Sets of pixels.

/// A set of pixels of a picture.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Mask {
    size: [u32; 2],
    pixels: Vec<bool>,
}

impl Mask {
    /// The pixels for which `has` returns true, numbered row by row from the top left.
    #[must_use]
    pub fn new(size: [u32; 2], has: impl Fn(usize) -> bool) -> Self {
        let count = size[0] as usize * size[1] as usize;
        Self {
            size,
            pixels: (0..count).map(has).collect(),
        }
    }

    /// Width and height of the picture in pixels.
    #[must_use]
    pub const fn size(&self) -> [u32; 2] {
        self.size
    }

    /// Whether a pixel is in the set; `false` outside the picture.
    #[must_use]
    pub fn has(&self, pixel: usize) -> bool {
        self.pixels.get(pixel).copied().unwrap_or(false)
    }

    /// Number of pixels in the set.
    #[must_use]
    pub fn count(&self) -> usize {
        self.pixels.iter().filter(|p| **p).count()
    }
}
