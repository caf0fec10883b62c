//! The levels of a hash grid: resolution, number of entries, and whether they are hashed.

/// Sizes of a hash grid.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct GridShape {
    /// Number of levels, coarse to fine.
    pub levels: u32,
    /// Features an entry.
    pub features: u32,
    /// Logarithm to base 2 of the maximum number of entries in a level.
    pub log2_entries: u32,
    /// Vertices along an axis of the coarsest level.
    pub base: u32,
    /// Factor from a level's scale to that of the next finer one, at least 1.
    pub growth: f32,
}

/// One level.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Level {
    /// Vertices along the unit cube. The position `x` in the cube is vertex position `scale x +
    /// 0.5`.
    pub scale: f64,
    /// Vertices along an axis in the level's index.
    pub resolution: u64,
    /// Number of entries: a multiple of 8, or the maximum.
    pub entries: usize,
}

impl Level {
    /// Whether vertices share entries because there are fewer entries than vertices.
    #[must_use]
    pub fn is_hashed(&self) -> bool {
        u128::from(self.resolution).pow(3) > self.entries as u128
    }
}

impl GridShape {
    /// The growth at which the finest of `levels` has 2048 vertices along the unit cube, and
    /// `aabb_scale` times as many along a box of that size.
    #[must_use]
    pub(crate) fn growth_to(levels: u32, base: u32, aabb_scale: u32) -> f32 {
        if levels < 2 {
            return 1.0;
        }
        // In 32 bits, as the reference finds it.
        let ratio = 2048.0 * aabb_scale as f32 / base as f32;
        (ratio.ln() / (levels - 1) as f32).exp()
    }

    /// A level, counted from 0, the coarsest. Computed in 32-bit arithmetic, since the resolution
    /// is rounded up from it.
    #[must_use]
    pub fn level(&self, level: u32) -> Level {
        let scale = (level as f32 * self.growth.log2()).exp2() * self.base as f32 - 1.0;
        let resolution = scale.ceil() as u64 + 1;
        let most = 1u128 << self.log2_entries;
        let entries = u128::from(resolution).pow(3).next_multiple_of(8).min(most);
        Level {
            scale: scale.into(),
            resolution,
            entries: entries as usize,
        }
    }

    /// Whether a level can be gathered from MVoxels that are each loaded once. This needs an entry
    /// for each vertex, so that neighbouring vertices form blocks in memory. The vertices of a
    /// hashed level lie anywhere in its table, so it is gathered in the order of samples.
    #[must_use]
    pub fn streams(&self, level: u32) -> bool {
        !self.level(level).is_hashed()
    }

    /// All levels.
    pub fn all(&self) -> impl Iterator<Item = Level> + '_ {
        (0..self.levels).map(|level| self.level(level))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shape(log2_entries: u32, aabb_scale: u32) -> GridShape {
        GridShape {
            levels: 8,
            features: 4,
            log2_entries,
            base: 16,
            growth: GridShape::growth_to(8, 16, aabb_scale),
        }
    }

    /// Eight levels from 16 to 2048 double: 16, 32 and 64 cubed fit 2^19
    /// entries, 128 cubed is 2^21.
    #[test]
    fn the_base_configuration_is_hashed_from_its_fourth_level() {
        let shape = shape(19, 1);
        assert!((shape.growth - 2.0).abs() < 1e-6);
        let entries: Vec<_> = shape.all().map(|l| l.entries).collect();
        assert_eq!(entries[..3], [1 << 12, 1 << 15, 1 << 18]);
        assert!(entries[3..].iter().all(|e| *e == 1 << 19));
        let streams: Vec<_> = (0..8).map(|l| shape.streams(l)).collect();
        assert_eq!(
            streams,
            [true, true, true, false, false, false, false, false]
        );
        for (level, made) in shape.all().enumerate() {
            let exact = f64::from(16 << level) - 1.0;
            assert!((made.scale - exact).abs() < 1e-3, "{made:?}");
        }
    }

    /// With 2^21 entries a level, the larger configuration that the reference
    /// comes with, four of the eight levels stream, half of what is gathered,
    /// and the fifth is the first that does not.
    #[test]
    fn the_big_configuration_is_hashed_from_its_fifth_level() {
        let shape = shape(21, 1);
        let first = (0..8).find(|level| !shape.streams(*level));
        assert_eq!(first, Some(4));
    }

    /// 125 vertices have 128 entries; 343 share the 256 there may be.
    #[test]
    fn entries_are_rounded_up_and_limited() {
        let odd = GridShape {
            levels: 3,
            features: 2,
            log2_entries: 8,
            base: 5,
            growth: 1.15,
        };
        let all: Vec<_> = odd.all().collect();
        assert_eq!(
            all.iter().map(|l| l.resolution).collect::<Vec<_>>(),
            [5, 6, 7]
        );
        assert_eq!(
            all.iter().map(|l| l.entries).collect::<Vec<_>>(),
            [128, 216, 256]
        );
        assert!(!all[1].is_hashed() && all[2].is_hashed());
        assert!(shape(19, 16).growth > shape(19, 1).growth);
        assert_eq!(GridShape::growth_to(1, 16, 1), 1.0);
    }
}
