//! Bytes that the memory-centric order moves of a field in several tables, by
//! ray group and halo: the batches of [`FixedField`](crate::fields::FixedField),
//! counted without gathers.

use glam::DVec3;
use potamoi_formats::config::Config;
use rayon::prelude::*;

use super::Traffic;
use crate::camera::Camera;
use crate::fields::coded::{BatchCount, CodedTable};
use crate::fields::{
    BatchSize, Field, FieldError, FixedColour, HashedColour, RayGroup, Table, groups,
};
use crate::tiling::Halo;

/// Counts what the renderer moves of a frame whose rays stop behind so many
/// gathered samples ([`FixedField::stops`](crate::fields::FixedField::stops)), for
/// each side of ray groups, and for both halos where a table has one.
///
/// # Errors
/// A configuration whose gathering unit does not fit the tables, or stops that
/// are not one a pixel.
pub fn table_traffic(
    field: &dyn Field,
    camera: &Camera,
    stops: &[u32],
    config: &Config,
    sides: &[u32],
) -> Result<Vec<Traffic>, FieldError> {
    sized_traffic(field, camera, stops, config, sides, BatchSize::of_group)
}

/// The same with other batches than the renderer's, for ray groups of so many
/// rays.
///
/// # Errors
/// As [`table_traffic`].
pub fn sized_traffic(
    field: &dyn Field,
    camera: &Camera,
    stops: &[u32],
    config: &Config,
    sides: &[u32],
    batch: impl Fn(usize) -> BatchSize + Sync,
) -> Result<Vec<Traffic>, FieldError> {
    let size = [camera.width, camera.height];
    if stops.len() as u64 != u64::from(size[0]) * u64::from(size[1]) {
        return Err(FieldError::Part {
            part: "stops",
            found: stops.len().to_string(),
            expected: format!("one for each of {} x {} pixels", size[0], size[1]),
        });
    }
    let tables = field.tables();
    let shared = coded(tables, config, Halo::Shared)?;
    let ways = if shared.iter().any(CodedTable::has_halo) {
        let split = coded(tables, config, Halo::Split)?;
        vec![(Some(Halo::Shared), shared), (Some(Halo::Split), split)]
    } else {
        vec![(None, shared)]
    };
    let sampling = field.sampling();
    let mut found = vec![];
    for side in sides.iter().copied() {
        let none = || -> Vec<Traffic> {
            let all = ways.iter().map(|(halo, _)| Traffic::of(side, *halo));
            all.collect()
        };
        let all: Vec<Vec<[u32; 2]>> = groups(size, side).collect();
        let counts = all.par_iter().map(|pixels| {
            let mut rays = RayGroup::new(field, &sampling, camera, pixels);
            let own = pixels.iter().map(|[x, y]| stops[(y * size[0] + x) as usize]);
            let own: Vec<u32> = own.collect();
            let mut passed = vec![0; own.len()];
            let mut places = vec![DVec3::ZERO; tables.len()];
            let mut sum = none();
            loop {
                let alive = |slot: u32| passed[slot as usize] < own[slot as usize];
                let next = rays.next(alive, batch(pixels.len()));
                if next.at.is_empty() {
                    break sum;
                }
                for span in &next.spans {
                    passed[span.ray as usize] += span.len;
                }
                let counts = ways.iter().map(|(_, tables)| Batch::new(tables));
                let mut counts: Vec<Batch<'_>> = counts.collect();
                for at in &next.at {
                    field.place(*at, &mut places);
                    for count in &mut counts {
                        count.sample(&places);
                    }
                }
                for (sum, count) in sum.iter_mut().zip(counts) {
                    *sum = sum.and(count.done(side));
                }
            }
        });
        let both = |a: Vec<Traffic>, b: Vec<Traffic>| {
            let pairs = a.into_iter().zip(b);
            pairs.map(|(a, b)| a.and(b)).collect()
        };
        found.extend(counts.reduce(none, both));
    }
    Ok(found)
}

