//! Bytes that the memory-centric order moves of a field in several tables, by
//! ray group: what [`FixedField`](crate::fields::FixedField) gathers of a group in
//! one batch.

use glam::DVec3;
use potamoi_formats::config::Config;
use rayon::prelude::*;

use super::Traffic;
use crate::camera::Camera;
use crate::fields::coded::{CodedTable, Located};
use crate::fields::{Field, FieldError, samples_of};
use crate::streams::{RitReads, Streams};

/// Counts, for each side of ray groups, the samples of each ray up to where it
/// stops in floating point, every MVoxel of a group loaded once.
///
/// # Errors
/// A configuration whose gathering unit does not fit the tables, or as
/// [`crate::fields::render_float`].
pub fn table_traffic(
    field: &dyn Field,
    camera: &Camera,
    config: &Config,
    sides: &[u32],
) -> Result<Vec<Traffic>, FieldError> {
    // Which rows are read depends on no value.
    let tables = field.tables().iter();
    let tables = tables.map(|t| CodedTable::new(t, &vec![0; t.channels()], config));
    let tables: Vec<CodedTable> = tables.collect::<Result<_, _>>()?;
    let width = camera.width;
    let rays: Result<Vec<Vec<DVec3>>, FieldError> = (0..width * camera.height)
        .into_par_iter()
        .map(|i| {
            let mut own = vec![];
            samples_of(field, camera, [i % width, i / width], |at, _| own.push(at))?;
            Ok(own)
        })
        .collect();
    let rays = rays?;
    let counted = sides.iter().map(|side| {
        let across = width.div_ceil(*side);
        let groups = across * camera.height.div_ceil(*side);
        let counts = (0..groups).into_par_iter().map(|group| {
            let corner = [group % across * side, group / across * side];
            let columns = corner[0]..(corner[0] + side).min(width);
            let lines = corner[1]..(corner[1] + side).min(camera.height);
            let own = lines.flat_map(|y| columns.clone().map(move |x| (y * width + x) as usize));
            let own: Vec<&[DVec3]> = own.map(|ray| &rays[ray][..]).collect();
            let empty = Traffic::of(*side, None);
            (0..tables.len())
                .map(|number| count(field, camera, &tables, number, config, &own, *side))
                .fold(empty, Traffic::and)
        });
        counts.reduce(|| Traffic::of(*side, None), Traffic::and)
    });
    Ok(counted.collect())
}

/// One table of one group.
fn count(
    field: &dyn Field,
    camera: &Camera,
    tables: &[CodedTable],
    number: usize,
    config: &Config,
    rays: &[&[DVec3]],
    side: u32,
) -> Traffic {
    let mut places = vec![DVec3::ZERO; tables.len()];
    let mut place = |at: DVec3| {
        field.place(at, &mut places);
        places[number]
    };
    let eye = place(camera.position());
    let samples = (0..)
        .zip(rays)
        .flat_map(|(slot, ray)| ray.iter().map(move |at| (slot, *at)));
    let located: Vec<Located> = samples
        .map(|(slot, at)| Located {
            slot,
            place: place(at),
        })
        .collect();
    let table = &tables[number];
    let gathers = table.gathers(eye, &located);
    let mut found = Traffic::of(side, None);
    found.mvoxels = gathers.visits.len() as u64;
    let mut streams = Streams::default();
    for visit in &gathers.visits {
        found.entries += visit.whole + visit.split;
        streams.visit(visit, RitReads::of(config));
    }
    if gathers.row_by_row {
        found.scattered = streams.mvoxels_read;
    }
    found.streams = streams;
    found
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::panic)]
    use super::*;

    use super::super::Endless;
    use crate::fields::{FixedField, FixedOptions};
    use crate::scene::{Model, Scene};
    use crate::units::Twins;

    /// Where no ray stops, the counts are those of the renderer, equal.
    #[test]
    fn counts_are_those_of_the_renderer() {
        let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../configs/fields.toml");
        let text = std::fs::read_to_string(path).unwrap();
        let config = Config::from_toml(&text, "fields").unwrap();
        for name in ["ngp/cube.ingp", "tensorf/tiny.th"] {
            let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR"))
                .join("tests/fixtures")
                .join(name);
            let mut scene = Scene::open(path.to_str().unwrap()).unwrap();
            scene.set_size(Some(20), None).unwrap();
            let field: &dyn Field = match scene.model() {
                Model::Tensorf(field) => &**field,
                Model::Field(field) => &**field,
                _ => panic!("a field"),
            };
            let endless = Endless(field);
            for side in [8, 20] {
                let counted = table_traffic(&endless, scene.camera(), &config, &[side]).unwrap();
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
