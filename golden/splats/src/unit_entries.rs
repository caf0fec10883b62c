//! The records of a group as the splat unit takes them.

use potamoi_formats::config::SplatOpacity;
use potamoi_formats::record::{RECORD_CHANNELS, SplatRecord};
use potamoi_reference::splat_unit::{SplatEntry, SplatSettings, TILE};

use crate::composite::Limits;
use crate::profile::Rules;
use crate::reorder_buffer::Hold;
use crate::schedule::Group;
use crate::view::View;

/// Settings of the splat unit for a set of rules and for records that hold an opacity in a form.
#[must_use]
pub fn unit_settings(rules: &Rules, opacity: SplatOpacity) -> SplatSettings {
    SplatSettings {
        thresholds: Limits::new(rules).thresholds(),
        is_centred: rules.pixel_centre > 0.0,
        opacity,
    }
}

/// Calls `each` for every record in every tile of a group, those of a tile in depth order. A tile's number
/// in the unit is its place in the group.
pub fn unit_entries(view: &View, group: &Group, each: &mut dyn FnMut(&SplatEntry)) {
    let mut hold = Hold::new(usize::MAX);
    for (t, task) in group.tasks.iter().enumerate() {
        let rows = task.rows.as_chunks::<RECORD_CHANNELS>().0;
        for entry in &task.entries {
            let record = SplatRecord::from_channels(&rows[usize::from(entry.rows[0])]);
            hold.arrive((entry.slot as u16, record));
        }
        let next = group.mvoxels.get(t + 1).map(|m| m.min_rank);
        hold.retire(next, |(slot, record)| {
            let place = view.tile_pixels(group.tiles[usize::from(slot)] as usize);
            each(&entry_of(slot, place, record));
        });
    }
}

/// A record in the tile of a slot. `place` is the tile's first pixel, and its columns and rows in the
/// picture.
pub(crate) fn entry_of(slot: u16, [first, size]: [[u32; 2]; 2], record: SplatRecord) -> SplatEntry {
    SplatEntry {
        slot,
        tile: first.map(|at| (at / TILE) as u16),
        last: size.map(|pixels| pixels as u8 - 1),
        record,
    }
}
