//! The gathering unit's work for a frame of splats: MVoxels, their records, and the ray index
//! table.
//!
//! A Gaussian belongs to the MVoxel of its centre, wherever its extent reaches. Entries are per
//! (tile, Gaussian), so rays outside the cell still find it. In memory an MVoxel is the records of
//! its visible Gaussians by rank, the same for every ray group. A ray group is a set of whole
//! tiles. It visits MVoxels by increasing minimum rank of the records in its tiles, and loads the
//! records that it uses by [`Load`].
//!
//! With [`ScheduleOptions::limits`], pairs in whose tile no pixel can count have no entry. The order of
//! MVoxels is still that of the profile's own list, so that the approximate order composites the
//! others as without limits, bit for bit.

use std::collections::HashMap;

use potamoi_formats::config::SplatOpacity;
use potamoi_formats::record::{RECORD_CHANNELS, SplatRecord};
use potamoi_formats::rit::{MAX_VERTICES, RitEntry, Vertices};

use super::error::RenderError;
use super::octree::Octree;
use super::partition::{Cells, Partition};
use super::profile::Profile;
use super::records::Saturations;
use super::tile_test::{TileLimits, kept};
use super::view::View;
use potamoi_base::camera::Camera;
use potamoi_base::mask::Mask;
use potamoi_gaussians::Cloud;
use potamoi_reference::GatherTask;

/// Maximum number of rows with 16-bit row numbers.
const MAX_ROWS: usize = 1 << 16;
/// Maximum number of slots with the tag of a single-id entry.
const MAX_SLOTS: usize = 1 << 16;

/// DRAM energy of a random byte relative to that of a streamed byte, in tenths (paper, Sec.
/// "Experimental Setup": 25 to 8.3).
const RANDOM_ENERGY: u64 = 250;
const STREAM_ENERGY: u64 = 83;

/// The way in which a ray group loads the records of an MVoxel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Load {
    /// One stream from the first record of the MVoxel up to the last used, including records that
    /// the group does not use.
    Streamed,
    /// Only the used records, each a random access: its 32 bytes are one burst of LPDDR3 (eight
    /// beats of 32 bits).
    Fetched,
}

impl Load {
    /// The alternative that takes less DRAM energy, for `used` of the `rows` records up to the
    /// last used: fetching if less than 8.3/25 of them, about a third, are used.
    #[must_use]
    pub const fn cheaper(used: usize, rows: usize) -> Self {
        if used as u64 * RANDOM_ENERGY < rows as u64 * STREAM_ENERGY {
            Self::Fetched
        } else {
            Self::Streamed
        }
    }
}

/// An MVoxel of a ray group, in visiting order.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct MVoxel {
    /// Its cell of the partition, the lowest of merged ones. A cell with more visible Gaussians
    /// than rows becomes several MVoxels.
    pub cell: [u32; 3],
    /// The smallest rank among the records that the group uses from here on, in this MVoxel and all
    /// later ones.
    pub min_rank: u32,
    /// The way in which its records are loaded.
    pub load: Load,
}

/// The work of one ray group.
#[derive(Debug, Clone, PartialEq)]
pub struct Group {
    /// The tile of each slot.
    pub tiles: Vec<u32>,
    /// Gathering tasks, one an MVoxel. Empty if nothing is visible.
    pub tasks: Vec<GatherTask>,
    /// The MVoxel of each task.
    pub mvoxels: Vec<MVoxel>,
}

impl Group {
    /// Bytes of records fetched one by one.
    #[must_use]
    pub fn scattered_bytes(&self) -> u64 {
        let both = self.tasks.iter().zip(&self.mvoxels);
        both.filter(|(_, mvoxel)| mvoxel.load == Load::Fetched)
            .map(|(task, _)| size_of_val(task.rows.as_slice()) as u64)
            .sum()
    }
}

/// Sizes of ray groups and MVoxels.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ScheduleOptions {
    /// Maximum number of records in an MVoxel: rows of the MVoxel feature table.
    pub rows: usize,
    /// Columns and rows of tiles in a ray group; `None` for the whole frame.
    pub group_tiles: Option<[u32; 2]>,
    /// The division of the cloud into MVoxels.
    pub cells: Cells,
    /// Limits by which (tile, Gaussian) pairs are left out in whose tile no pixel can count. `None`, or
    /// limits of rules with a higher alpha threshold: all pairs have entries.
    pub limits: Option<TileLimits>,
    /// What records hold of an opacity.
    pub opacity: SplatOpacity,
}

impl Default for ScheduleOptions {
    fn default() -> Self {
        Self {
            rows: 512,
            group_tiles: None,
            cells: Cells::MERGED,
            limits: None,
            opacity: SplatOpacity::Multiplied,
        }
    }
}

