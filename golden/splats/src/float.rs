//! The float renderer: the reference for fixed-point pictures.

use glam::DVec3;
use rayon::prelude::*;

use super::cloud::Cloud;
use super::decisions::Decisions;
use super::error::RenderError;
use super::profile::Profile;
use super::tile::{Canvas, Outputs, Tile, TileLog};
use super::view::{TILE, View, Work};
use potamoi_base::camera::Camera;
use potamoi_base::mask::Mask;
use potamoi_base::picture::Picture;

/// Options of the float renderer.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct FloatOptions {
    /// Background, linear RGB.
    pub background: [f32; 3],
    /// Whether to keep [`FloatFrame::decisions`].
    pub log_decisions: bool,
    /// Whether to compute [`FloatFrame::depth`].
    pub depth: bool,
    /// Optional parts of the work.
    pub work: Work,
}

/// Work of a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct FloatStats {
    /// Gaussians that the near plane culled.
    pub culled: u64,
    /// Gaussians that touch a tile.
    pub visible: u64,
    /// (tile, Gaussian) pairs.
    pub entries: u64,
    /// (pixel, entry) pairs whose pixel had not stopped: the exponentials that the hardware
    /// computes.
    pub exponentials: u64,
    /// Exponentials evaluated here. Pixels beyond the ellipse of the alpha threshold are skipped,
    /// except for the rest of a group of four.
    pub evaluated: u64,
    /// (pixel, entry) pairs that contributed to a pixel.
    pub drawn: u64,
    /// Pixels that terminated early.
    pub stopped: u64,
}

/// A rendered frame.
#[derive(Debug, Clone, PartialEq)]
pub struct FloatFrame {
    /// The picture, including the background.
    pub picture: Picture,
    /// Final transmittance per pixel, 1 where nothing was drawn.
    pub transmittance: Vec<f64>,
    /// Depth per pixel along the camera's axis, if requested: the weighted mean over the centres
    /// of its Gaussians; infinite where nothing was drawn.
    pub depth: Option<Vec<f64>>,
    /// Work.
    pub stats: FloatStats,
    /// Each skip and stop, if requested.
    pub decisions: Option<Decisions>,
}

/// Renders in 64-bit floats, tile by tile. The result depends on neither the number of threads nor
/// the order of the Gaussians in the cloud.
///
/// # Errors
/// Those of [`View::new`].
pub fn render_float(
    cloud: &Cloud,
    camera: &Camera,
    profile: Profile,
    options: &FloatOptions,
) -> Result<FloatFrame, RenderError> {
    let view = View::by(cloud, camera, profile, &options.work)?;
    Ok(render_view(&view, options))
}

/// As [`render_float`], but renders only the pixels of a mask; the others are background. Only
/// tiles with such pixels have entries.
///
/// # Errors
/// Those of [`render_float`], or the mask does not have the camera's size.
pub fn render_masked(
    cloud: &Cloud,
    camera: &Camera,
    profile: Profile,
    options: &FloatOptions,
    only: &Mask,
) -> Result<FloatFrame, RenderError> {
    let view = View::by(cloud, camera, profile, &options.work)?;
    mask_fits(&view, only)?;
    Ok(composite(&view, options, Some(only)))
}

/// Checks that a mask has the size of a view.
pub(super) fn mask_fits(view: &View, mask: &Mask) -> Result<(), RenderError> {
    if mask.size() == view.size() {
        return Ok(());
    }
    Err(RenderError::Option {
        field: "mask",
        value: format!("{:?} pixels", mask.size()),
        expected: "a mask of the camera's size",
    })
}

/// Renders a view in 64-bit floating point.
#[must_use]
pub fn render_view(view: &View, options: &FloatOptions) -> FloatFrame {
    composite(view, options, None)
}

