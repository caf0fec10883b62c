//! What the gathering unit is to do for a frame of splats: MVoxels, their
//! records, and the ray index table.
//!
//! A Gaussian belongs to the MVoxel of its centre, wherever its extent
//! reaches: entries are per (tile, Gaussian), so rays outside the cell still
//! find it. In a ray group, a set of whole tiles, MVoxels are visited by
//! increasing minimum rank, and each loads only the records that the group
//! uses, in rank order.

use std::collections::HashMap;

use potamoi_formats::record::{RECORD_CHANNELS, SplatRecord};
use potamoi_formats::rit::{MAX_VERTICES, RitEntry, Vertices};

use super::cloud::Cloud;
use super::error::RenderError;
use super::octree::Octree;
use super::partition::Partition;
use super::profile::Profile;
use super::records::{Saturations, record};
use super::view::View;
use crate::camera::Camera;
use crate::units::GatherTask;

/// The most rows that a row number of 16 bits addresses.
const MAX_ROWS: usize = 1 << 16;
/// The most slots that the tag of a single-id entry tells apart.
const MAX_SLOTS: usize = 1 << 16;

/// One MVoxel of a ray group, in visiting order.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct MVoxel {
    /// Its cell of the partition, the lowest of those that are merged. Cells with
    /// more records than rows come as several MVoxels.
    pub cell: [u32; 3],
    /// The smallest rank among its records.
    pub min_rank: u32,
}

/// The work of one ray group.
#[derive(Debug, Clone, PartialEq)]
pub struct Group {
    /// The tile of each slot.
    pub tiles: Vec<u32>,
    /// What is gathered, MVoxel after MVoxel. Empty where nothing is seen.
    pub tasks: Vec<GatherTask>,
    /// The MVoxel of each task.
    pub mvoxels: Vec<MVoxel>,
}

/// Which tiles make a ray group, and how large MVoxels are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ScheduleOptions {
    /// Records that an MVoxel holds: rows of the MVoxel feature table.
    pub rows: usize,
    /// Columns and rows of tiles of a ray group; `None` is the whole frame.
    pub group_tiles: Option<[u32; 2]>,
    /// Whether cells are merged as far as they fit an MVoxel.
    pub merge: bool,
}

impl Default for ScheduleOptions {
    fn default() -> Self {
        Self {
            rows: 512,
            group_tiles: None,
            merge: true,
        }
    }
}

/// The work of a frame, built group by group.
#[derive(Debug, Clone)]
pub struct Schedule {
    records: Vec<SplatRecord>,
    cells: Vec<[u32; 3]>,
    partition: Partition,
    saturations: Saturations,
    rows: usize,
    tiles: Vec<Vec<u32>>,
    /// (rank, slot) of each entry, group after group, by rank.
    entries: Vec<Vec<(u32, u16)>>,
}

impl Schedule {
    /// Plans a view of `cloud`.
    ///
    /// # Errors
    /// Options out of range, or a ray group of more than 65,536 tiles.
    pub fn new(cloud: &Cloud, view: &View, options: &ScheduleOptions) -> Result<Self, RenderError> {
        if !(1..=MAX_ROWS).contains(&options.rows) {
            return Err(RenderError::Option {
                field: "rows",
                value: options.rows.to_string(),
                expected: "1 to 65536 records an MVoxel",
            });
        }
        let [columns, rows] = view.grid();
        let [wide, high] = match options.group_tiles {
            None => [columns, rows],
            Some([w, h]) if w > 0 && h > 0 => [w.min(columns), h.min(rows)],
            Some(zero) => {
                return Err(RenderError::Option {
                    field: "group_tiles",
                    value: format!("{zero:?}"),
                    expected: "at least one tile",
                });
            }
        };
        let slots = wide as usize * high as usize;
        if slots > MAX_SLOTS {
            return Err(RenderError::Slots { tiles: slots });
        }
        let groups_across = columns.div_ceil(wide);
        let place = |tile: u32| {
            let (x, y) = (tile % columns, tile / columns);
            let group = (y / high * groups_across + x / wide) as usize;
            // Groups at the right edge may be narrower.
            let width = wide.min(columns - x / wide * wide);
            let slot = y % high * width + x % wide;
            (group, slot as u16)
        };
        let count = groups_across as usize * rows.div_ceil(high) as usize;
        let mut tiles = vec![Vec::new(); count];
        for tile in 0..view.tile_count() as u32 {
            tiles[place(tile).0].push(tile);
        }
        let mut entries = vec![Vec::new(); count];
        for rank in 0..view.splats().len() {
            for tile in view.tiles_of(rank) {
                let (group, slot) = place(*tile);
                entries[group].push((rank as u32, slot));
            }
        }
        let partition = Partition::coarsest(cloud, options.rows);
        let tree = options
            .merge
            .then(|| Octree::merge(cloud, &partition, options.rows));
        let mut saturations = Saturations::default();
        Ok(Self {
            records: view
                .splats()
                .iter()
                .enumerate()
                .map(|(rank, s)| record(s, rank as u32, &mut saturations))
                .collect(),
            cells: view
                .splats()
                .iter()
                .map(|s| {
                    let cell = partition.cell(cloud.means()[s.index]);
                    tree.as_ref().map_or(cell, |tree| tree.owner(cell))
                })
                .collect(),
            partition,
            saturations,
            rows: options.rows,
            tiles,
            entries,
        })
    }

