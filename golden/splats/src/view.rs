//! A cloud as seen by a camera: the common input of both renderers.

use rayon::prelude::*;

use super::coverage::{self, Grid};
use super::depth;
use super::error::RenderError;
use super::profile::{Profile, Rules};
use super::project::{Projected, Projection};
use super::records::{RecordForm, Saturations, record};
use potamoi_base::camera::Camera;
use potamoi_base::mask::Mask;
use potamoi_base::precision::Precision;
use potamoi_base::sh;
use potamoi_formats::config::SplatOpacity;
use potamoi_formats::record::SplatRecord;
use potamoi_gaussians::Cloud;

pub use potamoi_reference::splat_unit::TILE;
pub(crate) use potamoi_reference::splat_unit::TILE_PIXELS;

/// The largest picture side, in pixels.
const MAX_SIDE: u32 = 1 << 15;
/// Maximum number of (tile, Gaussian) pairs: 1 GiB of tile numbers.
const MAX_ENTRIES: u64 = 1 << 28;
/// Gaussians whose tiles one thread lists at a time.
const BLOCK: usize = 1024;

/// Whether Gaussians are sorted by depth.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Sorting {
    /// Always.
    #[default]
    Always,
    /// Unless they are stored in depth order.
    IfNeeded,
    /// Never: they are drawn in stored order.
    Never,
}

/// Optional parts of the work, by default all. Leaving out a part that the scene does not need
/// gives the same bits.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Work {
    /// The highest degree of spherical harmonics that is evaluated.
    pub degree: usize,
    /// Whether Gaussians are sorted by depth.
    pub sorting: Sorting,
    /// Whether pixels terminate early.
    pub stops: bool,
    /// Thresholds and widths that override the rules'.
    pub precision: Precision,
}

impl Work {
    /// All parts.
    pub const ALL: Self = Self {
        degree: sh::MAX_DEGREE,
        sorting: Sorting::Always,
        stops: true,
        precision: Precision::RULES,
    };
}

impl Work {
    /// The rules of a profile, with this work.
    pub(crate) fn rules(&self, profile: Profile) -> Rules {
        let mut rules = profile.rules().with(&self.precision);
        if !self.stops {
            rules.stop_below = f64::NEG_INFINITY;
        }
        rules
    }
}

impl Default for Work {
    fn default() -> Self {
        Self::ALL
    }
}

/// The pixels and tiles of a picture.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Raster {
    /// Width and height in pixels.
    pub(crate) size: [u32; 2],
}

impl Raster {
    /// The picture of a camera.
    ///
    /// # Errors
    /// The camera is invalid.
    pub(crate) fn of(camera: &Camera) -> Result<Self, RenderError> {
        check(camera)?;
        Ok(Self {
            size: [camera.width, camera.height],
        })
    }

    /// Tile columns and rows.
    pub(crate) const fn grid(self) -> Grid {
        let [width, height] = self.size;
        Grid {
            columns: width.div_ceil(TILE),
            rows: height.div_ceil(TILE),
        }
    }

    /// Column and row of the first pixel of a tile, and the number of its columns and rows in the
    /// picture.
    pub(crate) fn tile_pixels(self, tile: usize) -> [[u32; 2]; 2] {
        let columns = self.grid().columns;
        let [x, y] = [tile as u32 % columns, tile as u32 / columns].map(|at| at * TILE);
        let [width, height] = self.size;
        [[x, y], [TILE.min(width - x), TILE.min(height - y)]]
    }
}

/// The Gaussians that a camera sees, front to back, with the tiles of each.
#[derive(Debug, Clone)]
pub struct View {
    rules: Rules,
    raster: Raster,
    splats: Vec<Projected>,
    culled: usize,
    /// `first[r]..first[r + 1]` are the indices of rank r's tiles in `tiles`.
    first: Vec<usize>,
    tiles: Vec<u32>,
}

impl View {
    /// Projects the Gaussians, sorts them and finds their tiles. Rank `r` is index `r` in
    /// [`View::splats`]; Gaussians that touch no tile have no rank.
    ///
    /// # Errors
    /// The camera is invalid, or there are more (tile, Gaussian) pairs than fit in memory.
    pub fn new(cloud: &Cloud, camera: &Camera, profile: Profile) -> Result<Self, RenderError> {
        Self::by(cloud, camera, profile, &Work::ALL)
    }

