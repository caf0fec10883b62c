//! Memory traffic of ray groups, counted without gathering if it is known where rays stop.

use potamoi_formats::rit::Vertices;

use super::fixed::{FixedOptions, Volume, check};
use super::schedule::{Group, Schedule};
use crate::voxels::split_halo::ready;
use potamoi_base::camera::Camera;
use potamoi_march::FixedStats;
use potamoi_march::MarchError;
use potamoi_march::streams::Visit;

/// Counts and traffic of [`super::render_volume`] with the same options, for a frame whose rays
/// stop after the given numbers of gathered samples ([`potamoi_march::FixedFrame::stops`]).
///
/// # Errors
/// Those of [`super::render_volume`], or the number of stops is not that of pixels.
pub fn traffic(
    volume: &Volume<'_>,
    camera: &Camera,
    options: &FixedOptions,
    stops: &[u32],
) -> Result<FixedStats, MarchError> {
    let rays = check(&volume.placement, volume.mvoxels, camera, options)?;
    let [width, height] = rays.size();
    if stops.len() as u64 != u64::from(width) * u64::from(height) {
        return Err(MarchError::Option {
            field: "stops",
            value: stops.len().to_string(),
            expected: "one a pixel",
        });
    }
    let schedule = Schedule::new(volume.mvoxels, rays, options.group_side, options.skip)?;
    let mut stats = FixedStats::default();
    for pixels in schedule.groups() {
        let group = schedule.group(&pixels);
        stats.groups += 1;
        stats.rays += group.rays.len() as u64;
        stats.samples += group.samples();
        let own = pixels.iter();
        let own = own.map(|[x, y]| stops[(y * width + x) as usize]);
        count(&schedule, &group, &own.collect::<Vec<_>>(), &mut stats);
    }
    Ok(stats)
}

/// Counts the MVoxels of a group: for each ray all those up to and including the distance at which
/// it stops.
fn count(schedule: &Schedule<'_>, group: &Group, stops: &[u32], stats: &mut FixedStats) {
    let (mvoxels, tiling) = (schedule.mvoxels, schedule.mvoxels.tiling());
    let last: Vec<u32> = ready(schedule, group)
        .iter()
        .zip(stops)
        .map(|(list, stop)| {
            let done = list.iter().find(|ready| ready.samples >= *stop);
            done.map_or(u32::MAX, |ready| ready.distance)
        })
        .collect();
    for same in group.crossings.chunk_by(|a, b| a.mvoxel == b.mvoxel) {
        let mut visit = Visit {
            vertices: Vertices::Eight,
            channels: mvoxels.channels(),
            rows: 0,
            whole: 0,
            split: 0,
        };
        for crossing in same.iter().filter(|c| c.distance <= last[c.ray as usize]) {
            let ray = &group.rays[crossing.ray as usize];
            for k in crossing.first..crossing.end {
                let Some(place) = schedule.place(ray, k) else {
                    continue;
                };
                let mut holders = tiling.holders(&place);
                let Some(holder) = holders.find(|h| h.mvoxel == crossing.mvoxel as usize) else {
                    continue;
                };
                visit.rows = visit
                    .rows
                    .max(u64::from(tiling.last_row(&place, holder)) + 1);
                if tiling.straddles(&place) == 0 {
                    visit.whole += 1;
                } else {
                    visit.split += 1;
                }
            }
        }
        if visit.rows > 0 {
            stats.count([&visit], mvoxels.unit_streams());
        }
    }
}
