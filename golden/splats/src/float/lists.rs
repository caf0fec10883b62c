//! The Gaussians of each tile, front to back.

use std::ops::Range;

use rayon::prelude::*;

use super::prepared::Prepared;
use super::splats::{CHUNK, reach, reached};
use crate::coverage::Grid;
use crate::view::View;

/// The lists of some rows of tiles.
pub(super) struct Lists {
    /// Rows of tiles.
    pub(super) rows: Range<usize>,
    /// Tiles a row.
    columns: usize,
    /// `first[t]..first[t + 1]` are the places of the `t`th tile's Gaussians.
    first: Vec<u32>,
    slots: Vec<u32>,
    /// The place of each Gaussian among the entries of its tile, where that is asked for.
    entries: Vec<u32>,
}

/// The list of one tile.
#[derive(Debug, Clone, Copy)]
pub(super) struct List<'a> {
    pub(super) slots: &'a [u32],
    /// As long as `slots`, or empty.
    pub(super) entries: &'a [u32],
}

impl List<'_> {
    /// The list of a tile in which nothing is drawn.
    pub(super) const EMPTY: Self = Self {
        slots: &[],
        entries: &[],
    };
}

impl Lists {
    /// The list of a tile, by its row and column.
    pub(super) fn of(&self, row: usize, column: usize) -> List<'_> {
        let tile = (row - self.rows.start) * self.columns + column;
        let own = self.first[tile] as usize..self.first[tile + 1] as usize;
        List {
            slots: &self.slots[own.clone()],
            entries: self.entries.get(own).unwrap_or_default(),
        }
    }

    /// The lists of Gaussians in the order of `order`, in parts of about equal length.
    pub(super) fn new(order: &[u32], prepared: &Prepared, grid: Grid, parts: usize) -> Vec<Self> {
        let tiles = |slot: &u32| prepared.tiles[*slot as usize / CHUNK][*slot as usize % CHUNK];
        let tiles: Vec<[u16; 4]> = order.par_iter().map(tiles).collect();
        let parts: Vec<Range<usize>> = shared_out(&pairs_by_row(&tiles, grid), parts);
        parts
            .into_par_iter()
            .map(|rows| Self::of_rows(order, &tiles, grid, rows))
            .collect()
    }

    fn of_rows(order: &[u32], tiles: &[[u16; 4]], grid: Grid, rows: Range<usize>) -> Self {
        let columns = grid.columns as usize;
        let mut first = vec![0u32; rows.len() * columns + 1];
        for own in tiles {
            each_tile(own, &rows, columns, |tile| first[tile + 1] += 1);
        }
        let mut sum = 0;
        for place in &mut first {
            sum += *place;
            *place = sum;
        }
        let mut next = first.clone();
        let mut slots = vec![0; sum as usize];
        for (own, slot) in tiles.iter().zip(order) {
            each_tile(own, &rows, columns, |tile| {
                slots[next[tile] as usize] = *slot;
                next[tile] += 1;
            });
        }
        Self {
            rows,
            columns,
            first,
            slots,
            entries: vec![],
        }
    }

    /// The entries of a view that can reach a pixel of their tile, with their places.
    pub(super) fn of_view(view: &View, first: &[usize], ranks: &[u32]) -> Self {
        let raster = view.raster();
        let spans: Vec<_> = (view.splats().par_iter())
            .map(|splat| {
                let reach = reach(splat, view.rules())?;
                Some(reached(splat, reach, raster.grid(), view.rules()))
            })
            .collect();
        let [columns, rows] = view.grid().map(|v| v as usize);
        let mut own = Self {
            rows: 0..rows,
            columns,
            first: vec![0],
            slots: vec![],
            entries: vec![],
        };
        for tile in 0..view.tile_count() {
            let [x, y] = [tile % columns, tile / columns].map(|v| v as u32);
            for (entry, rank) in (0..).zip(&ranks[first[tile]..first[tile + 1]]) {
                let is_reached = spans[*rank as usize].is_some_and(|span| {
                    (span.x[0]..span.x[1]).contains(&x) && (span.y[0]..span.y[1]).contains(&y)
                });
                if is_reached {
                    own.slots.push(*rank);
                    own.entries.push(entry);
                }
            }
            own.first.push(own.slots.len() as u32);
        }
        own
    }
}

/// Calls `visit` with each tile of a rectangle that is in these rows, counted from their first.
#[inline(always)]
fn each_tile(own: &[u16; 4], rows: &Range<usize>, columns: usize, mut visit: impl FnMut(usize)) {
    let [x0, y0, x1, y1] = own.map(usize::from);
    for y in y0.max(rows.start)..y1.min(rows.end) {
        let row = (y - rows.start) * columns;
        (row + x0..row + x1).for_each(&mut visit);
    }
}

/// Number of (tile, Gaussian) pairs in each row of tiles.
fn pairs_by_row(tiles: &[[u16; 4]], grid: Grid) -> Vec<u64> {
    let mut change = vec![0i64; grid.rows as usize + 1];
    for [x0, y0, x1, y1] in tiles {
        let wide = i64::from(x1 - x0);
        change[usize::from(*y0)] += wide;
        change[usize::from(*y1)] -= wide;
    }
    let sums = change.iter().scan(0, |sum, by| {
        *sum += by;
        Some(*sum as u64)
    });
    sums.take(grid.rows as usize).collect()
}

/// Ranges of at most `parts` in which rows with about as many pairs lie.
fn shared_out(pairs: &[u64], parts: usize) -> Vec<Range<usize>> {
    let parts = parts.clamp(1, pairs.len().max(1)) as u64;
    // A row without a pair is to be shared out too.
    let all: u64 = pairs.iter().map(|own| own + 1).sum();
    let (mut ranges, mut start, mut sum) = (vec![], 0, 0);
    for (row, own) in pairs.iter().enumerate() {
        sum += own + 1;
        if sum * parts >= all * (ranges.len() as u64 + 1) {
            ranges.push(start..row + 1);
            start = row + 1;
        }
    }
    ranges
}