    /// As [`View::new`], with optional parts of the work.
    ///
    /// # Errors
    /// Those of [`View::new`].
    pub fn by(
        cloud: &Cloud,
        camera: &Camera,
        profile: Profile,
        work: &Work,
    ) -> Result<Self, RenderError> {
        let raster = Raster::of(camera)?;
        let rules = work.rules(profile);
        let grid = raster.grid();
        let projection = Projection::new(cloud, camera, &rules, work.degree);
        let depths = projection.depths();
        let order = match work.sorting {
            Sorting::Never => depths,
            Sorting::IfNeeded if depth::is_sorted(cloud, &depths) => depths,
            Sorting::IfNeeded | Sorting::Always => depth::sort(cloud, depths),
        };
        let culled = cloud.len() - order.len();
        let mut splats: Vec<Projected> = order
            .par_iter()
            .map(|(_, index)| projection.project(*index))
            .collect();
        let mut counts: Vec<u32> = splats
            .par_iter()
            .map(|s| {
                let mut n = 0;
                coverage::tiles(s, grid, &rules, |_| n += 1);
                n
            })
            .collect();
        let entries = counts.iter().map(|n| u64::from(*n)).sum();
        fits(entries)?;
        let mut keep = counts.iter().map(|n| *n > 0);
        splats.retain(|_| keep.next().unwrap_or(false));
        counts.retain(|n| *n > 0);
        let first: Vec<usize> = std::iter::once(0)
            .chain(counts.iter().scan(0, |sum, n| {
                *sum += *n as usize;
                Some(*sum)
            }))
            .collect();
        let mut tiles = vec![0; entries as usize];
        parts(&mut tiles, &first)
            .into_par_iter()
            .zip(splats.par_chunks(BLOCK))
            .for_each(|(part, splats)| {
                let mut places = part.iter_mut();
                for s in splats {
                    coverage::tiles(s, grid, &rules, |t| {
                        if let Some(place) = places.next() {
                            *place = t;
                        }
                    });
                }
            });
        Ok(Self {
            rules,
            raster,
            splats,
            culled,
            first,
            tiles,
        })
    }

    /// The same view with some of its (tile, Gaussian) pairs, told rank after rank. Ranks stay as they are,
    /// so that some may have no tile.
    pub(crate) fn with_pairs(mut self, kept: &[bool]) -> Self {
        let before = self.first.clone();
        let counts = before.windows(2).map(|own| {
            let own = &kept[own[0]..own[1]];
            own.iter().filter(|kept| **kept).count()
        });
        let mut sum = 0;
        for (next, count) in self.first[1..].iter_mut().zip(counts) {
            sum += count;
            *next = sum;
        }
        let mut kept = kept.iter();
        self.tiles.retain(|_| kept.next().copied().unwrap_or(true));
        self
    }

    /// The records of the Gaussians, by rank.
    pub(crate) fn records(
        &self,
        opacity: SplatOpacity,
        saturations: &mut Saturations,
    ) -> Vec<SplatRecord> {
        let form = RecordForm {
            conic_bits: self.rules.conic_bits,
            opacity,
        };
        let splats = (0..).zip(&self.splats);
        splats
            .map(|(rank, s)| record(s, rank, form, saturations))
            .collect()
    }

    /// The rules of the view.
    #[must_use]
    pub fn rules(&self) -> &Rules {
        &self.rules
    }

    /// Width and height in pixels.
    #[must_use]
    pub fn size(&self) -> [u32; 2] {
        self.raster.size
    }

    /// The pixels and tiles of the picture.
    pub(crate) const fn raster(&self) -> Raster {
        self.raster
    }

    /// Number of tile columns and rows.
    #[must_use]
    pub fn grid(&self) -> [u32; 2] {
        let Grid { columns, rows } = self.raster.grid();
        [columns, rows]
    }

    /// Gaussians that touch a tile, front to back.
    #[must_use]
    pub fn splats(&self) -> &[Projected] {
        &self.splats
    }

