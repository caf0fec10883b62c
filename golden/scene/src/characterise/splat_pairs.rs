//! Pairs of pixel and Gaussian: how many are evaluated today, and how many of them count.

use potamoi_formats::config::{ExpBase, ExpConfig, ExpOutput, SplatOpacity};
use potamoi_gaussians::Cloud;
use potamoi_reference::splat_unit::{ReferenceSplatUnit, SplatEntry};
use potamoi_splats::{
    FixedOptions, RenderError, Schedule, ScheduleOptions, TileLimits, View, unit_entries,
    unit_settings,
};
use schemars::JsonSchema;
use serde::Serialize;

/// Fewest fraction bits of the exponential's input that spans are found with.
const LEAST_FRACTION: u32 = 12;
/// Most bits of the exponential's input: all its codes are computed.
const MOST_INPUT: u32 = 20;

/// Pairs of a frame, each kind a part of the one before.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, JsonSchema)]
pub struct SplatPairs {
    /// (tile, Gaussian) pairs of the profile's list.
    pub tile_pairs: u64,
    /// Those in whose tile a pixel may count, by the test of tiles: what `rit.pairs = "that-may-count"`
    /// lists.
    pub tile_pairs_that_may_count: u64,
    /// Those of a tile in which a pixel counts that has not stopped.
    pub tile_pairs_that_count: u64,
    /// (pixel, Gaussian) pairs whose pixel has not stopped: each takes a square sum, an exponential
    /// and a product where nothing is left out.
    pub evaluated: u64,
    /// Those in the spans of the tile's rows, which are found from the record with a few bits: square
    /// sums.
    pub in_spans: u64,
    /// Those whose power is at most the limit of the opacity, which is stored rounded up:
    /// exponentials.
    pub kept: u64,
    /// Those that contribute to a pixel.
    pub drawn: u64,
    /// Those at which a pixel stops.
    pub stopped: u64,
}

/// Counts the pairs of a frame in exact order, from *evaluated* on of what the options list. `None` if the exponential is not one that pairs can be
/// left out of: powers of two, mantissa and exponent, a signed input, or one of too few or many bits.
///
/// # Errors
/// Those of [`potamoi_splats::render_fixed`].
pub fn splat_pairs(
    cloud: &Cloud,
    view: &View,
    options: &FixedOptions,
    exp: &ExpConfig,
) -> Result<Option<SplatPairs>, RenderError> {
    if !can_leave_out(exp) {
        return Ok(None);
    }
    let tested = ScheduleOptions {
        limits: TileLimits::new(exp, view.rules(), options.schedule.opacity),
        ..options.schedule.clone()
    };
    let test = Schedule::new(cloud, view, &tested)?.test();
    let test = test.unwrap_or_default();
    let schedule = Schedule::new(cloud, view, &options.schedule)?;
    let mut found = SplatPairs {
        tile_pairs: test.pairs,
        tile_pairs_that_may_count: test.pairs - test.left_out,
        ..SplatPairs::default()
    };
    for group in (0..schedule.groups()).filter_map(|g| schedule.group(g)) {
        let mut unit = unit_of(view, exp, group.tiles.len(), options.schedule.opacity);
        unit_entries(view, &group, &mut |entry| found.add(&mut unit, entry));
        let counts = unit.counts();
        found.drawn += counts.drawn;
        found.stopped += counts.stopped;
    }
    Ok(Some(found))
}

fn can_leave_out(exp: &ExpConfig) -> bool {
    exp.base == ExpBase::E
        && exp.output == ExpOutput::Alpha
        && !exp.input.is_signed()
        && exp.input.frac_bits() >= LEAST_FRACTION
        && exp.input.width() <= MOST_INPUT
}

fn unit_of(
    view: &View,
    exp: &ExpConfig,
    tiles: usize,
    opacity: SplatOpacity,
) -> ReferenceSplatUnit {
    ReferenceSplatUnit::new(exp, tiles, unit_settings(view.rules(), opacity))
}

