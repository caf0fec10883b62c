//! Bytes that the memory-centric order moves, by ray group and halo.
//!
//! An MVoxel of `e` vertices an edge holds `e - 1` cells an edge where it shares
//! its faces with its neighbours (*shared*: stored twice, one entry a sample),
//! or `e` where nothing is stored twice (*split*: a sample whose vertices lie in
//! several MVoxels has an entry in each, and partial sums are added up).
//! Counted are the samples of each ray up to where it stops.

use std::collections::HashMap;

use glam::DVec3;
use rayon::prelude::*;
use serde::Serialize;

use crate::camera::Camera;
use crate::fields::{Field, FieldError, samples_of};

/// How MVoxels share the vertices between them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Halo {
    /// Stored in both.
    Shared,
    /// Stored once.
    Split,
}

/// Bytes of a frame, stream by stream.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Traffic {
    /// Pixels a side of a ray group.
    pub side: u32,
    /// How MVoxels share vertices.
    pub halo: Halo,
    /// MVoxels loaded, over all ray groups.
    pub mvoxels: u64,
    /// Rows loaded, each MVoxel up to the last that is used.
    pub mvoxel_bytes: u64,
    /// Entries of the ray index table.
    pub entries: u64,
    /// The table, written by the GPU and read by the gathering unit.
    pub rit_bytes: u64,
    /// Features out of the gathering unit: 16 bits a channel.
    pub feature_bytes: u64,
    /// Partial sums out of it: 32 bits a channel.
    pub partial_bytes: u64,
}

impl Traffic {
    /// All streams.
    #[must_use]
    pub fn total(&self) -> u64 {
        self.mvoxel_bytes + self.rit_bytes + self.feature_bytes + self.partial_bytes
    }
}

/// Bytes of an entry of eight vertices.
const ENTRY: u64 = 48;

/// Counts a field of one dense volume, whose MVoxels have `edge` vertices an
/// edge, for each side of ray groups and both halos.
///
/// # Errors
/// A field of another kind, or as [`crate::fields::render_float`].
pub fn traffic(
    field: &dyn Field,
    camera: &Camera,
    edge: usize,
    sides: &[u32],
) -> Result<Vec<Traffic>, FieldError> {
    let [table] = field.tables() else {
        return Err(FieldError::Part {
            part: "tables",
            found: format!("{} tables", field.tables().len()),
            expected: "one volume".to_owned(),
        });
    };
    let (points, channels) = (table.points(), table.channels() as u64);
    if edge < 2 || points.iter().any(|p| *p < 2) {
        return Err(FieldError::Part {
            part: "mvoxel",
            found: format!("{edge} vertices an edge of {points:?}"),
            expected: "2 or more of each".to_owned(),
        });
    }
    let [width, height] = [camera.width, camera.height];
    // The cell of every sample, ray after ray.
    let rays: Result<Vec<Vec<[u16; 3]>>, FieldError> = (0..width * height)
        .into_par_iter()
        .map(|i| {
            let mut cells = vec![];
            samples_of(
                field,
                camera,
                [i % width, i / width],
                |places: &[DVec3]| {
                    cells.push(cell(points, places[0]));
                },
            )?;
            Ok(cells)
        })
        .collect();
    let rays = rays?;
    let mut found = vec![];
    for side in sides.iter().copied() {
        for halo in [Halo::Shared, Halo::Split] {
            let across = width.div_ceil(side);
            let groups: Vec<u32> = (0..across * height.div_ceil(side)).collect();
            let counts: Vec<[u64; 3]> = groups
                .into_par_iter()
                .map(|group| {
                    let corner = [group % across * side, group / across * side];
                    // Last row of each MVoxel.
                    let mut last: HashMap<[u16; 3], u64> = HashMap::new();
                    let mut entries = 0;
                    for y in corner[1]..(corner[1] + side).min(height) {
                        for x in corner[0]..(corner[0] + side).min(width) {
                            for cell in &rays[(y * width + x) as usize] {
                                entries += touch(points, edge, halo, *cell, &mut last);
                            }
                        }
                    }
                    let rows: u64 = last.values().map(|row| row + 1).sum();
                    [last.len() as u64, rows, entries]
                })
                .collect();
            let sum = |i: usize| counts.iter().map(|c| c[i]).sum::<u64>();
            let (entries, rows) = (sum(2), sum(1));
            let partial = halo == Halo::Split;
            found.push(Traffic {
                side,
                halo,
                mvoxels: sum(0),
                mvoxel_bytes: rows * channels * 2,
                entries,
                rit_bytes: 2 * ENTRY * entries,
                feature_bytes: if partial { 0 } else { entries * channels * 2 },
                partial_bytes: if partial { entries * channels * 4 } else { 0 },
            });
        }
    }
    Ok(found)
}

fn cell(points: [usize; 3], place: DVec3) -> [u16; 3] {
    [0, 1, 2].map(|axis| {
        let cells = points[axis] - 1;
        // A cast holds what is outside at the ends.
        (place[axis].floor() as usize).min(cells - 1) as u16
    })
}

