//! Skip and stop decisions of a frame.

use super::view::TILE_PIXELS;

/// The decisions of one frame, so that those of two renderers can be compared.
///
/// The `n`th entry of a tile is the `n`th Gaussian composited there.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Decisions {
    /// Index of each tile's first entry in `drawn`, with one element more than there are tiles.
    pub(crate) first: Vec<usize>,
    /// For each entry, the pixels of the tile that it contributed to, by bit.
    pub(crate) drawn: Vec<[u64; TILE_PIXELS / 64]>,
    /// For each pixel of each tile, the entry that stopped it; `u32::MAX` if
    /// none did.
    pub(crate) stop: Vec<[u32; TILE_PIXELS]>,
}

/// Numbers of decisions that differ between two renderers of the same view.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Flips {
    /// (pixel, entry) pairs that one renderer skipped as too faint and the other drew, before the
    /// pixel had stopped in either.
    pub skip: u64,
    /// Pixels that stopped at different entries or in only one of them.
    pub stop: u64,
}

impl Decisions {
    pub(crate) fn new(first: Vec<usize>) -> Self {
        let entries = first.last().copied().unwrap_or(0);
        let tiles = first.len().saturating_sub(1);
        Self {
            first,
            drawn: vec![[0; TILE_PIXELS / 64]; entries],
            stop: vec![[u32::MAX; TILE_PIXELS]; tiles],
        }
    }

    /// Sets the decisions of a tile: the entry that stopped each pixel, and the pixels that each entry
    /// drew. `places` are those of the entries among all of the tile's, where some were left out.
    pub(crate) fn set(
        &mut self,
        tile: usize,
        stop: &[u32; TILE_PIXELS],
        drawn: &[[u64; TILE_PIXELS / 64]],
        places: Option<&[u32]>,
    ) {
        let place = |entry: u32| match places {
            // `u32::MAX` is no entry.
            Some(places) => places.get(entry as usize).copied().unwrap_or(u32::MAX),
            None => entry,
        };
        self.stop[tile] = stop.map(place);
        let own = &mut self.drawn[self.first[tile]..self.first[tile + 1]];
        for (entry, drawn) in (0..).zip(drawn) {
            if let Some(to) = own.get_mut(place(entry) as usize) {
                *to = *drawn;
            }
        }
    }

    /// Counts the differences; `None` if the two are not of the same view.
    #[must_use]
    pub fn flips(&self, other: &Self) -> Option<Flips> {
        if self.first != other.first {
            return None;
        }
        let mut flips = Flips::default();
        for (tile, (mine, theirs)) in self.stop.iter().zip(&other.stop).enumerate() {
            flips.stop += mine.iter().zip(theirs).filter(|(a, b)| a != b).count() as u64;
            let range = self.first[tile]..self.first[tile + 1];
            for (entry, place) in range.enumerate() {
                for word in 0..TILE_PIXELS / 64 {
                    let mut differ = self.drawn[place][word] ^ other.drawn[place][word];
                    while differ != 0 {
                        let pixel = word * 64 + differ.trailing_zeros() as usize;
                        let both_live = (entry as u32) < mine[pixel].min(theirs[pixel]);
                        flips.skip += u64::from(both_live);
                        differ &= differ - 1;
                    }
                }
            }
        }
        Some(flips)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_decisions_that_both_took_count() {
        let a = {
            let mut d = Decisions::new(vec![0, 3]);
            d.drawn[0] = [0b11, 0, 0, 1];
            d.drawn[1] = [0b11, 0, 0, 0];
            d.stop[0][1] = 2;
            d
        };
        assert_eq!(a.flips(&a), Some(Flips::default()));
        let mut b = a.clone();
        b.drawn[0] = [0b10, 0, 0, 0];
        b.drawn[1] = [0b01, 0, 0, 0];
        b.stop[0][1] = 1;
        // Pixels 0 and 192 at entry 0 flip; pixel 1 had stopped in b at entry 1.
        assert_eq!(a.flips(&b), Some(Flips { skip: 2, stop: 1 }));
        assert_eq!(b.flips(&a), a.flips(&b));
        assert_eq!(a.flips(&Decisions::new(vec![0, 2])), None);
    }
}
