//! Depth error of a model's mesh against the exact depth of its analytic scene.
//!
//! ```text
//! cargo run --release -p potamoi-scene --example mesh_depth -- [SCENE ...] [-- CELLS ...]
//! ```
//!
//! For each scene (default `cairn`), number of cells along its longest side (64, 128, 256) and
//! factor of the computed level, it prints triangles, time, the median and the 95th percentile of
//! the depth difference in voxel edges, the signed median, and the share of pixels in which only
//! one of the two has a surface, relative to those with an exact depth. Pictures have 200 x 200
//! pixels, from eight points of the scene's path.
#![allow(clippy::print_stdout)]

use std::error::Error;
use std::time::Instant;

use potamoi_scene::surface::{level_of, of_scene_at};
use potamoi_scene::{ExactDepth, Scene};
use potamoi_warp::{Geometry as _, is_surface};

/// Factors of the level.
const FACTORS: [f64; 5] = [0.25, 0.5, 1.0, 2.0, 4.0];

fn main() -> Result<(), Box<dyn Error>> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let mut parts = words.split(|w| w == "--");
    let mut scenes = parts.next().unwrap_or_default().to_vec();
    if scenes.is_empty() {
        scenes.push("cairn".to_owned());
    }
    let cells = match parts.next() {
        Some(words) => words.iter().map(|w| w.parse()).collect::<Result<_, _>>()?,
        None => vec![64u32, 128, 256],
    };
    for name in scenes {
        let scene = Scene::open(&name)?;
        let analytic = scene
            .analytic()
            .ok_or("not sampled from an analytic scene")?;
        let cameras: Vec<_> = (0..8)
            .map(|k| analytic.camera(1.3 * f64::from(k), 200, 200))
            .collect();
        let exact = cameras.iter().map(|c| ExactDepth(analytic).depth(c));
        let exact: Vec<_> = exact.collect::<Result<_, _>>()?;
        for cells in &cells {
            let start = Instant::now();
            let level = level_of(&scene, *cells)?;
            let level_time = start.elapsed();
            for factor in FACTORS {
                let start = Instant::now();
                let mesh = of_scene_at(&scene, *cells, factor * level)?;
                let made = start.elapsed();
                let (mut off, mut differ, mut surfaces) = (vec![], 0, 0);
                let start = Instant::now();
                for (camera, exact) in cameras.iter().zip(&exact) {
                    for (found, exact) in mesh.depth(camera).iter().zip(exact) {
                        surfaces += u32::from(is_surface(*exact));
                        match [*found, *exact].map(is_surface) {
                            [true, true] => {
                                off.push(f64::from(found - exact) / analytic.voxel());
                            }
                            [false, false] => {}
                            _ => differ += 1,
                        }
                    }
                }
                let drawn = start.elapsed() / cameras.len() as u32;
                let at = |all: &mut Vec<f64>, share: f64| {
                    all.sort_by(f64::total_cmp);
                    let last = all.len().saturating_sub(1) as f64;
                    all.get((share * last) as usize)
                        .copied()
                        .unwrap_or(f64::NAN)
                };
                let signed = at(&mut off, 0.5);
                off.iter_mut().for_each(|v| *v = v.abs());
                println!(
                    "{name} {cells}: level {:.1} (found in {level_time:.0?}) x {factor}: {} \
                     triangles in {made:.0?}, drawn in {drawn:.1?}; off {:.3} median ({signed:+.3}), \
                     {:.3} at 95 %, voxel edges; {:.2} % differ",
                    level,
                    mesh.triangles().len(),
                    at(&mut off, 0.5),
                    at(&mut off, 0.95),
                    100.0 * f64::from(differ) / f64::from(surfaces)
                );
            }
        }
    }
    Ok(())
}
