//! Traffic of MVoxels and of the reorder buffer, recounted from the tiles that each Gaussian
//! covers and the cell of its centre.

use std::collections::BTreeMap;

use potamoi_base::camera::Camera;
use potamoi_formats::config::SplatOpacity;
use potamoi_gaussians::Cloud;
use potamoi_scene::characterise::splat_traffic;
use potamoi_splats::{
    Cells, FixedOptions, Octree, Order, Partition, Profile, ScheduleOptions, View,
};

use super::{APART, LOG, fixed, small};

#[derive(Debug, Default, PartialEq, Eq)]
struct Recount {
    mvoxels: u64,
    read: u64,
    scattered: u64,
    /// Streamed, but not used.
    unused: u64,
    /// Records that go to memory, and their tiles.
    out: u64,
    tiles_out: u64,
    spills: u64,
}

/// Ranks of the records of each MVoxel, as they lie in memory.
fn memory(cloud: &Cloud, view: &View, options: &ScheduleOptions) -> Vec<Vec<usize>> {
    let partition = Partition::halved(cloud, options.rows, options.cells.halvings);
    let tree = Octree::merge(cloud, &partition, options.rows);
    let mut cells: BTreeMap<[u32; 3], Vec<usize>> = BTreeMap::new();
    for (rank, splat) in view.splats().iter().enumerate() {
        let mut cell = partition.cell(cloud.means()[splat.index]);
        if options.cells.merge {
            cell = tree.owner(cell);
        }
        cells.entry(cell).or_default().push(rank);
    }
    let chunks = cells.values().flat_map(|ranks| ranks.chunks(options.rows));
    chunks.map(<[usize]>::to_vec).collect()
}

impl Recount {
    fn of(cloud: &Cloud, view: &View, options: &FixedOptions) -> Self {
        let mut found = Self::default();
        let [columns, rows] = view.grid();
        let [wide, high] = options.schedule.group_tiles.unwrap_or([columns, rows]);
        let memory = memory(cloud, view, &options.schedule);
        for top in (0..rows).step_by(high as usize) {
            for left in (0..columns).step_by(wide as usize) {
                let inside = |tile: &&u32| {
                    let (x, y) = (**tile % columns, **tile / columns);
                    (left..left + wide).contains(&x) && (top..top + high).contains(&y)
                };
                let tiles = |rank: usize| view.tiles_of(rank).iter().filter(inside).count();
                found.group(&memory, tiles, options);
            }
        }
        found
    }

    fn group(
        &mut self,
        memory: &[Vec<usize>],
        tiles: impl Fn(usize) -> usize,
        options: &FixedOptions,
    ) {
        // (rank, tiles) of the records that the group uses of each MVoxel.
        let mut visits: Vec<Vec<(usize, u64)>> = vec![];
        for ranks in memory {
            let used: Vec<_> = ranks
                .iter()
                .map(|rank| (*rank, tiles(*rank) as u64))
                .filter(|(_, tiles)| *tiles > 0)
                .collect();
            let Some((last, _)) = used.last() else {
                continue;
            };
            let streamed = ranks.iter().filter(|rank| *rank <= last).count() as u64;
            let fetched = used.len() as u64;
            // 25 pJ for a random byte where one of a stream takes 8.3.
            if fetched * 250 < streamed * 83 {
                self.read += 32 * fetched;
                self.scattered += 32 * fetched;
            } else {
                self.read += 32 * streamed;
                self.unused += 32 * (streamed - fetched);
            }
            self.mvoxels += 1;
            visits.push(used);
        }
        if options.order == Order::Exact {
            visits.sort();
            self.hold(&visits, options.hold_records);
        }
    }

    /// Record by record: what no MVoxel to come lies before leaves, and of those
    /// that stay the last one goes to memory where they are too many.
    fn hold(&mut self, visits: &[Vec<(usize, u64)>], capacity: usize) {
        let bytes = |tiles: u64| 32 + 2 + 2 * tiles;
        let (mut chip, mut away) = (vec![], vec![]);
        for (t, arrivals) in visits.iter().enumerate() {
            let next = visits.get(t + 1).map_or(usize::MAX, |visit| visit[0].0);
            chip.retain(|(rank, _)| *rank >= next);
            away.retain(|(rank, tiles)| {
                let stays = *rank >= next;
                self.spills += if stays { 0 } else { bytes(*tiles) };
                stays
            });
            for arrival in arrivals.iter().filter(|(rank, _)| *rank >= next) {
                chip.push(*arrival);
                chip.sort_unstable();
                if chip.len() > capacity {
                    let gone = chip.pop().unwrap();
                    self.out += 1;
                    self.tiles_out += gone.1;
                    self.spills += bytes(gone.1);
                    away.push(gone);
                }
            }
        }
        assert!(chip.is_empty() && away.is_empty());
    }
}

fn check(cloud: &Cloud, camera: &Camera, options: &FixedOptions) -> Recount {
    let view = View::new(cloud, camera, Profile::Inria).unwrap();
    let expected = Recount::of(cloud, &view, options);
    let stats = fixed(cloud, camera, Profile::Inria, options).stats;
    let streams = stats.streams;
    let found = Recount {
        mvoxels: stats.tasks,
        read: streams.mvoxels_read,
        scattered: stats.scattered_bytes,
        out: stats.hold.spilled,
        tiles_out: stats.hold.spilled_entries,
        spills: streams.spills,
        ..expected
    };
    assert_eq!(found, expected, "{options:?}");
    if let Some([tiles, high]) = options.schedule.group_tiles
        && tiles == high
    {
        let counted = splat_traffic(cloud, &view, options, &[16 * tiles]).unwrap();
        assert_eq!(counted[0].streams, streams);
        assert_eq!(counted[0].mvoxels, stats.tasks);
        assert_eq!(counted[0].scattered, stats.scattered_bytes);
    }
    expected
}

#[test]
fn mvoxels_and_spills_are_those_counted_anew() {
    let (cloud, camera) = small();
    let mut sum = Recount::default();
    for (rows, group_tiles, cells) in [
        (512, None, Cells::MERGED),
        (512, Some([1, 1]), Cells::MERGED),
        (300, Some([2, 2]), APART),
        (64, Some([4, 3]), Cells::MERGED),
        (
            64,
            Some([3, 3]),
            Cells {
                halvings: 1,
                merge: false,
            },
        ),
        (7, Some([2, 2]), Cells::MERGED),
        (7, None, Cells::MERGED),
        (1, Some([2, 1]), Cells::MERGED),
    ] {
        for (order, hold_records) in [
            (Order::Exact, 0),
            (Order::Exact, 10),
            (Order::Exact, 300),
            (Order::Approximate, 10),
        ] {
            let options = FixedOptions {
                schedule: ScheduleOptions {
                    rows,
                    group_tiles,
                    cells,
                    limits: None,
                    opacity: SplatOpacity::Multiplied,
                },
                order,
                hold_records,
                ..LOG
            };
            let found = check(&cloud, &camera, &options);
            // The whole frame uses all that is visible.
            let whole = group_tiles.is_none();
            assert!(!whole || found.unused + found.scattered == 0);
            let in_order = order == Order::Approximate || rows == 1;
            assert!(!in_order || found.out == 0);
            sum.unused += found.unused;
            sum.scattered += found.scattered;
            sum.out += found.out;
            sum.tiles_out += found.tiles_out;
        }
    }
    assert!(sum.unused > 0 && sum.scattered > 0, "{sum:?}");
    assert!(sum.tiles_out > sum.out, "{sum:?}");
}