/// Notes the rows that a sample in a cell reads; gives its entries.
fn touch(
    points: [usize; 3],
    edge: usize,
    halo: Halo,
    cell: [u16; 3],
    last: &mut HashMap<[u16; 3], u64>,
) -> u64 {
    let stride = match halo {
        Halo::Shared => edge - 1,
        Halo::Split => edge,
    };
    let low = cell.map(|c| usize::from(c) / stride);
    let mut entries = 0;
    for corner in 0..8usize {
        let mut mvoxel = [0u16; 3];
        let mut row = 0;
        let mut fits = true;
        for axis in (0..3).rev() {
            let far = corner >> axis & 1;
            // The MVoxel next to the cell's along this axis, if it reaches there.
            let index = low[axis] + far;
            let from = index * stride;
            let vertex = usize::from(cell[axis]) + 1;
            if far == 1 && (halo == Halo::Shared || vertex < from) {
                fits = false;
                break;
            }
            let extent = edge.min(points[axis] - from);
            let local = (vertex - from).min(extent - 1);
            mvoxel[axis] = index as u16;
            row = row * extent + local;
        }
        if fits {
            entries += 1;
            let to = last.entry(mvoxel).or_default();
            *to = (*to).max(row as u64);
        }
    }
    entries
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::panic)]
    use super::*;
    use potamoi_formats::config::Config;

    use crate::fields::stored::StoredField;
    use crate::scene::{Model, Scene};
    use crate::units::GatherTask;
    use crate::voxels::{self, FixedOptions, MVoxels, Skip};

    /// By hand: of nine vertices an axis, the middle one starts the second
    /// MVoxel of four.
    #[test]
    fn a_sample_on_the_seam_has_an_entry_on_each_side() {
        let points = [9; 3];
        let entries = |halo, cell: [u16; 3]| touch(points, 4, halo, cell, &mut HashMap::new());
        assert_eq!(entries(Halo::Split, [1, 1, 1]), 1);
        assert_eq!(entries(Halo::Split, [3, 1, 1]), 2);
        assert_eq!(entries(Halo::Split, [3, 3, 1]), 4);
        assert_eq!(entries(Halo::Split, [3, 7, 3]), 8);
        assert_eq!(entries(Halo::Shared, [3, 3, 3]), 1);
        let mut last = HashMap::new();
        touch(points, 4, Halo::Split, [3, 0, 0], &mut last);
        // Vertices (3, 1, 1) there and (0, 1, 1) here, of 4 x 4 x 4.
        assert_eq!(last[&[0, 0, 0]], 3 + 4 * (1 + 4));
        assert_eq!(last[&[1, 0, 0]], 4 * (1 + 4));
    }

    /// With shared faces and no ray that stops, the counts are those of the
    /// tasks that the renderer hands to the gathering unit.
    #[test]
    fn counts_are_those_of_the_tasks() {
        struct Endless(StoredField);
        impl Field for Endless {
            fn tables(&self) -> &[crate::fields::Table] {
                self.0.tables()
            }
            fn place(&self, at: DVec3, places: &mut [DVec3]) {
                self.0.place(at, places);
            }
            fn holds(&self, at: DVec3) -> bool {
                self.0.holds(at)
            }
            fn depth(&self, _: &[f64]) -> f64 {
                0.0
            }
            fn colour(&self, _: &[f64], _: DVec3, _: &mut Vec<f64>) -> DVec3 {
                DVec3::ZERO
            }
            fn sampling(&self) -> crate::fields::Sampling {
                self.0.sampling()
            }
        }
        let mut scene = Scene::open("lantern").unwrap();
        scene.set_size(Some(24), None).unwrap();
        let Model::Voxels(grid) = scene.model() else {
            panic!("the lantern is a grid")
        };
        let field = Endless(StoredField::new(grid, 0.5).unwrap());
        let mvoxels = MVoxels::new(grid, &Config::paper()).unwrap();
        for side in [8, 24] {
            let counted = traffic(&field, scene.camera(), 8, &[side]).unwrap();
            let options = FixedOptions {
                group_side: Some(side),
                skip: Skip::Nothing,
                ..FixedOptions::default()
            };
            let camera = scene.camera();
            let tasks = voxels::tasks(grid, &mvoxels, camera, &options, usize::MAX).unwrap();
            let rows = |t: &GatherTask| (t.rows.len() / t.channels) as u64;
            let shared = &counted[0];
            assert_eq!(shared.mvoxels, tasks.len() as u64, "side {side}");
            let channels = field.channels() as u64;
            let loaded: u64 = tasks.iter().map(rows).sum();
            assert_eq!(shared.mvoxel_bytes, loaded * channels * 2);
            let entries: u64 = tasks.iter().map(|t| t.entries.len() as u64).sum();
            assert_eq!(shared.entries, entries);
            // Splitting loads less and asks for more.
            let split = &counted[1];
            assert!(split.mvoxel_bytes < shared.mvoxel_bytes);
            let share = split.entries as f64 / shared.entries as f64;
            assert!((1.2..1.6).contains(&share), "{share}");
        }
    }
}