/// Counts what the colours of Gaussians at `centres` move, which are asked for
/// once a frame. Its side means nothing.
///
/// # Errors
/// A configuration whose gathering unit does not fit the tables.
pub fn colour_traffic(
    field: &HashedColour,
    centres: &[[f32; 3]],
    config: &Config,
) -> Result<Traffic, FieldError> {
    let tables = coded(field.tables(), config, Halo::Shared)?;
    let batches = centres.par_chunks(FixedColour::BATCH).map(|centres| {
        let mut batch = Batch::new(&tables);
        let mut places = vec![DVec3::ZERO; tables.len()];
        for centre in centres {
            field.index(DVec3::from(centre.map(f64::from)), &mut places);
            batch.sample(&places);
        }
        batch.done(0)
    });
    Ok(batches.reduce(|| Traffic::of(0, None), Traffic::and))
}

/// Tables whose codes say nothing: which rows are read depends on no value.
fn coded(tables: &[Table], config: &Config, halo: Halo) -> Result<Vec<CodedTable>, FieldError> {
    let tables = tables.iter();
    tables
        .map(|t| CodedTable::with_halo(t, &vec![0; t.channels()], config, halo))
        .collect()
}

/// Samples that are gathered together, of every table.
struct Batch<'a>(Vec<BatchCount<'a>>);

impl<'a> Batch<'a> {
    fn new(tables: &'a [CodedTable]) -> Self {
        Self(tables.iter().map(BatchCount::new).collect())
    }

    fn sample(&mut self, places: &[DVec3]) {
        for (count, place) in self.0.iter_mut().zip(places) {
            count.sample(*place);
        }
    }

    fn done(self, side: u32) -> Traffic {
        let mut found = Traffic::of(side, None);
        for own in self.0.into_iter().map(BatchCount::done) {
            found.mvoxels += own.tasks;
            found.entries += own.entries;
            found.streams = found.streams + own.streams;
            found.scattered += own.scattered;
        }
        found
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::panic)]
    use super::*;

    use super::super::Endless;
    use crate::fields::{Field, FixedField, FixedOptions};
    use crate::scene::{Model, Scene};
    use crate::units::Twins;

    /// Where no ray stops, the counts are those of the renderer, equal.
    #[test]
    fn counts_are_those_of_the_renderer() {
        let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../configs/fields.toml");
        let text = std::fs::read_to_string(path).unwrap();
        let config = Config::from_toml(&text, "fields").unwrap();
        for name in [
            "ngp/cube.ingp",
            "tensorf/tiny.th",
            "cairn:efficientnerf",
            "cairn:ngp-mvoxel",
        ] {
            let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR"))
                .join("tests/fixtures")
                .join(name);
            let file = path.to_str().filter(|_| path.exists());
            let mut scene = Scene::open(file.unwrap_or(name)).unwrap();
            scene.set_size(Some(20), None).unwrap();
            let field: &dyn Field = match scene.model() {
                Model::Tensorf(field) => &**field,
                Model::Field(field) => &**field,
                _ => panic!("a field"),
            };
            let endless = Endless(field);
            for side in [8, 20] {
                let stops = Stops::find(&endless, scene.camera()).unwrap();
                let counted = table_traffic(&stops, &config, &[side]).unwrap();
                let options = FixedOptions {
                    terminate: false,
                    group_side: Some(side),
                    batch_entries: usize::MAX,
                    ..FixedOptions::default()
                };
                let made = FixedField::new(field, &config).unwrap();
                let mut twins = Twins::new(&config);
                let stats = made
                    .render(scene.camera(), &options, &mut twins)
                    .unwrap()
                    .stats;
                assert_eq!(counted[0].streams, stats.streams, "{name}, {side}");
                assert_eq!(counted[0].mvoxels, stats.tasks);
                assert_eq!(counted[0].entries, stats.entries);
                assert_eq!(counted[0].scattered, stats.scattered_bytes);
                assert!(stats.entries > 1000);
            }
        }
    }
}
