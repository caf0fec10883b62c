//! Memory traffic of splats in the memory-centric order, by ray group.

use potamoi_formats::record::{RECORD_CHANNELS, SplatRecord};
use rayon::prelude::*;

use super::Traffic;
use potamoi_gaussians::Cloud;
use potamoi_march::streams::Visit;
use potamoi_splats::{
    FixedOptions, Group, Hold, HoldStats, Order, RenderError, Schedule, ScheduleOptions, TILE, View,
};

/// Counts a frame for each side of ray groups, rounded up to whole tiles. The GPU writes one
/// record a visible Gaussian. Every ray group loads the MVoxels that it needs, by stream or record
/// by record ([`Load`](potamoi_splats::Load)), with one entry a (tile, Gaussian). Entries are
/// gathered even if all pixels of their tile have stopped.
///
/// # Errors
/// Those of [`potamoi_splats::render_fixed`].
pub fn splat_traffic(
    cloud: &Cloud,
    view: &View,
    options: &FixedOptions,
    sides: &[u32],
) -> Result<Vec<Traffic>, RenderError> {
    let of = |side: u32| {
        let tiles = side.div_ceil(TILE);
        let schedule = ScheduleOptions {
            group_tiles: Some([tiles; 2]),
            ..options.schedule.clone()
        };
        let schedule = Schedule::new(cloud, view, &schedule)?;
        let mut found = Traffic::of(tiles * TILE, None);
        let mut held = HoldStats::default();
        for group in (0..schedule.groups()).filter_map(|g| schedule.group(g)) {
            for task in &group.tasks {
                found.mvoxels += 1;
                found.entries += task.entries.len() as u64;
                found.streams.visit(&Visit::of(task), options.unit_streams);
            }
            found.scattered += group.scattered_bytes();
            if options.order == Order::Exact {
                held = held.and(held_back(&group, options.hold_records));
            }
        }
        found.streams.records(view.splats().len() as u64);
        found.streams.spills(held.spilled, held.spilled_entries);
        Ok(found)
    };
    sides.par_iter().map(|side| of(*side)).collect()
}

/// Reorder-buffer statistics of a group, with room for `capacity` records on chip.
fn held_back(group: &Group, capacity: usize) -> HoldStats {
    let mut hold = Hold::new(capacity);
    for (t, task) in group.tasks.iter().enumerate() {
        let rows = task.rows.as_chunks::<RECORD_CHANNELS>().0;
        for entry in &task.entries {
            let record = SplatRecord::from_channels(&rows[usize::from(entry.rows[0])]);
            hold.arrive((entry.slot as u16, record));
        }
        let next = group.mvoxels.get(t + 1).map(|m| m.min_rank);
        hold.retire(next, |_| ());
    }
    hold.stats()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::panic)]
    use potamoi_formats::config::Config;

    use super::*;
    use crate::Model;
    use potamoi_march::streams::UnitStreams;
    use potamoi_reference::ReferenceUnits;
    use potamoi_splats::render_fixed;

    /// Stream for stream and in total what the renderer counts, which holds few
    /// records on chip and reads the table more than once. MVoxels and spills are
    /// counted anew in `tests/splats_fixed/recount.rs`.
    #[test]
    fn counts_are_those_of_the_renderer() {
        let config = Config::from_toml("[gu]\nbanks = 8\nsegments = 2\n[rit]\nentries = 8", "test");
        let config = config.unwrap();
        let mut scene = crate::tests::opened("garden");
        scene.set_size(Some(150), Some(90)).unwrap();
        let Model::Splats(cloud) = scene.model() else {
            panic!("the garden is splats")
        };
        let camera = scene.camera();
        let profile = scene.profile();
        let view = View::new(cloud, camera, profile).unwrap();
        let mut again = 0;
        for order in [Order::Exact, Order::Approximate] {
            let mut options = FixedOptions {
                order,
                hold_records: 20,
                unit_streams: UnitStreams::of(&config),
                ..FixedOptions::default()
            };
            let sides = [16, 60, 150];
            let counted = splat_traffic(cloud, &view, &options, &sides).unwrap();
            for (side, found) in sides.into_iter().zip(&counted) {
                let tiles = side.div_ceil(TILE);
                options.schedule.group_tiles = Some([tiles; 2]);
                let mut units = ReferenceUnits::new(&config);
                let frame = render_fixed(cloud, camera, profile, &options, &mut units).unwrap();
                let stats = &frame.stats;
                assert_eq!((found.mvoxels, found.entries), (stats.tasks, stats.gathers));
                assert_eq!(found.streams, stats.streams, "{side}");
                assert_eq!(found.streams.total(), stats.streams.total());
                assert_eq!(found.scattered, stats.scattered_bytes);
                let entries = (0..view.splats().len()).map(|rank| view.tiles_of(rank).len());
                let entries = entries.sum::<usize>() as u64;
                let s = found.streams;
                assert_eq!(s.records_written, 32 * view.splats().len() as u64);
                assert_eq!((s.rit_written, s.features), (4 * entries, 32 * entries));
                assert!((s.rit_written..=2 * s.rit_written).contains(&s.rit_read));
                again += u64::from(s.rit_read > s.rit_written);
                assert_eq!(s.spills > 0, order == Order::Exact, "{s:?}");
                assert_eq!(s.partial_sums, 0);
            }
        }
        assert!(again >= 2, "no MVoxel exceeded both halves");
    }
}
