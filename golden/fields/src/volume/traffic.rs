//! Memory traffic of ray groups, counted without gathering if it is known where rays stop.

use super::CodedVolume;
use super::schedule::{Group, Schedule};
use super::split_halo::ready;
use crate::gather_plan::Touched;
use potamoi_base::camera::Camera;
use potamoi_march::{FixedStats, MarchError, groups};

/// Counts and traffic of [`crate::FixedField::render`] with ray groups of `side` pixels, for a
/// frame whose rays stop after the given numbers of gathered samples
/// ([`potamoi_march::FixedFrame::stops`]).
///
/// # Errors
/// The camera or the step is out of range, or the number of stops is not that of pixels.
pub fn traffic(
    volume: &CodedVolume,
    camera: &Camera,
    side: u32,
    stops: &[u32],
) -> Result<FixedStats, MarchError> {
    let schedule = Schedule::new(volume, camera, true)?;
    let size = [camera.width, camera.height];
    if stops.len() as u64 != u64::from(size[0]) * u64::from(size[1]) {
        return Err(MarchError::Option {
            field: "stops",
            value: stops.len().to_string(),
            expected: "one a pixel",
        });
    }
    let mut stats = FixedStats::default();
    for pixels in groups(size, side, None) {
        let group = schedule.group(&pixels);
        stats.groups += 1;
        stats.rays += group.rays.len() as u64;
        stats.samples += group.samples();
        let own = pixels.iter();
        let own = own.map(|[x, y]| stops[(y * size[0] + x) as usize]);
        count(&schedule, &group, &own.collect::<Vec<_>>(), &mut stats);
    }
    Ok(stats)
}

/// Counts the MVoxels of a group: for each ray all those up to and including the distance at which
/// it stops.
fn count(schedule: &Schedule<'_>, group: &Group, stops: &[u32], stats: &mut FixedStats) {
    let last: Vec<u32> = ready(schedule, group)
        .iter()
        .zip(stops)
        .map(|(list, stop)| {
            let done = list.iter().find(|ready| ready.samples >= *stop);
            done.map_or(u32::MAX, |ready| ready.distance)
        })
        .collect();
    let (mvoxels, tiling) = (schedule.mvoxels, schedule.mvoxels.tiling());
    for same in group.crossings.chunk_by(|a, b| a.mvoxel == b.mvoxel) {
        let mut read: Option<Touched> = None;
        for crossing in same.iter().filter(|c| c.distance <= last[c.ray as usize]) {
            schedule.samples(group, crossing, |_, place, holder| {
                let own = Touched::of(tiling, place, holder);
                read = Some(read.map_or(own, |all| all.and(own)));
            });
        }
        if let Some(read) = read {
            let visit = read.visit(mvoxels.shape().vertices, mvoxels.channels());
            stats.count([&visit], mvoxels.unit_streams());
        }
    }
}
