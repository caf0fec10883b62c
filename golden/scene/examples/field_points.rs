//! Densities and colours of an analytic scene at random points, as training data for models:
//! `field_points SCENE FOLDER [VIEWS] [SEED]` writes NumPy arrays into the folder.
//!
//! | file | type and shape | content |
//! |---|---|---|
//! | `box` | f64, 2 x 3 | corners of the scene in the world |
//! | `voxel` | f64, 1 | edge of a voxel of the sampled grid |
//! | `cells` | u8, 128 x 128 x 128 | along x, y, z: whether a cell of the scene's cube is non-empty |
//! | `at` | f32, N x 3 | points in the world |
//! | `direction` | f32, N x 3 | unit viewing directions |
//! | `density` | f32, N | optical depth per unit of length |
//! | `colour` | f32, N x 3 | linear RGB along the direction, 0 where there is no density |
//! | `vertices` | f32, M x C | channels of the sampled grid's vertices near surfaces |
//!
//! The cube has the middle of the box and its longest side. Half of the points lie near the
//! visible depth in pictures along the scene's path, each seen along its ray. The others lie
//! anywhere in non-empty cells, seen from a point of the path, and few of them deep inside solids.

use std::path::Path;

use glam::DVec3;
use ndarray::{Array1, Array2, Array3, ArrayView2, aview2};
use ndarray_npy::write_npy;
use potamoi_analytic::Analytic;
use rand::{Rng as _, SeedableRng as _};
use rand_pcg::Pcg64Mcg;
use rayon::prelude::*;

type Failure = Box<dyn std::error::Error>;

/// Cells along an edge of the cube.
const CELLS: usize = 128;
/// Side in pixels of the pictures that determine visible depths.
const SIDE: u32 = 160;
/// Duration of the path in seconds.
const PATH: f64 = 10.0;
/// Optical depth a voxel above which a point is deep inside.
const DEEP: f64 = 7.0;
/// Maximum number of vertices written.
const MOST_VERTICES: usize = 1 << 17;

/// A point of a field with its viewing direction.
struct Sample {
    at: DVec3,
    direction: DVec3,
    density: f64,
    colour: DVec3,
}

impl Sample {
    fn of(scene: Analytic, at: DVec3, direction: DVec3) -> Self {
        let density = scene.density(at);
        let colour = if density > 0.0 {
            scene.look(at).along(direction)
        } else {
            DVec3::ZERO
        };
        Self {
            at,
            direction,
            density,
            colour,
        }
    }
}

fn main() -> Result<(), Failure> {
    let mut args = std::env::args().skip(1);
    let names = Analytic::ALL.map(Analytic::name).join(", ");
    let scene = args.next().and_then(|name| Analytic::named(&name));
    let scene = scene.ok_or_else(|| format!("expected a scene: {names}"))?;
    let folder = args.next().ok_or("expected a folder to write to")?;
    let views: u32 = args.next().map_or(Ok(32), |text| text.parse())?;
    let seed: u64 = args.next().map_or(Ok(1), |text| text.parse())?;
    if !(1..=1000).contains(&views) {
        return Err(format!("{views} views: expected 1 to 1000").into());
    }

    let filled = cells(scene);
    let mut random = Pcg64Mcg::seed_from_u64(seed);
    let mut places = lit(scene, views, &mut random);
    let near = anywhere(scene, &filled, places.len(), &mut random);
    places.extend(near);
    let samples: Vec<Sample> = places
        .into_par_iter()
        .map(|(at, direction)| Sample::of(scene, at, direction))
        .collect();
    write(scene, Path::new(&folder), filled, &samples)?;
    println!("{}: {} points", scene.name(), samples.len());
    Ok(())
}

/// First corner and side of the scene's cube.
fn cube(scene: Analytic) -> (DVec3, f64) {
    let [low, high] = scene.bounds();
    let side = (high - low).max_element();
    ((low + high - side) / 2.0, side)
}

