//! Pictures of scenes by nothing but the splat unit: every bit is the golden renderer's, and every
//! cycle the cycle model's.

use std::path::PathBuf;

use potamoi_cycles::{Stalls, StreamStalls};
use potamoi_formats::config::{Config, SplatOpacity, SuConfig};
use potamoi_reference::ReferenceUnits;
use potamoi_reference::splat_unit::{SplatEntry, TILE};
use potamoi_rtl::{EngineKind, SplatUnit};
use potamoi_scene::{Model, Scene};
use potamoi_splats::{Schedule, View, render_fixed, unit_entries, unit_settings};

/// Counts of a picture.
#[derive(Debug, Default)]
struct Found {
    cycles: u64,
    counted: u64,
    square_sums: u64,
    exponentials: u64,
}

/// Renders a scene by the unit in groups of 4 by 4 tiles, and compares all pixels.
fn rendered(
    mut scene: Scene,
    size: [u32; 2],
    config: &Config,
    su: &SuConfig,
    stalls: Stalls,
) -> Found {
    scene.set_size(Some(size[0]), Some(size[1])).unwrap();
    let Model::Splats(cloud) = scene.model() else {
        panic!("not splats");
    };
    let mut options = scene.splat_options(config);
    options.schedule.group_tiles = Some([4, 4]);
    options.background = [0.0; 3];
    let view = View::new(cloud, scene.camera(), scene.profile()).unwrap();
    let mut units = ReferenceUnits::new(config);
    let frame = render_fixed(cloud, scene.camera(), scene.profile(), &options, &mut units).unwrap();
    let schedule = Schedule::new(cloud, &view, &options.schedule).unwrap();
    let groups: Vec<_> = (0..schedule.groups())
        .filter_map(|g| schedule.group(g))
        .collect();
    let jobs: Vec<Vec<SplatEntry>> = groups
        .iter()
        .map(|group| {
            let mut entries = vec![];
            unit_entries(&view, group, &mut |entry| entries.push(*entry));
            entries
        })
        .collect();
    let jobs: Vec<&[SplatEntry]> = jobs.iter().map(Vec::as_slice).collect();
    let unit = SplatUnit::on(EngineKind::Verilator, config, su).unwrap();
    let settings = unit_settings(view.rules(), su.opacity);
    let last_slot = su.tiles as u16 - 1;
    let run = unit.check(&jobs, last_slot, &settings, &stalls, 5).unwrap();
    for (group, pixels) in groups.iter().zip(&run.jobs) {
        for (slot, number) in group.tiles.iter().enumerate() {
            let [[x0, y0], [columns, rows]] = view.tile_pixels(*number as usize);
            for (x, y) in (0..rows).flat_map(|y| (0..columns).map(move |x| (x, y))) {
                let to = ((y0 + y) * size[0] + x0 + x) as usize;
                let found = pixels[slot * 256 + (y * TILE + x) as usize];
                assert_eq!(found.transmittance, frame.transmittance[to], "({x}, {y})");
                let colour = found.colour.map(|sum| (sum as f64 / 2f64.powi(32)) as f32);
                assert_eq!(colour, frame.picture.rgb[to], "({x}, {y})");
            }
        }
    }
    let counters = run.counters;
    assert_eq!(
        (counters.drawn, counters.stopped),
        (frame.stats.drawn, frame.stats.stopped)
    );
    Found {
        cycles: run.cycles,
        counted: counters.drawn + counters.stopped,
        square_sums: counters.square_sums,
        exponentials: counters.exponentials,
    }
}

fn unit(preset: &str, lanes: u32) -> (Config, SuConfig) {
    let su = SuConfig {
        lanes,
        tiles: 16,
        units: 1,
        pipelined: false,
        opacity: SplatOpacity::Multiplied,
    };
    (Config::preset(preset).unwrap(), su)
}

fn stalls() -> Stalls {
    let some = StreamStalls {
        per_mille: 300,
        burst: 5,
    };
    Stalls {
        rit: some,
        sink: some,
        ..Stalls::NONE
    }
}

#[test]
fn the_garden_is_rendered_by_the_unit_alone() {
    let garden = || Scene::open("garden").unwrap();
    for (preset, lanes, stalls) in [
        ("pipelined", 1, Stalls::NONE),
        ("pipelined", 1, stalls()),
        ("paper", 16, stalls()),
    ] {
        let (config, su) = unit(preset, lanes);
        let found = rendered(garden(), [64, 64], &config, &su, stalls);
        let counted = found.counted as f64;
        // Lane slots: the cut is rounded up, spans err outwards, and pixels end while pairs are in flight.
        assert!(found.exponentials as f64 <= 1.25 * counted, "{found:?}");
        assert!(found.square_sums as f64 <= 1.7 * counted, "{found:?}");
        println!(
            "{preset}, {lanes} lanes: {found:?}, {:.2} lane clocks a counted pair",
            found.cycles as f64 * f64::from(lanes) / counted
        );
    }
}

#[test]
fn playbot_is_rendered_by_the_unit_alone() {
    let shared = std::env::var_os("POTAMOI_SHARED").map_or_else(
        || PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../../shared"),
        PathBuf::from,
    );
    let file = shared.join("data/splats/playbot_8k.ply");
    if !file.exists() {
        println!("skipped: no shared data (set POTAMOI_SHARED)");
        return;
    }
    let scene = Scene::open(file.to_str().unwrap()).unwrap();
    let (config, su) = unit("pipelined", 1);
    let found = rendered(scene, [64, 64], &config, &su, stalls());
    println!("{found:?}");
}