    /// Ray groups of the frame.
    #[must_use]
    pub fn groups(&self) -> usize {
        self.tiles.len()
    }

    /// The partition into MVoxels.
    #[must_use]
    pub fn partition(&self) -> &Partition {
        &self.partition
    }

    /// Values of records that did not fit their format.
    #[must_use]
    pub fn saturations(&self) -> Saturations {
        self.saturations
    }

    /// Records of the frame, by rank.
    #[must_use]
    pub fn records(&self) -> &[SplatRecord] {
        &self.records
    }

    /// The work of group `group`; `None` past the last.
    #[must_use]
    pub fn group(&self, group: usize) -> Option<Group> {
        let tiles = self.tiles.get(group)?.clone();
        let mut tasks: Vec<GatherTask> = Vec::new();
        let mut mvoxels: Vec<MVoxel> = Vec::new();
        // Entries come by rank, so that MVoxels appear by minimum rank.
        let mut open: HashMap<[u32; 3], usize> = HashMap::new();
        for run in self.entries[group].chunk_by(|a, b| a.0 == b.0) {
            let rank = run[0].0;
            let cell = self.cells[rank as usize];
            let full = self.rows * RECORD_CHANNELS;
            let at = match open.get(&cell) {
                Some(&t) if tasks[t].rows.len() < full => t,
                _ => {
                    tasks.push(GatherTask {
                        vertices: Vertices::One,
                        channels: RECORD_CHANNELS,
                        rows: Vec::new(),
                        entries: Vec::new(),
                    });
                    mvoxels.push(MVoxel {
                        cell,
                        min_rank: rank,
                    });
                    open.insert(cell, tasks.len() - 1);
                    tasks.len() - 1
                }
            };
            let task = &mut tasks[at];
            let row = (task.rows.len() / RECORD_CHANNELS) as u16;
            task.rows
                .extend_from_slice(&self.records[rank as usize].to_channels());
            task.entries.extend(run.iter().map(|(_, slot)| {
                let mut rows = [0; MAX_VERTICES];
                rows[0] = row;
                RitEntry {
                    slot: u32::from(*slot),
                    rows,
                    weights: [0; MAX_VERTICES],
                }
            }));
        }
        Some(Group {
            tiles,
            tasks,
            mvoxels,
        })
    }
}

/// The work of a frame, all ray groups at once.
///
/// # Errors
/// As [`View::new`] and [`Schedule::new`].
pub fn tasks(
    cloud: &Cloud,
    camera: &Camera,
    profile: Profile,
    options: &ScheduleOptions,
) -> Result<Vec<Group>, RenderError> {
    let view = View::new(cloud, camera, profile)?;
    let schedule = Schedule::new(cloud, &view, options)?;
    Ok((0..schedule.groups())
        .filter_map(|g| schedule.group(g))
        .collect())
}