/// For each cell, whether there is density at a corner, in the middle of an edge or a face, or in
/// the middle of the cell.
fn cells(scene: Analytic) -> Array3<u8> {
    let (corner, side) = cube(scene);
    let points = 2 * CELLS + 1;
    let some: Vec<bool> = (0..points.pow(3))
        .into_par_iter()
        .map(|i| {
            let v = [i / (points * points), i / points % points, i % points];
            let at = DVec3::from(v.map(|v| v as f64)) / (2 * CELLS) as f64;
            scene.density(corner + side * at) > 0.0
        })
        .collect();
    Array3::from_shape_fn([CELLS; 3], |(x, y, z)| {
        let near = |c: usize| 2 * c..=2 * c + 2;
        let found = near(x)
            .flat_map(|i| near(y).flat_map(move |j| near(z).map(move |k| (i * points + j, k))))
            .any(|(row, k)| some[row * points + k]);
        u8::from(found)
    })
}

/// Points near the mean depth of each ray in the pictures.
fn lit(scene: Analytic, views: u32, random: &mut Pcg64Mcg) -> Vec<(DVec3, DVec3)> {
    let mut found = vec![];
    for _ in 0..views {
        let camera = scene.camera(random.random_range(0.0..PATH), SIDE, SIDE);
        let truth = scene.truth(&camera, [0.0; 3]);
        for (i, distance) in (0..).zip(&truth.distance) {
            // Drawn for every pixel, so that a view has the same share of the
            // numbers whatever it shows.
            let off = random.random_range(-2.0..1.5) * scene.voxel();
            if distance.is_finite() {
                let (origin, direction) = camera.ray(i % SIDE, i / SIDE);
                found.push((origin + direction * (distance + off), direction));
            }
        }
    }
    found
}

/// Points in non-empty cells.
fn anywhere(
    scene: Analytic,
    cells: &Array3<u8>,
    count: usize,
    random: &mut Pcg64Mcg,
) -> Vec<(DVec3, DVec3)> {
    let (corner, side) = cube(scene);
    let own: Vec<DVec3> = cells
        .indexed_iter()
        .filter(|(_, filled)| **filled != 0)
        .map(|((x, y, z), _)| DVec3::from([x, y, z].map(|v| v as f64)))
        .collect();
    let mut found = vec![];
    while found.len() < count && !own.is_empty() {
        let within = DVec3::from([0; 3].map(|_| random.random_range(0.0..1.0)));
        let cell = own[random.random_range(0..own.len())];
        let at = corner + (cell + within) * (side / CELLS as f64);
        let deep = scene.density(at) * scene.voxel() > DEEP;
        if random.random_bool(if deep { 0.1 } else { 1.0 }) {
            let eye = scene
                .camera(random.random_range(0.0..PATH), 8, 8)
                .position();
            found.push((at, (at - eye).normalize_or(DVec3::X)));
        }
    }
    found
}

/// Channels of every n-th of the grid's vertices that light may reach.
fn vertices(scene: Analytic) -> Result<Array2<f32>, Failure> {
    let grid = scene.bake()?;
    let channels = grid.layout().channels();
    let near = grid.features().chunks_exact(channels);
    let near: Vec<_> = near.filter(|v| v[0] > -2.0 && v[0] < 7.0).collect();
    let every = near.len().div_ceil(MOST_VERTICES).max(1);
    let kept: Vec<f32> = near.into_iter().step_by(every).flatten().copied().collect();
    Ok(Array2::from_shape_vec(
        [kept.len() / channels, channels],
        kept,
    )?)
}

fn write(
    scene: Analytic,
    folder: &Path,
    cells: Array3<u8>,
    samples: &[Sample],
) -> Result<(), Failure> {
    std::fs::create_dir_all(folder)?;
    let file = |name: &str| folder.join(format!("{name}.npy"));
    let corners = scene.bounds().map(|c| c.to_array());
    write_npy(file("box"), &aview2(&corners))?;
    write_npy(file("voxel"), &Array1::from(vec![scene.voxel()]))?;
    write_npy(file("cells"), &cells)?;
    write_npy(file("vertices"), &vertices(scene)?)?;
    let vectors = |of: fn(&Sample) -> DVec3| -> Vec<[f32; 3]> {
        samples.iter().map(|s| of(s).as_vec3().to_array()).collect()
    };
    for (name, values) in [
        ("at", vectors(|s| s.at)),
        ("direction", vectors(|s| s.direction)),
        ("colour", vectors(|s| s.colour)),
    ] {
        let values: ArrayView2<'_, f32> = aview2(&values);
        write_npy(file(name), &values)?;
    }
    let density: Vec<f32> = samples.iter().map(|s| s.density as f32).collect();
    write_npy(file("density"), &Array1::from(density))?;
    Ok(())
}