impl SplatPairs {
    fn add(&mut self, unit: &mut ReferenceSplatUnit, entry: &SplatEntry) {
        let columns = (2u32 << entry.last[0]) - 1;
        let live = unit.tiles()[usize::from(entry.slot)].live;
        let rows = live.iter().take(usize::from(entry.last[1]) + 1);
        let live: u32 = rows
            .map(|row| (u32::from(*row) & columns).count_ones())
            .sum();
        let before = unit.counts();
        unit.composite(entry);
        let after = unit.counts();
        let counted = after.drawn + after.stopped - before.drawn - before.stopped;
        self.tile_pairs_that_count += u64::from(counted > 0);
        self.evaluated += u64::from(live);
        self.in_spans += after.square_sums - before.square_sums;
        self.kept += after.exponentials - before.exponentials;
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::panic)]
    use potamoi_formats::config::Config;
    use potamoi_reference::ReferenceUnits;
    use potamoi_reference::splat_unit::TILE;
    use potamoi_splats::render_fixed;

    use super::*;
    use crate::Model;

    fn parts(name: &str, size: [u32; 2]) -> (crate::Scene, Config) {
        let mut scene = crate::tests::opened(name);
        scene.set_size(Some(size[0]), Some(size[1])).unwrap();
        (scene, Config::paper())
    }

    /// What is left out changes no bit: transmittances and colours of all pixels are the renderer's,
    /// which evaluates every pair, and so are its counts.
    #[test]
    fn what_is_left_out_changes_no_bit() {
        for (name, size, order) in [("garden", [150, 90], 3), ("cairn:splats", [64, 64], 9)] {
            let (scene, config) = parts(name, size);
            let Model::Splats(cloud) = scene.model() else {
                panic!("{name} is splats")
            };
            let mut options = scene.splat_options(&config);
            options.schedule.group_tiles = Some([order, order]);
            options.background = [0.0; 3];
            let view = View::new(cloud, scene.camera(), scene.profile()).unwrap();
            let mut units = ReferenceUnits::new(&config);
            let frame = render_fixed(cloud, scene.camera(), scene.profile(), &options, &mut units);
            let frame = frame.unwrap();
            let schedule = Schedule::new(cloud, &view, &options.schedule).unwrap();
            for group in (0..schedule.groups()).filter_map(|g| schedule.group(g)) {
                let mut unit = unit_of(
                    &view,
                    &config.vu.exp,
                    group.tiles.len(),
                    SplatOpacity::Multiplied,
                );
                unit_entries(&view, &group, &mut |entry| {
                    unit.composite(entry);
                });
                for (tile, number) in unit.tiles().iter().zip(&group.tiles) {
                    let [[x0, y0], [columns, rows]] = view.tile_pixels(*number as usize);
                    for (x, y) in (0..rows).flat_map(|y| (0..columns).map(move |x| (x, y))) {
                        let to = ((y0 + y) * size[0] + x0 + x) as usize;
                        let from = (y * TILE + x) as usize;
                        assert_eq!(tile.transmittance[from], frame.transmittance[to], "{name}");
                        let unit = 2f64.powi(32);
                        let colour = tile.colour[from].map(|sum| (sum as f64 / unit) as f32);
                        assert_eq!(colour, frame.picture.rgb[to], "{name}");
                    }
                }
            }
            let pairs = splat_pairs(cloud, &view, &options, &config.vu.exp);
            let pairs = pairs.unwrap().unwrap();
            let stats = &frame.stats;
            assert_eq!((pairs.drawn, pairs.stopped), (stats.drawn, stats.stopped));
            assert_eq!(
                (pairs.tile_pairs, pairs.evaluated),
                (stats.gathers, stats.evaluated)
            );
            // Few of them do not count: the limit is rounded up, and spans err outwards.
            let counted = (pairs.drawn + pairs.stopped) as f64;
            let (kept, in_spans) = (pairs.kept as f64, pairs.in_spans as f64);
            assert!(counted <= kept && kept <= in_spans, "{pairs:?}");
            assert!(
                kept < 1.01 * counted && in_spans < 1.1 * counted,
                "{pairs:?}"
            );
            let may_count = pairs.tile_pairs_that_may_count;
            assert!(pairs.tile_pairs_that_count <= may_count && may_count < pairs.tile_pairs);
            // Where pairs are left out, those that are left hold all that is drawn.
            options.schedule.limits =
                TileLimits::new(&config.vu.exp, view.rules(), SplatOpacity::Multiplied);
            let fewer = splat_pairs(cloud, &view, &options, &config.vu.exp);
            let fewer = fewer.unwrap().unwrap();
            let evaluated = (pairs.evaluated - fewer.evaluated) as f64;
            assert!(
                evaluated > 0.1 * pairs.evaluated as f64,
                "{pairs:?} {fewer:?}"
            );
            // The test is closer than spans, which err outwards.
            assert!(fewer.in_spans <= pairs.in_spans && fewer.kept <= pairs.kept);
            let (evaluated, in_spans, kept) = (pairs.evaluated, pairs.in_spans, pairs.kept);
            let others = SplatPairs {
                evaluated,
                in_spans,
                kept,
                ..fewer
            };
            assert_eq!(others, pairs);
        }
    }

    #[test]
    fn of_other_exponentials_nothing_is_said() {
        let (scene, config) = parts("garden", [32, 32]);
        let Model::Splats(cloud) = scene.model() else {
            panic!("the garden is splats")
        };
        let view = View::new(cloud, scene.camera(), scene.profile()).unwrap();
        let exp = ExpConfig {
            output: ExpOutput::General,
            ..config.vu.exp.clone()
        };
        let options = scene.splat_options(&config);
        assert_eq!(splat_pairs(cloud, &view, &options, &exp).unwrap(), None);
    }
}
