//! Bytes that the memory-centric order moves, by ray group and halo.
//!
//! An MVoxel of `e` vertices an edge holds `e - 1` cells an edge where it shares
//! its faces with its neighbours (*shared*: stored twice, one entry a sample),
//! or `e` where nothing is stored twice (*split*: a sample whose vertices lie in
//! several MVoxels has an entry in each, and partial sums are added up).
//! Counted are the samples of each ray up to where it stops, those left out that
//! lie where the field is known to be empty; the hardware gathers an MVoxel to
//! its end.

use glam::DVec3;
use potamoi_formats::config::Config;
use potamoi_formats::rit::Vertices;
use rayon::prelude::*;
use serde::Serialize;

use crate::fields::coded::Tally;
use crate::fields::{Field, FieldError, Stops};
use crate::streams::{RitReads, Streams, Visit};
use crate::tiling::{Halo, Tiling, cell, cube_edge};

/// What a frame moves for one size of ray groups.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Traffic {
    /// Pixels a side of a ray group.
    pub side: u32,
    /// How MVoxels share vertices; splats have none.
    pub halo: Option<Halo>,
    /// MVoxels loaded, over all ray groups.
    pub mvoxels: u64,
    /// Entries of the ray index table.
    pub entries: u64,
    /// Bytes, stream by stream.
    pub streams: Streams,
    /// Of the bytes of MVoxels, those that are fetched row by row: of tables that
    /// do not stream, and of splats' MVoxels of which a ray group uses little.
    pub scattered: u64,
}

impl Traffic {
    /// Of nothing.
    pub(super) fn of(side: u32, halo: Option<Halo>) -> Self {
        Self {
            side,
            halo,
            mvoxels: 0,
            entries: 0,
            streams: Streams::default(),
            scattered: 0,
        }
    }

    /// Of both.
    pub(crate) fn and(self, other: Self) -> Self {
        Self {
            mvoxels: self.mvoxels + other.mvoxels,
            entries: self.entries + other.entries,
            streams: self.streams + other.streams,
            scattered: self.scattered + other.scattered,
            ..self
        }
    }
}

/// Whether a field is one dense volume.
#[must_use]
pub fn is_volume(field: &dyn Field) -> bool {
    matches!(field.tables(), [table] if table.vertices() == 8 && !table.is_hashed())
}