    /// Number of Gaussians that the near plane culled.
    #[must_use]
    pub fn culled(&self) -> usize {
        self.culled
    }

    /// The tiles of rank `rank`, ascending. Tiles are numbered row by row.
    #[must_use]
    pub fn tiles_of(&self, rank: usize) -> &[u32] {
        &self.tiles[self.first[rank]..self.first[rank + 1]]
    }

    /// Number of (tile, Gaussian) pairs.
    #[must_use]
    pub fn entries(&self) -> usize {
        self.tiles.len()
    }

    /// Number of tiles.
    #[must_use]
    pub fn tile_count(&self) -> usize {
        let [columns, rows] = self.grid();
        (columns * rows) as usize
    }

    /// Column and row of the first pixel of a tile, and the number of its columns and rows in the
    /// picture.
    #[must_use]
    pub fn tile_pixels(&self, tile: usize) -> [[u32; 2]; 2] {
        self.raster.tile_pixels(tile)
    }

    /// Whether a mask has a pixel of a tile.
    pub fn shows(&self, tile: usize, mask: &Mask) -> bool {
        let [[left, top], [columns, rows]] = self.tile_pixels(tile);
        let mut lines = top..top + rows;
        lines.any(|y| (left..left + columns).any(|x| mask.has((y * self.size()[0] + x) as usize)))
    }

    /// The ranks drawn in each tile, front to back: the index of each tile's first rank (one more
    /// than there are tiles), and the ranks.
    pub(crate) fn by_tile(&self) -> (Vec<usize>, Vec<u32>) {
        let mut first = vec![0usize; self.tile_count() + 1];
        for t in &self.tiles {
            first[*t as usize + 1] += 1;
        }
        for t in 1..first.len() {
            first[t] += first[t - 1];
        }
        let mut next = first.clone();
        let mut ranks = vec![0u32; self.tiles.len()];
        for rank in 0..self.splats.len() {
            for t in self.tiles_of(rank) {
                let place = &mut next[*t as usize];
                ranks[*place] = rank as u32;
                *place += 1;
            }
        }
        (first, ranks)
    }
}

/// Whether any Gaussian touches a tile of a camera's picture.
///
/// # Errors
/// The camera is invalid.
pub fn is_any_in_view(
    cloud: &Cloud,
    camera: &Camera,
    profile: Profile,
) -> Result<bool, RenderError> {
    let grid = Raster::of(camera)?.grid();
    let rules = profile.rules();
    let projection = Projection::new(cloud, camera, &rules, 0);
    let depths = projection.depths();
    Ok(depths.par_iter().any(|(_, index)| {
        let splat = projection.project(*index);
        let mut touches = false;
        if splat.opacity >= rules.alpha_min {
            coverage::tiles(&splat, grid, &rules, |_| touches = true);
        }
        touches
    }))
}

/// Whether the Gaussians are stored in depth order for a camera, front to back.
///
/// # Errors
/// The camera is invalid.
pub fn is_in_order(cloud: &Cloud, camera: &Camera, profile: Profile) -> Result<bool, RenderError> {
    check(camera)?;
    let rules = profile.rules();
    let depths = Projection::new(cloud, camera, &rules, 0).depths();
    Ok(depth::is_sorted(cloud, &depths))
}

/// Splits `tiles` at the first tile of every [`BLOCK`]th rank.
fn parts<'a>(mut tiles: &'a mut [u32], first: &[usize]) -> Vec<&'a mut [u32]> {
    let ranks = first.len() - 1;
    (0..ranks)
        .step_by(BLOCK)
        .map(|start| {
            let length = first[ranks.min(start + BLOCK)] - first[start];
            let (part, rest) = std::mem::take(&mut tiles).split_at_mut(length);
            tiles = rest;
            part
        })
        .collect()
}

/// Checks that the (tile, Gaussian) pairs fit in memory.
pub(crate) fn fits(entries: u64) -> Result<(), RenderError> {
    if entries > MAX_ENTRIES {
        return Err(RenderError::TooManyEntries {
            entries,
            limit: MAX_ENTRIES,
        });
    }
    Ok(())
}

