//! Bytes that the memory-centric order moves of a field in several tables, by
//! ray group: what [`FixedField`](crate::fields::FixedField) gathers of a group in
//! one batch.

use glam::DVec3;
use potamoi_formats::config::Config;
use rayon::prelude::*;

use super::Traffic;
use crate::fields::coded::{BatchCount, CodedTable};
use crate::fields::{FieldError, FixedColour, HashedColour, Stops, Table};

/// Counts, for each side of ray groups, the samples of each ray up to where it
/// stops in floating point, every MVoxel of a group loaded once.
///
/// # Errors
/// A configuration whose gathering unit does not fit the tables.
pub fn table_traffic(
    stops: &Stops<'_>,
    config: &Config,
    sides: &[u32],
) -> Result<Vec<Traffic>, FieldError> {
    let tables = coded(stops.field().tables(), config)?;
    let [width, height] = [stops.camera().width, stops.camera().height];
    let counted = sides.iter().map(|side| {
        let across = width.div_ceil(*side);
        let groups = across * height.div_ceil(*side);
        let counts = (0..groups).into_par_iter().map(|group| {
            let corner = [group % across * side, group / across * side];
            let mut batch = Batch::new(&tables);
            let mut places = vec![DVec3::ZERO; tables.len()];
            for y in corner[1]..(corner[1] + side).min(height) {
                for x in corner[0]..(corner[0] + side).min(width) {
                    stops.samples([x, y], 1, &mut places, |places| batch.sample(places));
                }
            }
            batch.done(*side)
        });
        counts.reduce(|| Traffic::of(*side, None), Traffic::and)
    });
    Ok(counted.collect())
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
    let tables = coded(field.tables(), config)?;
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
fn coded(tables: &[Table], config: &Config) -> Result<Vec<CodedTable>, FieldError> {
    let tables = tables.iter();
    tables
        .map(|t| CodedTable::new(t, &vec![0; t.channels()], config))
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