/// The work of a frame, built group by group.
#[derive(Debug, Clone)]
pub struct Schedule {
    records: Vec<SplatRecord>,
    stored: Vec<Stored>,
    places: Vec<RecordLocation>,
    partition: Partition,
    saturations: Saturations,
    tiles: Vec<Vec<u32>>,
    /// Pairs of the profile's list, group after group, by rank.
    entries: Vec<Vec<Listed>>,
    test: Option<PairTest>,
}

/// (tile, Gaussian) pairs that were tested, in tiles that are wanted.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, serde::Serialize, schemars::JsonSchema)]
pub struct PairTest {
    /// Pairs of the profile's list.
    pub pairs: u64,
    /// Those in whose tile no pixel can count: they have no entry.
    pub left_out: u64,
}

/// A pair of the profile's list, in a tile that is wanted.
#[derive(Debug, Clone, Copy)]
struct Listed {
    rank: u32,
    slot: u16,
    /// Whether it has an entry.
    is_kept: bool,
}

/// An MVoxel as laid out in memory.
#[derive(Debug, Clone)]
struct Stored {
    cell: [u32; 3],
    /// The rank of each record, increasing.
    ranks: Vec<u32>,
}

/// Location of a record in memory.
#[derive(Debug, Clone, Copy)]
struct RecordLocation {
    mvoxel: usize,
    row: u16,
}

/// Lays out records in MVoxels of at most `rows`. `cells` are those of the records, by rank.
fn store(cells: impl Iterator<Item = [u32; 3]>, rows: usize) -> (Vec<Stored>, Vec<RecordLocation>) {
    let mut stored: Vec<Stored> = Vec::new();
    // The MVoxel of each cell that still takes records.
    let mut open: HashMap<[u32; 3], usize> = HashMap::new();
    let places = (0..)
        .zip(cells)
        .map(|(rank, cell)| {
            let mvoxel = match open.get(&cell) {
                Some(&at) if stored[at].ranks.len() < rows => at,
                _ => {
                    let ranks = Vec::new();
                    stored.push(Stored { cell, ranks });
                    open.insert(cell, stored.len() - 1);
                    stored.len() - 1
                }
            };
            let ranks = &mut stored[mvoxel].ranks;
            ranks.push(rank);
            // Of MAX_ROWS at most.
            let row = (ranks.len() - 1) as u16;
            RecordLocation { mvoxel, row }
        })
        .collect();
    (stored, places)
}

/// The part of one MVoxel that a ray group uses.
struct Used {
    mvoxel: usize,
    /// The smallest rank that has entries.
    min_rank: u32,
    /// Rows in memory, increasing.
    rows: Vec<u16>,
    /// The last used row.
    last: u16,
    /// For each entry, the index of its row in `rows`, and its slot.
    entries: Vec<(u16, u16)>,
}

impl Schedule {
    /// Plans a view of `cloud`.
    ///
    /// # Errors
    /// An option is out of range, or a ray group has more than 65,536 tiles.
    pub fn new(cloud: &Cloud, view: &View, options: &ScheduleOptions) -> Result<Self, RenderError> {
        Self::masked(cloud, view, options, None)
    }

    /// As [`Schedule::new`], with entries only for tiles that have a pixel of a mask.
    ///
    /// # Errors
    /// Those of [`Schedule::new`].
    pub fn masked(
        cloud: &Cloud,
        view: &View,
        options: &ScheduleOptions,
        only: Option<&Mask>,
    ) -> Result<Self, RenderError> {
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
        let wanted: Vec<bool> = (0..view.tile_count())
            .map(|tile| only.is_none_or(|mask| view.shows(tile, mask)))
            .collect();
        let mut saturations = Saturations::default();
        let records = view.records(options.opacity, &mut saturations);
        let limits = (options.limits.as_ref()).filter(|limits| limits.hold_for(view.rules()));
        let kept = limits.map(|limits| kept(view, &records, limits));
        let mut kept = kept.iter().flatten();
        let mut entries = vec![Vec::new(); count];
        let mut test = PairTest::default();
        for rank in 0..records.len() {
            for tile in view.tiles_of(rank) {
                let is_kept = limits.is_none() || kept.next().copied().unwrap_or(true);
                if wanted[*tile as usize] {
                    test.pairs += 1;
                    test.left_out += u64::from(!is_kept);
                    let (group, slot) = place(*tile);
                    entries[group].push(Listed {
                        rank: rank as u32,
                        slot,
                        is_kept,
                    });
                }
            }
        }
        let partition = Partition::halved(cloud, options.rows, options.cells.halvings);
        let tree = options
            .cells
            .merge
            .then(|| Octree::merge(cloud, &partition, options.rows));
        let cells = view.splats().iter().map(|s| {
            let cell = partition.cell(cloud.means()[s.index]);
            tree.as_ref().map_or(cell, |tree| tree.owner(cell))
        });
        let (stored, places) = store(cells, options.rows);
        Ok(Self {
            records,
            stored,
            places,
            partition,
            saturations,
            tiles,
            entries,
            test: limits.map(|_| test),
        })
    }

