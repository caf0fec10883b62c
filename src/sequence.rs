//! `potamoi render --frames`: the pictures of a way through a scene.

use std::path::{Path, PathBuf};
use std::time::Instant;

use potamoi_formats::config::Config;
use potamoi_golden::scene::Scene;

use crate::failure::Failure;
use crate::files;
use crate::progress;
use crate::render::{Numerics, shoot};
use crate::say::say;

/// Renders `frames` pictures beside `out`, numbered from 0. Each is whole or not
/// there, so that a run that is cut off leaves the ones before.
pub(crate) fn run(
    mut scene: Scene,
    config: &Config,
    numerics: Numerics,
    out: &Path,
    fps: f64,
    frames: u32,
) -> Result<(), Failure> {
    let cameras = scene.path(fps, frames)?;
    let names: Vec<PathBuf> = (0..cameras.len())
        .map(|n| numbered(out, n, cameras.len()))
        .collect();
    files::prepare(names.iter().map(Some))?;
    let start = Instant::now();
    let bar = progress::bar(cameras.len() as u64, "rendering");
    for (camera, name) in cameras.iter().zip(&names) {
        scene.set_camera(*camera);
        let shot = shoot(&scene, config, numerics)?;
        shot.picture.picture.write_png(name)?;
        bar.inc(1);
    }
    bar.finish_and_clear();
    if let (Some(first), Some(last)) = (names.first(), names.last()) {
        say!(
            "{}: {} pictures, {} to {}, in {:.1} s",
            scene.name(),
            names.len(),
            first.display(),
            last.display(),
            start.elapsed().as_secs_f64()
        );
    }
    Ok(())
}

/// `a/b.png` as `a/b.0007.png`: as many digits as the last has, four at least.
fn numbered(out: &Path, n: usize, count: usize) -> PathBuf {
    let digits = count.saturating_sub(1).to_string().len().max(4);
    out.with_extension(format!("{n:0digits$}.png"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_sort_as_names() {
        let out = Path::new("a/way.PNG");
        assert_eq!(numbered(out, 7, 10), Path::new("a/way.0007.png"));
        assert_eq!(numbered(out, 7, 10_001), Path::new("a/way.00007.png"));
    }
}
