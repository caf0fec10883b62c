//! The level from which on a grid hashed by MVoxel moves more bytes MVoxel by MVoxel than row by
//! row: `hash_levels [SCENE] [SIDE] [GROUP]...` counts the rows that the base configuration of
//! Instant-NGP (8 levels from 16 to 2048 vertices, 2^19 rows a level) loads for a frame of an
//! analytic scene at SIDE x SIDE, in ray groups of GROUP pixels, each gathered at once. Samples
//! are those of the scene's `ngp` model, up to where rays stop.

use std::path::Path;

use potamoi_fields::algorithms::ngp::grid::GridShape;
use potamoi_fields::gather_plan::{BlockTable, CodedTable, Located, Order};
use potamoi_fields::{HashUnit, RayLengths, Table};
use potamoi_formats::config::Config;
use potamoi_scene::{Model, Scene};
use rayon::prelude::*;

const SHAPE: GridShape = GridShape {
    levels: 8,
    features: 4,
    log2_entries: 19,
    base: 16,
    growth: 2.0,
};
/// DRAM energy of a random byte relative to that of a streamed byte: 25 to 8.3 (paper, Sec.
/// "Experimental Setup").
const RANDOM: f64 = 25.0 / 8.3;

/// A level as blocks, without values.
fn blocks(level: u32, config: &Config) -> Result<CodedTable, Box<dyn std::error::Error>> {
    let side = SHAPE.level(level).resolution as usize + 1;
    let rows = 1 << SHAPE.log2_entries;
    let channels = SHAPE.features as usize;
    let values = vec![0.0; rows * channels];
    let table = Table::hashed_by(HashUnit::MVoxel, [side; 3], rows, channels, values)?;
    Ok(CodedTable::new(&table, &vec![0; channels], config)?)
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut args = std::env::args().skip(1);
    let name = args.next().unwrap_or_else(|| "cairn".to_owned());
    let side: u32 = args.next().map_or(Ok(400), |text| text.parse())?;
    let mut groups: Vec<u32> = args.map(|text| text.parse()).collect::<Result<_, _>>()?;
    if groups.is_empty() {
        groups = vec![16, 64, 221];
    }
    if !(8..=2048).contains(&side) || groups.contains(&0) {
        return Err("expected 8 to 2048 pixels a side, and groups of 1 or more".into());
    }
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"));
    let config = Config::read(&folder.join("../../configs/fields.toml"))?;
    let mut scene = Scene::open(&format!("{name}:ngp"))?;
    scene.set_size(Some(side), Some(side))?;
    let Model::Field(field) = scene.model() else {
        return Err("expected an analytic scene".into());
    };
    let camera = scene.camera();
    // From the model's coarsest level, which is that of the base configuration.
    let within = |places: &[glam::DVec3]| (places[0] - 0.5) / SHAPE.level(0).scale;
    let mut places = vec![glam::DVec3::ZERO; field.tables().len()];
    field.place(camera.position(), &mut places);
    let stops = RayLengths::find(&**field, camera)?;
    let rays = (0..side * side).into_par_iter().map(|i| {
        let mut places = vec![glam::DVec3::ZERO; field.tables().len()];
        let mut own = vec![];
        stops.samples([i % side, i / side], 1, &mut places, |places| {
            own.push(within(places));
        });
        own
    });
    let rays: Vec<Vec<glam::DVec3>> = rays.collect();
    let samples: usize = rays.iter().map(Vec::len).sum();
    println!("{name}, {side} x {side}: {samples} samples");
    let tables = (0..SHAPE.levels).map(|level| blocks(level, &config));
    let tables: Vec<CodedTable> = tables.collect::<Result<_, _>>()?;
    for group in groups {
        println!("\nray groups of {group} x {group}");
        println!("level  vertices  samples an MVoxel  MB streamed  MB row by row  ratio");
        let mut first = [None; 2];
        for (level, table) in (0..SHAPE.levels).zip(&tables) {
            let Order::Blocks(table) = table.order() else {
                return Err("expected a table of blocks".into());
            };
            let found = count(table, level, group, side, &rays, within(&places), &config);
            let [mvoxels, streamed, single] = found.map(|v| v as f64);
            let ratio = streamed / single;
            for (first, limit) in first.iter_mut().zip([1.0, RANDOM]) {
                *first = match *first {
                    None if ratio > limit => Some(level + 1),
                    Some(_) if ratio <= limit => None,
                    same => same,
                };
            }
            let bytes = 2e-6 * f64::from(SHAPE.features);
            println!(
                "{:5}  {:8}  {:17.1}  {:11.2}  {:13.2}  {ratio:5.2}",
                level + 1,
                SHAPE.level(level).resolution,
                samples as f64 / mvoxels,
                streamed * bytes,
                single * bytes,
            );
        }
        let said = first.map(|f| f.map_or("none".to_owned(), |f| f.to_string()));
        println!(
            "reverts from level {} of 8 by bytes, {} by DRAM energy",
            said[0], said[1]
        );
    }
    Ok(())
}

/// Visited MVoxels, rows that they load, and rows fetched row by row.
fn count(
    table: &BlockTable,
    level: u32,
    group: u32,
    side: u32,
    rays: &[Vec<glam::DVec3>],
    eye: glam::DVec3,
    config: &Config,
) -> [u64; 3] {
    let scale = SHAPE.level(level).scale;
    let across = side.div_ceil(group);
    let counts = (0..across * across).into_par_iter().map(|number| {
        let corner = [number % across * group, number / across * group];
        let columns = corner[0]..(corner[0] + group).min(side);
        let lines = corner[1]..(corner[1] + group).min(side);
        let pixels = lines.flat_map(|y| columns.clone().map(move |x| (y * side + x) as usize));
        let located: Vec<Located> = (0..)
            .zip(pixels)
            .flat_map(|(slot, pixel)| rays[pixel].iter().map(move |at| (slot, *at)))
            .map(|(slot, at)| Located {
                slot,
                place: at * scale + 0.5,
            })
            .collect();
        let eye = eye * scale + 0.5;
        let [streamed, single] = table.orders(eye, &located, config.gu.weight_bits);
        [streamed.mvoxels() as u64, streamed.rows(), single.rows()]
    });
    counts.reduce(|| [0; 3], |a, b| [a[0] + b[0], a[1] + b[1], a[2] + b[2]])
}