    /// Pairs that were tested, and left out; `None` without limits.
    #[must_use]
    pub fn test(&self) -> Option<PairTest> {
        self.test
    }

    /// For each slot of a group, the place of each of its entries in the profile's list of that tile;
    /// `None` where no pair is left out.
    pub(crate) fn profile_places(&self, group: usize) -> Option<Vec<Vec<u32>>> {
        self.test.filter(|test| test.left_out > 0)?;
        let slots = self.tiles.get(group)?.len();
        let mut places = vec![Vec::new(); slots];
        let mut met = vec![0; slots];
        for pair in &self.entries[group] {
            let slot = usize::from(pair.slot);
            if pair.is_kept {
                places[slot].push(met[slot]);
            }
            met[slot] += 1;
        }
        Some(places)
    }

    /// Number of ray groups.
    #[must_use]
    pub fn groups(&self) -> usize {
        self.tiles.len()
    }

    /// The partition into MVoxels.
    #[must_use]
    pub fn partition(&self) -> &Partition {
        &self.partition
    }

    /// Numbers of record values that saturated.
    #[must_use]
    pub fn saturations(&self) -> Saturations {
        self.saturations
    }

    /// Records of the frame, by rank.
    #[must_use]
    pub fn records(&self) -> &[SplatRecord] {
        &self.records
    }

    /// The work of group `group`; `None` if out of range.
    #[must_use]
    pub fn group(&self, group: usize) -> Option<Group> {
        let tiles = self.tiles.get(group)?.clone();
        // Pairs come by rank, so that MVoxels appear by minimum rank.
        let mut visits: Vec<Used> = Vec::new();
        let mut seen: HashMap<usize, usize> = HashMap::new();
        for run in self.entries[group].chunk_by(|a, b| a.rank == b.rank) {
            let rank = run[0].rank;
            let RecordLocation { mvoxel, row } = self.places[rank as usize];
            let at = *seen.entry(mvoxel).or_insert_with(|| {
                visits.push(Used {
                    mvoxel,
                    min_rank: rank,
                    rows: Vec::new(),
                    last: row,
                    entries: Vec::new(),
                });
                visits.len() - 1
            });
            let used = &mut visits[at];
            let at = used.rows.len() as u16;
            let kept = run.iter().filter(|pair| pair.is_kept);
            used.entries.extend(kept.map(|pair| (at, pair.slot)));
            if run.iter().any(|pair| pair.is_kept) {
                used.min_rank = if at == 0 { rank } else { used.min_rank };
                used.rows.push(row);
                used.last = row;
            }
        }
        visits.retain(|used| !used.rows.is_empty());
        let mut later = u32::MAX;
        for used in visits.iter_mut().rev() {
            later = later.min(used.min_rank);
            used.min_rank = later;
        }
        let (tasks, mvoxels) = visits.iter().map(|used| self.load(used)).unzip();
        Some(Group {
            tiles,
            tasks,
            mvoxels,
        })
    }

    /// The task of an MVoxel: the records to load, and its entries.
    fn load(&self, used: &Used) -> (GatherTask, MVoxel) {
        let Stored { cell, ranks } = &self.stored[used.mvoxel];
        let up_to_last = usize::from(used.last) + 1;
        let load = Load::cheaper(used.rows.len(), up_to_last);
        let records = |ranks: &mut dyn Iterator<Item = u32>| {
            let rows = ranks.map(|rank| self.records[rank as usize].to_channels());
            rows.flatten().collect()
        };
        let rows = match load {
            Load::Streamed => records(&mut ranks[..up_to_last].iter().copied()),
            Load::Fetched => records(&mut used.rows.iter().map(|row| ranks[usize::from(*row)])),
        };
        let entries = used.entries.iter().map(|(at, slot)| {
            let mut rows = [0; MAX_VERTICES];
            rows[0] = match load {
                Load::Streamed => used.rows[usize::from(*at)],
                Load::Fetched => *at,
            };
            RitEntry {
                slot: u32::from(*slot),
                rows,
                weights: [0; MAX_VERTICES],
            }
        });
        let task = GatherTask {
            vertices: Vertices::One,
            channels: RECORD_CHANNELS,
            rows,
            entries: entries.collect(),
        };
        let mvoxel = MVoxel {
            cell: *cell,
            min_rank: used.min_rank,
            load,
        };
        (task, mvoxel)
    }
}

/// The work of a frame, all ray groups together.
///
/// # Errors
/// Those of [`View::new`] and [`Schedule::new`].
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