fn composite(view: &View, options: &FloatOptions, only: Option<&Mask>) -> FloatFrame {
    let wanted = Outputs {
        decisions: options.log_decisions,
        depths: options.depth,
        only,
    };
    let (first, ranks) = view.by_tile();
    let canvas = Canvas::new(view);
    let [width, height] = view.size();
    let [columns, _] = view.grid();
    let background = DVec3::from(options.background.map(f64::from));
    let mut picture = Picture::filled(width, height, [0.0; 3]);
    let mut transmittance = vec![1.0; picture.rgb.len()];
    let mut depth = vec![f64::INFINITY; picture.rgb.len()];
    let mut decisions = options.log_decisions.then(|| Decisions::new(first.clone()));

    // Bands of one tile's height: each thread writes pixels of its own.
    let band = TILE as usize * width as usize;
    let bands: Vec<Vec<TileLog>> = picture
        .rgb
        .par_chunks_mut(band)
        .zip(transmittance.par_chunks_mut(band))
        .zip(depth.par_chunks_mut(band))
        .enumerate()
        .map(|(row, ((rgb, left), depth))| {
            let tiles: Vec<Tile> = (row * columns as usize..(row + 1) * columns as usize)
                .into_par_iter()
                .map(|t| canvas.render(t, &ranks[first[t]..first[t + 1]], wanted))
                .collect();
            for (column, tile) in tiles.iter().enumerate() {
                let t = row * columns as usize + column;
                let [[x0, _], [wide, high]] = view.tile_pixels(t);
                for y in 0..high as usize {
                    let at = y * width as usize + x0 as usize;
                    for x in 0..wide as usize {
                        let from = y * TILE as usize + x;
                        let colour = tile.colour(from) + tile.left[from] * background;
                        rgb[at + x] = colour.as_vec3().to_array();
                        left[at + x] = tile.left[from];
                        if wanted.depths {
                            depth[at + x] = tile.depth(from);
                        }
                    }
                }
            }
            tiles.into_iter().map(|t| t.log).collect()
        })
        .collect();

    let mut stats = FloatStats {
        culled: view.culled() as u64,
        visible: view.splats().len() as u64,
        ..FloatStats::default()
    };
    for (t, log) in bands.into_iter().flatten().enumerate() {
        if log.pixels > 0 {
            stats.entries += (first[t + 1] - first[t]) as u64;
        }
        stats.exponentials += log.live;
        stats.evaluated += log.evaluated;
        stats.drawn += log.draws;
        stats.stopped += log.stopped;
        if let (Some(d), Some((drawn, stop))) = (&mut decisions, log.decisions) {
            d.stop[t] = stop;
            d.drawn[first[t]..first[t + 1]].copy_from_slice(&drawn);
        }
    }
    FloatFrame {
        picture,
        transmittance,
        depth: options.depth.then_some(depth),
        stats,
        decisions,
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::view::TILE_PIXELS;
    use glam::DVec2;
    use rand::{Rng, SeedableRng};
    use rand_pcg::Pcg64;

    const LOG: FloatOptions = FloatOptions {
        background: [0.25, 0.0, 1.0],
        log_decisions: true,
        depth: true,
        work: Work::ALL,
    };

    /// Evaluates every pixel of every entry with the library's exponential, one after another.
    fn plain(view: &View) -> FloatFrame {
        let rules = view.rules();
        let [width, height] = view.size();
        let (first, ranks) = view.by_tile();
        let mut picture = Picture::filled(width, height, [0.0; 3]);
        let mut transmittance = vec![1.0; picture.rgb.len()];
        let mut depth = vec![f64::INFINITY; picture.rgb.len()];
        let mut decisions = Decisions::new(first.clone());
        let mut stats = FloatStats::default();
        for t in 0..view.tile_count() {
            let [[x0, y0], [columns, rows]] = view.tile_pixels(t);
            for pixel in 0..TILE_PIXELS {
                let (x, y) = (pixel as u32 % TILE, pixel as u32 / TILE);
                if x >= columns || y >= rows {
                    continue;
                }
                let centre = DVec2::new(f64::from(x0 + x), f64::from(y0 + y)) + rules.pixel_centre;
                let (mut colour, mut left, mut far) = (DVec3::ZERO, 1.0, 0.0);
                for (entry, place) in (first[t]..first[t + 1]).enumerate() {
                    let splat = &view.splats()[ranks[place] as usize];
                    stats.exponentials += 1;
                    let alpha = splat.alpha(centre - splat.mean).min(rules.alpha_cap);
                    if alpha < rules.alpha_min {
                        continue;
                    }
                    let after = left * (1.0 - alpha);
                    if rules.stops(after) {
                        decisions.stop[t][pixel] = entry as u32;
                        stats.stopped += 1;
                        break;
                    }
                    colour += splat.colour * (alpha * left);
                    far += splat.depth * (alpha * left);
                    left = after;
                    stats.drawn += 1;
                    decisions.drawn[place][pixel / 64] |= 1 << (pixel % 64);
                }
                let to = ((y0 + y) * width + x0 + x) as usize;
                let background = DVec3::from(LOG.background.map(f64::from));
                picture.rgb[to] = (colour + left * background).as_vec3().to_array();
                transmittance[to] = left;
                if left < 1.0 {
                    depth[to] = far / (1.0 - left);
                }
            }
        }
        FloatFrame {
            picture,
            transmittance,
            depth: Some(depth),
            stats,
            decisions: Some(decisions),
        }
    }

    /// From dust to needles that cross the frame a million times over, with
    /// opacities from none to all.
    fn cloud(n: usize, scales: [f32; 2], seed: u64) -> Cloud {
        let mut r = Pcg64::seed_from_u64(seed);
        let mut draw = |low: f32, high: f32| r.random_range(low..high);
        let means = (0..n)
            .map(|_| [draw(-1.0, 1.0), draw(-1.0, 1.0), draw(0.3, 4.0)])
            .collect();
        let log_scales = (0..n).map(|_| [0; 3].map(|_| draw(scales[0], scales[1])));
        let log_scales = log_scales.collect();
        let rotations = (0..n).map(|_| [0; 4].map(|_| draw(-1.0, 1.0))).collect();
        let logits = (0..n)
            .map(|i| match i % 50 {
                0 => f32::INFINITY,
                1 => f32::NEG_INFINITY,
                _ => draw(-7.0, 7.0),
            })
            .collect();
        let sh = (0..n).map(|_| [0; 3].map(|_| draw(-2.0, 4.0))).collect();
        Cloud::new(0, means, log_scales, rotations, logits, sh).unwrap()
    }

    fn camera(width: u32, height: u32) -> Camera {
        Camera::look_at(DVec3::ZERO, DVec3::Z, DVec3::NEG_Y, 0.9, width, height)
    }

    #[test]
    fn a_mask_renders_its_pixels_and_nothing_else() {
        let cloud = cloud(300, [-5.0, -1.0], 7);
        let camera = camera(45, 37);
        let view = View::new(&cloud, &camera, Profile::Inria).unwrap();
        let all = render_view(&view, &LOG);
        // Single pixels, and tiles without any.
        let mask = Mask::new([45, 37], |i| i % 7 == 3 && i / 45 < 20);
        let some = render_masked(&cloud, &camera, Profile::Inria, &LOG, &mask).unwrap();
        let [all_depth, some_depth] = [&all, &some].map(|f| f.depth.as_ref().unwrap());
        for i in 0..all.transmittance.len() {
            if mask.has(i) {
                assert_eq!(some.picture.rgb[i], all.picture.rgb[i]);
                assert_eq!(some.transmittance[i], all.transmittance[i]);
                assert_eq!(some_depth[i], all_depth[i]);
            } else {
                assert_eq!(some.picture.rgb[i], LOG.background);
                assert_eq!((some.transmittance[i], some_depth[i]), (1.0, f64::INFINITY));
            }
        }
        // Entries of the lower tile row are not taken; few pixels, few exponentials.
        let [some_stats, all_stats] = [some.stats, all.stats];
        assert!(
            0 < some_stats.entries && some_stats.entries < all_stats.entries,
            "{some_stats:?} {all_stats:?}"
        );
        assert!(
            some_stats.exponentials * 6 < all_stats.exponentials,
            "{some_stats:?} {all_stats:?}"
        );
        let every = Mask::new([45, 37], |_| true);
        let again = render_masked(&cloud, &camera, Profile::Inria, &LOG, &every).unwrap();
        assert_eq!(again, all);
        let other = Mask::new([37, 45], |_| true);
        let error = render_masked(&cloud, &camera, Profile::Inria, &LOG, &other).unwrap_err();
        assert!(
            error.to_string().contains("`mask` is [37, 45] pixels"),
            "{error}"
        );
    }

    #[test]
    fn spans_and_groups_change_no_decision() {
        let mut culled = 0;
        for (seed, scales, size) in [
            (1, [-6.0, -3.0], [75, 50]),
            (2, [-6.0, -1.0], [17, 33]),
            (3, [-12.0, 2.0], [61, 48]),
            (4, [-30.0, 14.0], [40, 40]),
            (5, [-80.0, 80.0], [16, 31]),
        ] {
            let cloud = cloud(500, scales, seed);
            for profile in Profile::ALL {
                let view = View::new(&cloud, &camera(size[0], size[1]), profile).unwrap();
                let (fast, slow) = (render_view(&view, &LOG), plain(&view));
                assert_eq!(fast.decisions, slow.decisions, "{seed} {profile}");
                let counts = |s: &FloatStats| [s.exponentials, s.drawn, s.stopped];
                assert_eq!(counts(&fast.stats), counts(&slow.stats));
                let stats = fast.stats;
                assert!(
                    stats.drawn > 400 && stats.evaluated >= stats.drawn,
                    "{stats:?}"
                );
                culled += u64::from(stats.evaluated < stats.exponentials / 2);
                // Two units of the last place an exponential, some hundred deep.
                for (a, b) in fast.transmittance.iter().zip(&slow.transmittance) {
                    assert!((a - b).abs() < 1e-14, "{seed} {profile}: {a} {b}");
                }
                // A weight of at least 1/255, less what 1 - T cancels.
                let [fast_depth, slow_depth] = [&fast, &slow].map(|f| f.depth.as_ref().unwrap());
                for (a, b) in fast_depth.iter().zip(slow_depth) {
                    assert!(
                        a == b || (a - b).abs() < 1e-11 * b,
                        "{seed} {profile}: {a} {b}"
                    );
                }
                let pixels = fast.picture.rgb.iter().zip(&slow.picture.rgb);
                for (a, b) in pixels.flat_map(|(a, b)| a.iter().zip(b)) {
                    assert!((a - b).abs() <= f32::EPSILON * b.abs(), "{a} {b}");
                }
            }
        }
        assert!(culled > 5, "{culled}");
    }

    #[test]
    fn threads_change_no_byte() {
        let (cloud, camera) = (cloud(3000, [-6.0, -1.0], 9), camera(150, 90));
        let render = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
            let frame = || render_float(&cloud, &camera, Profile::Inria, &LOG);
            pool.build().unwrap().install(frame).unwrap()
        };
        let one = render(1);
        assert!(one.stats.visible > 2048, "several blocks of Gaussians");
        for threads in [2, 5] {
            assert_eq!(render(threads), one);
        }
    }
}