/// Counts a field of one dense volume, cut into the largest cubic MVoxels that
/// the configuration's rows hold, for each side of ray groups and both halos.
///
/// # Errors
/// A field of another kind, or rows for less than 2 x 2 x 2 vertices.
pub fn traffic(
    stops: &Stops<'_>,
    config: &Config,
    sides: &[u32],
) -> Result<Vec<Traffic>, FieldError> {
    let field = stops.field();
    let [table] = field.tables() else {
        return Err(FieldError::Part {
            part: "tables",
            found: format!("{} tables", field.tables().len()),
            expected: "one volume".to_owned(),
        });
    };
    let (points, channels) = (table.points(), table.channels());
    let edge = cube_edge(config.mvoxel.rows);
    let Some(edge) = edge.filter(|_| points.iter().all(|p| *p >= 2)) else {
        return Err(FieldError::Part {
            part: "mvoxel",
            found: format!("{} rows for {points:?} vertices", config.mvoxel.rows),
            expected: "8 rows or more, and 2 or more vertices along each axis".to_owned(),
        });
    };
    let reads = RitReads::of(config);
    let [width, height] = [stops.camera().width, stops.camera().height];
    let halos = [Halo::Shared, Halo::Split];
    let tilings = halos.map(|halo| Tiling::new(points, [edge; 3], halo));
    let mut found = vec![];
    for side in sides.iter().copied() {
        let across = width.div_ceil(side);
        let groups = (0..across * height.div_ceil(side)).into_par_iter();
        let counts = groups.map(|group| {
            let corner = [group % across * side, group / across * side];
            let mut tallies = tilings.map(|tiling| (tiling, Tally::default()));
            let mut places = [DVec3::ZERO];
            for y in corner[1]..(corner[1] + side).min(height) {
                for x in corner[0]..(corner[0] + side).min(width) {
                    stops.samples([x, y], 1, &mut places, |places| {
                        let (low, fraction) = cell(points, places[0].to_array());
                        for (tiling, tally) in &mut tallies {
                            tally.touch(tiling, &tiling.place(low, fraction));
                        }
                    });
                }
            }
            tallies.map(|(tiling, tally)| {
                let mut found = Traffic::of(side, Some(tiling.halo()));
                for mvoxel in tally.done().into_values() {
                    found.mvoxels += 1;
                    found.entries += mvoxel.whole + mvoxel.split;
                    let visit = Visit {
                        vertices: Vertices::Eight,
                        channels,
                        rows: mvoxel.last + 1,
                        whole: mvoxel.whole,
                        split: mvoxel.split,
                    };
                    found.streams.visit(&visit, reads);
                }
                found
            })
        });
        let none = || halos.map(|halo| Traffic::of(side, Some(halo)));
        found.extend(counts.reduce(none, |[a, b], [c, d]| [a.and(c), b.and(d)]));
    }
    Ok(found)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::panic)]
    use super::super::Endless;
    use super::*;
    use crate::fields::coded::Touched;

    use crate::fields::stored::StoredField;
    use crate::scene::{Model, Scene};
    use crate::units::Twins;
    use crate::voxels::{FixedOptions, MVoxels, Skip, render_fixed};

    /// By hand: of nine vertices an axis, the middle one starts the second
    /// MVoxel of four.
    #[test]
    fn a_sample_on_the_seam_has_an_entry_on_each_side() {
        let of = |halo, cell| {
            let tiling = Tiling::new([9; 3], [4; 3], halo);
            let mut tally = Tally::default();
            tally.touch(&tiling, &tiling.place(cell, [0; 3]));
            tally.done()
        };
        let entries = |halo, cell| {
            let all = of(halo, cell);
            let sum = |of: fn(&Touched) -> u64| all.values().map(of).sum::<u64>();
            [sum(|t| t.whole), sum(|t| t.split)]
        };
        assert_eq!(entries(Halo::Split, [1, 1, 1]), [1, 0]);
        assert_eq!(entries(Halo::Split, [3, 1, 1]), [0, 2]);
        assert_eq!(entries(Halo::Split, [3, 3, 1]), [0, 4]);
        assert_eq!(entries(Halo::Split, [3, 7, 3]), [0, 8]);
        assert_eq!(entries(Halo::Shared, [3, 3, 3]), [1, 0]);
        let touched = of(Halo::Split, [3, 0, 0]);
        // Vertices (3, 1, 1) there and (0, 1, 1) here, of 4 x 4 x 4.
        assert_eq!(touched[&0].last, 3 + 4 * (1 + 4));
        assert_eq!(touched[&1].last, 4 * (1 + 4));
    }

    /// Where no ray stops, every stream and the total are those that the renderer
    /// counts; where the table is read several times, too.
    #[test]
    fn counts_are_those_of_the_renderer() {
        let mut scene = Scene::open("lantern").unwrap();
        scene.set_size(Some(24), Some(20)).unwrap();
        let Model::Voxels(grid) = scene.model() else {
            panic!("the lantern is a grid")
        };
        let stored = StoredField::new(grid, 0.5).unwrap();
        let field = Endless(&stored);
        for (text, segments) in [
            ("", 1),
            ("[gu]\nbanks = 4\nsegments = 4\n[rit]\nentries = 16", 4),
        ] {
            let config = Config::from_toml(text, "test").unwrap();
            let shared = MVoxels::new(grid, &config).unwrap();
            for side in [8, 24] {
                let stops = Stops::find(&field, scene.camera()).unwrap();
                let counted = traffic(&stops, &config, &[side]).unwrap();
                let halos = [Halo::Shared, Halo::Split];
                for (halo, found) in halos.into_iter().zip(&counted) {
                    let options = FixedOptions {
                        group_side: Some(side),
                        skip: Skip::Cells,
                        terminate: false,
                        ..FixedOptions::default()
                    };
                    let mut units = Twins::new(&config);
                    let mvoxels = shared.with_halo(halo);
                    let frame =
                        render_fixed(grid, &mvoxels, scene.camera(), &options, &mut units).unwrap();
                    let stats = &frame.stats;
                    assert_eq!((found.side, found.halo), (side, Some(halo)));
                    assert_eq!((found.mvoxels, found.entries), (stats.tasks, stats.entries));
                    assert_eq!(found.streams, stats.streams, "{side} {halo:?}");
                    let s = stats.streams;
                    let sum = s.mvoxels_read + s.rit_written + s.rit_read + s.features;
                    assert_eq!(found.streams.total(), sum + s.partial_sums);
                    // Halves of 16 entries are exceeded, but not by every MVoxel.
                    assert_eq!(s.rit_read > s.rit_written, segments > 1);
                    assert!(s.rit_read < 4 * s.rit_written);
                    assert_eq!(s.partial_sums > 0, halo == Halo::Split);
                }
                // Splitting asks for more.
                let [shared, split] = [counted[0], counted[1]];
                let share = split.entries as f64 / shared.entries as f64;
                assert!((1.2..1.6).contains(&share), "{share}");
            }
        }
    }
}
