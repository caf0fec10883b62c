//! Memory traffic of the memory-centric order, by ray group and halo.
//!
//! With a *shared* halo, an MVoxel of `e` vertices an edge holds `e - 1` cells an edge; vertices
//! on shared faces are stored twice, and a sample has one entry. With a *split* halo it holds `e`
//! cells; nothing is stored twice, a sample whose vertices lie in several MVoxels has an entry in
//! each, and partial sums are added. The count is that of a renderer whose rays stop where they
//! are known to: an MVoxel is gathered to its end.

use schemars::JsonSchema;
use serde::Serialize;

use potamoi_base::camera::Camera;
use potamoi_fields::{CodedVolume, FieldError, volume};
use potamoi_march::streams::Streams;
use potamoi_march::tiling::Halo;

/// Traffic of a frame for one size of ray groups.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
pub struct Traffic {
    /// Side of a ray group in pixels.
    pub side: u32,
    /// The kind of halo; `None` for splats.
    pub halo: Option<Halo>,
    /// MVoxels loaded, over all ray groups.
    pub mvoxels: u64,
    /// Entries of the ray index table.
    pub entries: u64,
    /// Bytes by stream.
    pub streams: Streams,
    /// MVoxel bytes that are fetched row by row: of tables that do not stream, and of splat
    /// MVoxels of which a ray group uses little.
    pub scattered: u64,
}

impl Traffic {
    /// No traffic.
    pub(super) fn of(side: u32, halo: Option<Halo>) -> Self {
        Self {
            side,
            halo,
            mvoxels: 0,
            entries: 0,
            streams: Streams::default(),
            scattered: 0,
        }
    }

    /// The sum of both.
    pub(crate) fn and(self, other: Self) -> Self {
        Self {
            mvoxels: self.mvoxels + other.mvoxels,
            entries: self.entries + other.entries,
            streams: self.streams + other.streams,
            scattered: self.scattered + other.scattered,
            ..self
        }
    }
}

/// Counts the renderer's traffic for a frame of one volume whose rays stop after the given numbers
/// of gathered samples ([`FixedFrame::stops`](potamoi_march::FixedFrame::stops)), for each side of
/// ray groups and both halos.
///
/// # Errors
/// Those of [`potamoi_fields::volume::traffic`].
pub fn traffic(
    volume: &CodedVolume,
    camera: &Camera,
    stops: &[u32],
    sides: &[u32],
) -> Result<Vec<Traffic>, FieldError> {
    let halos = [Halo::Shared, Halo::Split];
    let cut = halos.map(|halo| volume.with_halo(halo));
    let mut found = vec![];
    for side in sides.iter().copied() {
        for (halo, volume) in halos.into_iter().zip(&cut) {
            let stats = volume::traffic(volume, camera, side, stops)?;
            found.push(Traffic {
                mvoxels: stats.tasks,
                entries: stats.entries,
                streams: stats.streams,
                ..Traffic::of(side, Some(halo))
            });
        }
    }
    Ok(found)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::panic)]
    use super::*;
    use potamoi_formats::config::Config;

    use crate::{Model, Scene};
    use potamoi_fields::{FixedField, FixedOptions};
    use potamoi_reference::ReferenceUnits;

    /// Every stream and count is the renderer's, with both halos, where rays stop
    /// and where none does; where the table is read several times, too.
    #[test]
    fn counts_are_those_of_the_renderer() {
        let mut scene = crate::tests::opened("lantern");
        scene.set_size(Some(40), Some(36)).unwrap();
        let mut stopped = 0;
        for (text, segments) in [
            ("", 1),
            ("[gu]\nbanks = 4\nsegments = 4\n[rit]\nentries = 16", 4),
        ] {
            let config = Config::from_toml(text, "test").unwrap();
            stopped += same_as_rendered(&scene, &config, segments);
        }
        assert!(stopped > 100, "{stopped}");
    }

    /// The same of a DirectVoxGO model, whose samples are cut in cells of a mask.
    #[test]
    fn counts_of_voxels_with_a_perceptron_are_those_of_the_renderer() {
        let mut scene = crate::tests::opened("cairn:dvgo");
        scene.set_size(Some(32), None).unwrap();
        let config = Config::preset("fields").unwrap();
        assert!(same_as_rendered(&scene, &config, 1) > 100);
    }

    /// Compares, and says how many rays stopped.
    fn same_as_rendered(scene: &Scene, config: &Config, segments: usize) -> u64 {
        let (Model::Field(field), camera) = (scene.model(), scene.camera()) else {
            panic!("a field")
        };
        let halos = [Halo::Shared, Halo::Split];
        let made = halos.map(|halo| FixedField::with_halo(&**field, config, halo).unwrap());
        let volume = made[0].volume().unwrap();
        let all = FixedOptions::default();
        let known = made[0]
            .stops(camera, &all, &mut ReferenceUnits::new(config))
            .unwrap();
        let mut stopped = 0;
        for (side, terminate) in [(8, true), (40, true), (16, false)] {
            let stops = match terminate {
                true => known.clone(),
                false => vec![u32::MAX; known.len()],
            };
            let counted = traffic(volume, camera, &stops, &[side]).unwrap();
            for ((halo, made), found) in halos.into_iter().zip(&made).zip(&counted) {
                let options = FixedOptions {
                    group_side: Some(side),
                    terminate,
                    ..all
                };
                let mut units = ReferenceUnits::new(config);
                let frame = made.render(camera, &options, &mut units).unwrap();
                assert_eq!(frame.stops, stops, "{side} {halo:?}");
                let stats = &frame.stats;
                assert_eq!((found.side, found.halo), (side, Some(halo)));
                assert_eq!((found.mvoxels, found.entries), (stats.tasks, stats.entries));
                assert_eq!(found.streams, stats.streams, "{side} {halo:?} {terminate}");
                let s = stats.streams;
                let sum = s.mvoxels_read + s.rit_written + s.rit_read + s.features;
                assert_eq!(found.streams.total(), sum + s.partial_sums);
                // Halves of 16 entries are exceeded, but not by every MVoxel.
                assert_eq!(s.rit_read > s.rit_written, segments > 1);
                assert!(s.rit_read < 4 * s.rit_written);
                assert_eq!(s.partial_sums > 0, halo == Halo::Split);
                stopped += stats.stopped;
            }
            // Splitting asks for more.
            let [shared, split] = [counted[0], counted[1]];
            let share = split.entries as f64 / shared.entries as f64;
            assert!((1.2..1.9).contains(&share), "{share}");
        }
        stopped
    }
}
