//! Remaps task rows to the fixed layout that the parity and compact units expect.
//!
//! The renderers number a task's rows within its MVoxel, which the grid's border may cut short. A
//! unit that makes rows itself, or reads eight at once, needs the numbers of a full MVoxel
//! ([`MvoxelConfig::edges`]): the missing rows are loaded as 0.

use potamoi_formats::compact::CompactEntry;
use potamoi_formats::config::{Config, EntryKind, MvoxelConfig};
use potamoi_formats::rit::{MAX_VERTICES, RitEntry, Vertices};
use potamoi_reference::GatherTask;
use potamoi_reference::weights::fractions;

/// A task with remapped rows.
#[derive(Debug, Clone)]
pub(crate) struct RemappedTask {
    /// Entries with rows of a full MVoxel.
    pub(crate) entries: Vec<RitEntry>,
    /// Compact entries, if the unit takes them.
    pub(crate) compact: Vec<CompactEntry>,
    /// Grids of both MVoxels.
    grid: Grid,
    /// Rows of the task.
    rows: usize,
}

/// Vertices along x and y of a task's MVoxel and of a full one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Grid {
    own: [usize; 2],
    full: [usize; 3],
}

impl Grid {
    /// Derives the grids from the row distances within an entry's cell.
    fn of(entry: &RitEntry, vertices: Vertices, mvoxel: &MvoxelConfig) -> Option<Self> {
        let full = mvoxel.edges(vertices.log2())?;
        let from_first = |v: usize| usize::from(entry.rows[v]).checked_sub(entry.rows[0].into());
        let own = match vertices {
            Vertices::One => return None,
            Vertices::Two => [full[0], 1],
            Vertices::Four => [from_first(2)?, full[1]],
            Vertices::Eight => {
                let (line, plane) = (from_first(2)?, from_first(4)?);
                if line == 0 || !plane.is_multiple_of(line) {
                    return None;
                }
                [line, plane / line]
            }
        };
        (own[0] > 1 && own[0] <= full[0] && own[1] <= full[1]).then_some(Self { own, full })
    }

    /// Position of a task row along x, y and z.
    fn place(&self, row: usize) -> [usize; 3] {
        let [x, y] = self.own;
        [row % x, row / x % y, row / (x * y)]
    }

    /// Row of a full MVoxel at a position, if it has one.
    fn row(&self, place: [usize; 3]) -> Option<u16> {
        let [x, y, z] = self.full;
        let inside = place[0] < x && place[1] < y && place[2] < z;
        let row = place[0] + x * (place[1] + y * place[2]);
        u16::try_from(row).ok().filter(|_| inside)
    }

    /// Rows of an entry's cell in a full MVoxel, if the entry addresses a cell.
    fn cell(&self, entry: &RitEntry, vertices: Vertices) -> Option<[u16; MAX_VERTICES]> {
        let [x, y] = self.own;
        let first = usize::from(entry.rows[0]);
        let place = self.place(first);
        let mut rows = [0; MAX_VERTICES];
        for (v, row) in rows.iter_mut().enumerate().take(vertices.count()) {
            let far = [v & 1, v >> 1 & 1, v >> 2];
            if usize::from(entry.rows[v]) != first + far[0] + x * (far[1] + y * far[2]) {
                return None;
            }
            let at = [0, 1, 2].map(|axis| place[axis] + far[axis]);
            if at[0] >= x || vertices == Vertices::Eight && at[1] >= y {
                return None;
            }
            *row = self.row(at)?;
        }
        Some(rows)
    }
}

/// Whether a unit needs remapped rows for such entries.
pub(crate) fn is_needed(config: &Config, vertices: Vertices) -> bool {
    vertices.is_structured() && (config.is_parity() || config.rit.entry == EntryKind::Compact)
}

impl RemappedTask {
    /// Remaps a task.
    ///
    /// # Errors
    /// Why an entry addresses no cell of an MVoxel, or has no compact form.
    pub(crate) fn new(config: &Config, task: &GatherTask) -> Result<Self, String> {
        let (vertices, bits) = (task.vertices, config.gu.weight_bits);
        let none = |i: usize, entry: &RitEntry| {
            let rows = &entry.rows[..vertices.count()];
            format!(
                "entry {i} names rows {rows:?}, which are no cell of an MVoxel of mvoxel.rows = {}; \
                 use rit.entry = \"paper\" and the channel-major organisation",
                config.mvoxel.rows
            )
        };
        let first = task.entries.first().ok_or("no entries")?;
        let grid = Grid::of(first, vertices, &config.mvoxel).ok_or_else(|| none(0, first))?;
        let mut placed = Self {
            entries: Vec::with_capacity(task.entries.len()),
            compact: vec![],
            grid,
            rows: task.rows.len() / task.channels.max(1),
        };
        for (i, entry) in task.entries.iter().enumerate() {
            let rows = grid.cell(entry, vertices).ok_or_else(|| none(i, entry))?;
            placed.entries.push(RitEntry { rows, ..*entry });
            if config.rit.entry != EntryKind::Compact {
                continue;
            }
            let fraction = fractions(&entry.weights, vertices.count(), bits).ok_or_else(|| {
                format!(
                    "entry {i} has weights {:?} that are no split tree of three fractions; \
                     use rit.entry = \"paper\"",
                    entry.weights
                )
            })?;
            placed.compact.push(CompactEntry {
                slot: entry.slot as u16,
                row: rows[0],
                fraction,
            });
        }
        Ok(placed)
    }

    /// Rows of a full MVoxel, up to the last one in the task.
    pub(crate) fn full_rows(&self) -> usize {
        let full = |row| self.grid.row(self.grid.place(row));
        let last = (0..self.rows).filter_map(full).max();
        last.map_or(0, |row| usize::from(row) + 1)
    }

    /// Task row at a position of a full MVoxel, if the task has it.
    pub(crate) fn own_row(&self, place: [usize; 3]) -> Option<usize> {
        let [x, y] = self.grid.own;
        let row = place[0] + x * (place[1] + y * place[2]);
        (place[0] < x && place[1] < y && row < self.rows).then_some(row)
    }

    /// Position of a row of a full MVoxel.
    pub(crate) fn place_of(&self, row: usize) -> [usize; 3] {
        let [x, y, _] = self.grid.full;
        [row % x, row / x % y, row / (x * y)]
    }

    /// Blocks of 2 x 2 x 2 vertices, up to the last one with a row of the task.
    pub(crate) fn blocks(&self) -> usize {
        let edge = self.grid.full[0] / 2;
        let block = |row: usize| {
            let [x, y, z] = self.grid.place(row).map(|at| at / 2);
            x + edge * (y + edge * z)
        };
        (0..self.rows).map(|row| block(row) + 1).max().unwrap_or(0)
    }

    /// Position of a block's vertex, by its parities.
    pub(crate) fn place_in_block(&self, block: usize, parity: usize) -> [usize; 3] {
        let edge = self.grid.full[0] / 2;
        let at = [block % edge, block / edge % edge, block / (edge * edge)];
        [0, 1, 2].map(|axis| 2 * at[axis] + (parity >> axis & 1))
    }
}
