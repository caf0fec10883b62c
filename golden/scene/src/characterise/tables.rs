//! Memory traffic of a field in several tables in the memory-centric order, by ray group and halo:
//! the batches of [`FixedField`](potamoi_fields::FixedField), counted without gathers.

use glam::DVec3;
use potamoi_formats::config::Config;
use rayon::prelude::*;

use super::Traffic;
use potamoi_base::camera::Camera;
use potamoi_fields::gather_plan::{BatchCount, CodedTable};
use potamoi_fields::{
    BatchSize, Field, FieldError, FixedColour, HashedColour, SampleBatches, Table,
};
use potamoi_march::tiling::Halo;

/// Counts the renderer's traffic for a frame whose rays stop after the given numbers of gathered
/// samples ([`FixedField::stops`](potamoi_fields::FixedField::stops)), for each side of ray
/// groups, and for both halos if a table has one.
///
/// # Errors
/// The configuration's gathering unit does not support the tables, or the number of stops is not
/// that of pixels.
pub fn table_traffic(
    field: &dyn Field,
    camera: &Camera,
    stops: &[u32],
    config: &Config,
    sides: &[u32],
) -> Result<Vec<Traffic>, FieldError> {
    sized_traffic(field, camera, stops, config, sides, None)
}

/// As [`table_traffic`], for batches of another size than the renderer's own.
///
/// # Errors
/// Those of [`table_traffic`].
pub fn sized_traffic(
    field: &dyn Field,
    camera: &Camera,
    stops: &[u32],
    config: &Config,
    sides: &[u32],
    batch: Option<BatchSize>,
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
    let batch = batch.unwrap_or_else(|| BatchSize::of(&shared));
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
        let all: Vec<Vec<[u32; 2]>> = potamoi_march::groups(size, side, None).collect();
        let counts = all.par_iter().map(|pixels| {
            let mut rays = SampleBatches::new(field, true, &sampling, camera, pixels);
            let own = pixels
                .iter()
                .map(|[x, y]| stops[(y * size[0] + x) as usize]);
            let own: Vec<u32> = own.collect();
            let mut passed = vec![0; own.len()];
            let mut places = vec![DVec3::ZERO; tables.len()];
            let mut sum = none();
            loop {
                let alive = |slot: u32| passed[slot as usize] < own[slot as usize];
                let next = rays.next(alive, batch);
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

/// Counts the traffic of the colours of Gaussians at `centres`, which are computed once a frame.
/// The result's `side` has no meaning.
///
/// # Errors
/// The configuration's gathering unit does not support the tables.
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

/// Quantised tables with arbitrary codes: the rows that are read depend on no value.
fn coded(tables: &[Table], config: &Config, halo: Halo) -> Result<Vec<CodedTable>, FieldError> {
    let tables = tables.iter();
    tables
        .map(|t| CodedTable::with_halo(t, &vec![0; t.channels()], config, halo))
        .collect()
}

/// Samples gathered together, for every table.
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

    use std::path::Path;

    use crate::{Model, Scene};
    use potamoi_fields::{FixedField, FixedOptions};
    use potamoi_reference::ReferenceUnits;

    /// Opens a built-in scene, or a file among the fixtures.
    fn open(name: &str, width: u32) -> Scene {
        let path = Path::new(env!("CARGO_MANIFEST_DIR"))
            .join("../tests/fixtures")
            .join(name);
        let file = path.to_str().filter(|_| path.exists());
        let mut scene = crate::tests::opened(file.unwrap_or(name));
        scene.set_size(Some(width), None).unwrap();
        scene
    }

    fn field(scene: &Scene) -> &dyn Field {
        match scene.model() {
            Model::Field(field) => &**field,
            _ => panic!("a field"),
        }
    }

    /// Every stream and count is the renderer's, where rays stop and where none
    /// does, for both halos, and for batches of any size.
    #[test]
    fn counts_are_those_of_the_renderer() {
        counts_are_the_renderer_s(&[
            ("tensorf/tiny.th", 16, true),
            ("cairn:tensorf", 16, true),
            ("cairn:ngp", 16, true),
            ("moons:efficientnerf", 20, false),
        ]);
    }

    #[test]
    #[ignore = "exhaustive; run with make test-full"]
    fn counts_are_those_of_the_renderer_in_other_scenes() {
        counts_are_the_renderer_s(&[
            ("ngp/cube.ingp", 20, true),
            ("cairn:tensorf", 32, true),
            ("moons:tensorf", 24, true),
            ("cairn:ngp", 32, true),
            ("moons:ngp", 24, true),
            ("cairn:efficientnerf", 32, false),
            ("cairn:ngp-mvoxel", 24, true),
        ]);
    }

    /// Of scenes, their width, and whether their tables have halos.
    fn counts_are_the_renderer_s(scenes: &[(&str, u32, bool)]) {
        let config = Config::preset("fields").unwrap();
        for &(name, width, has_halo) in scenes {
            let scene = open(name, width);
            let (field, camera) = (field(&scene), scene.camera());
            let halos = [Halo::Shared, Halo::Split];
            let made = halos.map(|halo| FixedField::with_halo(field, &config, halo).unwrap());
            let known = made[0]
                .stops(
                    camera,
                    &FixedOptions::default(),
                    &mut ReferenceUnits::new(&config),
                )
                .unwrap();
            let small = BatchSize {
                samples: 3,
                entries: 5000,
            };
            let mut split = 0;
            for (side, terminate, size) in [
                (8, true, None),
                (width, true, None),
                (width, true, Some(small)),
                (width, false, None),
            ] {
                let stops = match terminate {
                    true => known.clone(),
                    false => vec![u32::MAX; known.len()],
                };
                let counted = sized_traffic(field, camera, &stops, &config, &[side], size);
                let counted = counted.unwrap();
                assert_eq!(counted.len(), 1 + usize::from(has_halo), "{name}");
                for (found, (halo, made)) in counted.iter().zip(halos.iter().zip(&made)) {
                    let options = FixedOptions {
                        terminate,
                        group_side: Some(side),
                        batch: size,
                        ..FixedOptions::default()
                    };
                    let mut twins = ReferenceUnits::new(&config);
                    let frame = made.render(camera, &options, &mut twins).unwrap();
                    let what = format!("{name}, {side}, {terminate}, {halo:?}");
                    assert_eq!(frame.stops, stops, "{what}");
                    let stats = frame.stats;
                    assert_eq!(found.halo, has_halo.then_some(*halo), "{what}");
                    assert_eq!(found.streams, stats.streams, "{what}");
                    assert_eq!(found.mvoxels, stats.tasks, "{what}");
                    assert_eq!(found.entries, stats.entries, "{what}");
                    assert_eq!(found.scattered, stats.scattered_bytes, "{what}");
                    // Solid enough for rays to stop in.
                    let solid = terminate && name.contains(':');
                    assert!(stats.stopped > 20 || !solid, "{what}: {}", stats.stopped);
                    assert!(stats.stopped == 0 || terminate, "{what}");
                    assert!(stats.entries > 1000);
                    if *halo == Halo::Split {
                        split += stats.streams.partial_sums;
                    }
                }
            }
            // The tables of the small files are one MVoxel each.
            let cut = has_halo && name.contains(':');
            assert_eq!(split > 0, cut, "{name}");
        }
    }

    /// The renderer goes past stops by a bounded share, whatever the ray group.
    #[test]
    fn batches_go_past_stops_by_little() {
        let config = Config::preset("fields").unwrap();
        for name in ["cairn:tensorf", "cairn:ngp", "cairn:efficientnerf"] {
            let scene = open(name, 48);
            let (field, camera) = (field(&scene), scene.camera());
            let made = FixedField::new(field, &config).unwrap();
            let stops = made
                .stops(
                    camera,
                    &FixedOptions::default(),
                    &mut ReferenceUnits::new(&config),
                )
                .unwrap();
            let sides = [8, 16, 48];
            let found = table_traffic(field, camera, &stops, &config, &sides).unwrap();
            let own: Vec<&Traffic> = found
                .iter()
                .filter(|t| t.halo != Some(Halo::Split))
                .collect();
            let one = BatchSize {
                samples: 1,
                entries: usize::MAX,
            };
            let least = sized_traffic(field, camera, &stops, &config, &[48], Some(one)).unwrap();
            let over = own
                .iter()
                .map(|t| t.entries as f64 / least[0].entries as f64);
            let over: Vec<f64> = over.collect();
            println!("{name}: {over:?}");
            assert!(over.iter().all(|o| (1.0..1.45).contains(o)), "{over:?}");
            // The larger the group, the fewer bytes.
            assert!(own.is_sorted_by(|a, b| a.streams.total() >= b.streams.total()));
        }
    }

    #[test]
    fn stops_of_another_frame_are_refused() {
        let scene = open("cairn:efficientnerf", 8);
        let (field, camera) = (field(&scene), scene.camera());
        let refused = table_traffic(
            field,
            camera,
            &[1; 3],
            &Config::preset("fields").unwrap(),
            &[8],
        );
        let said = refused.unwrap_err().to_string();
        assert!(said.contains("stops") && said.contains("8 x"), "{said}");
    }
}