fn check(camera: &Camera) -> Result<(), RenderError> {
    let refuse = |field, value: String, expected| {
        Err(RenderError::Camera {
            field,
            value,
            expected,
        })
    };
    for (field, value) in [("width", camera.width), ("height", camera.height)] {
        if !(1..=MAX_SIDE).contains(&value) {
            return refuse(field, value.to_string(), "1 to 32768 pixels");
        }
    }
    let focal = camera.focal;
    if !focal.is_finite() || focal.min_element() < 1e-3 || focal.max_element() > 1e7 {
        let value = format!("{:?}", focal.to_array());
        return refuse("focal", value, "0.001 to 10000000 pixels");
    }
    if !camera.centre.is_finite() || camera.centre.abs().max_element() > 1e7 {
        return refuse(
            "centre",
            format!("{:?}", camera.centre.to_array()),
            "at most 10000000 pixels from the picture",
        );
    }
    let m = camera.world_to_camera.matrix3;
    let off = (m * m.transpose()).to_cols_array();
    let identity = glam::DMat3::IDENTITY.to_cols_array();
    let rigid = off.iter().zip(identity).all(|(a, b)| (a - b).abs() < 1e-3);
    if !rigid || m.determinant() < 0.0 {
        let value = format!("{:?}", m.to_cols_array_2d());
        return refuse("world_to_camera", value, "a rotation");
    }
    let t = camera.world_to_camera.translation;
    if !t.is_finite() || t.abs().max_element() > 1e38 {
        let value = format!("{:?}", t.to_array());
        return refuse("world_to_camera", value, "a finite translation");
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use glam::{DMat3, DVec2, DVec3};

    fn camera() -> Camera {
        Camera::look_at(DVec3::ZERO, DVec3::Z, DVec3::NEG_Y, 1.0, 70, 40)
    }

    fn cloud() -> Cloud {
        Cloud::new(
            0,
            vec![[0.0, 0.0, 2.0], [0.1, 0.0, 1.0], [0.0, 0.0, -1.0]],
            vec![[-2.0; 3]; 3],
            vec![[1.0, 0.0, 0.0, 0.0]; 3],
            vec![1.0; 3],
            vec![[0.0; 3]; 3],
        )
        .unwrap()
    }

    #[test]
    fn ranks_run_front_to_back_and_tiles_agree_both_ways() {
        let v = View::new(&cloud(), &camera(), Profile::Inria).unwrap();
        assert_eq!(v.culled(), 1);
        let order: Vec<_> = v.splats().iter().map(|s| s.index).collect();
        assert_eq!(order, [1, 0]);
        let (first, ranks) = v.by_tile();
        assert_eq!(ranks.len(), v.entries());
        for t in 0..v.tile_count() {
            let list = &ranks[first[t]..first[t + 1]];
            assert!(list.is_sorted());
            for rank in 0..v.splats().len() {
                let there = v.tiles_of(rank).contains(&(t as u32));
                assert_eq!(there, list.contains(&(rank as u32)));
            }
        }
        // 70 x 40 pixels: the last column of tiles is 6 wide, the last row 8.
        assert_eq!(v.tile_pixels(14), [[64, 32], [6, 8]]);
    }

    #[test]
    fn unusable_cameras_are_refused_by_field() {
        let refused = |change: fn(&mut Camera), field: &str| {
            let mut c = camera();
            change(&mut c);
            match View::new(&cloud(), &c, Profile::Inria) {
                Err(RenderError::Camera { field: found, .. }) => assert_eq!(found, field),
                other => assert!(other.is_err(), "{field}"),
            }
        };
        refused(|c| c.width = 0, "width");
        refused(|c| c.height = u32::MAX, "height");
        refused(|c| c.focal.x = f64::NAN, "focal");
        refused(|c| c.focal = DVec2::ZERO, "focal");
        refused(|c| c.centre.y = f64::INFINITY, "centre");
        refused(
            |c| c.world_to_camera.matrix3 = DMat3::ZERO,
            "world_to_camera",
        );
        refused(
            |c| c.world_to_camera.matrix3.x_axis *= -1.0,
            "world_to_camera",
        );
        refused(
            |c| c.world_to_camera.translation.x = f64::NAN,
            "world_to_camera",
        );
    }
}
