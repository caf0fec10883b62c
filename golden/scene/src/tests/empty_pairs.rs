//! (tile, Gaussian) pairs that are left out because no pixel of the tile can count.

use potamoi_base::effects::{Choices, Effect};
use potamoi_base::mask::Mask;
use potamoi_formats::config::Config;
use potamoi_reference::ReferenceUnits;
use potamoi_splats::{FixedFrame, Order, PairTest, render_fixed_masked};

use super::*;

/// The paper's exponential, and coarse ones.
const EXPONENTIALS: [&str; 4] = [
    "",
    "[vu.exp]\niterations = 3",
    "[vu.exp]\nform = \"piecewise\"\npipelined = true\npieces = 64",
    "[vu.exp]\niterations = 5",
];
const LISTED: &str = "[rit]\npairs = \"that-may-count\"\n";

fn config(text: &str) -> Config {
    Config::from_toml(text, "test").unwrap()
}

/// A frame with all pairs and with those that may count. Bit for bit the same: picture, transmittance,
/// every skip and stop, and what is drawn. Returns both.
fn both(scene: &Scene, exponential: &str, order: Order, only: Option<&Mask>) -> [FixedFrame; 2] {
    let cloud = scene.cloud().unwrap();
    let [all, fewer] = ["", LISTED].map(|listed| {
        let config = config(&format!("{listed}{exponential}"));
        let mut options = scene.splat_options(&config);
        options.order = order;
        // Small enough to spill.
        options.hold_records = 40;
        let mut units = ReferenceUnits::new(&config);
        let (camera, profile) = (scene.camera(), scene.profile());
        render_fixed_masked(cloud, camera, profile, &options, only, &mut units).unwrap()
    });
    let what = format!("{} {exponential:?} {order:?}", scene.name());
    assert_eq!(all.picture, fewer.picture, "{what}");
    assert_eq!(all.transmittance, fewer.transmittance, "{what}");
    assert_eq!(all.decisions, fewer.decisions, "{what}");
    let counted = |frame: &FixedFrame| (frame.stats.drawn, frame.stats.stopped);
    assert_eq!(counted(&all), counted(&fewer), "{what}");
    assert_eq!(all.stats.pair_test, None);
    let test = fewer.stats.pair_test.unwrap();
    assert_eq!(test.pairs, all.stats.gathers, "{what}");
    assert_eq!(test.pairs - test.left_out, fewer.stats.gathers, "{what}");
    [all, fewer]
}

fn sized(name: &str, size: [u32; 2]) -> Scene {
    let mut scene = opened(name);
    scene.set_size(Some(size[0]), Some(size[1])).unwrap();
    scene
}

#[test]
fn no_bit_changes() {
    no_bit_changes_by(
        &EXPONENTIALS[..2],
        [("garden", [40, 24]), ("cairn:splats", [32, 27])],
    );
}

#[test]
#[ignore = "exhaustive; run with make test-full"]
fn no_bit_changes_by_any_exponential() {
    no_bit_changes_by(
        &EXPONENTIALS,
        [("garden", [150, 90]), ("cairn:splats", [72, 56])],
    );
}

/// In both orders, with coarse exponentials too. Less is written, read, held and evaluated.
fn no_bit_changes_by(exponentials: &[&str], scenes: [(&str, [u32; 2]); 2]) {
    for (name, size) in scenes {
        let scene = sized(name, size);
        for exponential in exponentials {
            for order in [Order::Exact, Order::Approximate] {
                let [all, fewer] = both(&scene, exponential, order, None);
                let PairTest { pairs, left_out } = fewer.stats.pair_test.unwrap();
                let what = format!("{name} {exponential:?}: {left_out} of {pairs}");
                assert!(10 * left_out > pairs && left_out < pairs, "{what}");
                let table = [&all, &fewer].map(|frame| frame.stats.streams.rit_written);
                assert_eq!(table[0] - table[1], 4 * left_out, "{what}");
                assert!(fewer.stats.evaluated < all.stats.evaluated, "{what}");
                let spilled = [&all, &fewer].map(|frame| frame.stats.hold.spilled_entries);
                assert!(
                    spilled[0] > spilled[1] || order == Order::Approximate,
                    "{what}"
                );
            }
        }
    }
}

/// In ray groups of a few tiles, where MVoxels that lost all their pairs are not visited.
#[test]
fn no_bit_changes_in_small_groups() {
    let mut scene = sized("garden", [150, 90]);
    scene.group_tiles = Some([2, 2]);
    for order in [Order::Exact, Order::Approximate] {
        let [all, fewer] = both(&scene, "", order, None);
        assert!(fewer.stats.tasks < all.stats.tasks, "{order:?}");
    }
}

/// Pixels of a mask, as the rest of a warped frame.
#[test]
fn no_bit_changes_within_a_mask() {
    for name in ["garden", "cairn:splats"] {
        let scene = sized(name, [96, 64]);
        let some = Mask::new([96, 64], |i| {
            (i % 96 / 5 + i / 96 / 3) % 7 == 0 && i % 96 < 50
        });
        for order in [Order::Exact, Order::Approximate] {
            let [_, fewer] = both(&scene, "", order, Some(&some));
            let test = fewer.stats.pair_test.unwrap();
            assert!(test.left_out > 0, "{name} {order:?}");
        }
    }
}

/// Where the arithmetic is not the configuration's, and where no power is known to count nowhere, every
/// pair is listed, and the reason is told.
#[test]
fn what_cannot_be_cut_is_listed_and_said() {
    let mut scene = sized("garden", [64, 48]);
    let wide = "[vu.exp]\ninput = \"U3.18\"\nconstant_bits = 24";
    let tested = |scene: &Scene, text: &str| {
        let config = config(text);
        let limits = scene.splat_options(&config).schedule.limits;
        (limits.is_some(), scene.keeps_all_pairs(&config).is_some())
    };
    let listed = |more: &str| format!("{LISTED}{more}");
    assert_eq!(tested(&scene, ""), (false, false));
    assert_eq!(tested(&scene, wide), (false, false));
    assert_eq!(tested(&scene, &listed("")), (true, false));
    assert_eq!(tested(&scene, &listed(wide)), (false, true));
    scene.set_choices(Choices::default().leave_out(Effect::Exponential));
    assert_eq!(tested(&scene, &listed("")), (false, true));
}

/// Published scenes at 400 x 400.
#[test]
#[ignore = "exhaustive; run with make test-full"]
fn no_bit_of_published_scenes_changes() {
    let shared = std::env::var_os("POTAMOI_SHARED").map_or_else(
        || std::path::PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared")),
        std::path::PathBuf::from,
    );
    let data = shared.join("data");
    for (file, camera) in [
        ("playbot_8k.ply", "playbot_31k"),
        ("playbot_31k.ply", "playbot_31k"),
        ("biker/biker.spz", "biker"),
    ] {
        let path = data.join("splats").join(file);
        if !path.exists() {
            println!("skipped: {file}: no shared data (set POTAMOI_SHARED)");
            continue;
        }
        let mut scene = Scene::open(path.to_str().unwrap()).unwrap();
        let camera = data.join(format!("cameras/camera_{camera}_800.json"));
        let notes = &mut potamoi_base::file_keys::Notes::default();
        let camera = crate::camera_file::read(&camera, notes).unwrap()[0].camera;
        scene.set_camera(camera.resized(400, 400));
        for order in [Order::Exact, Order::Approximate] {
            let [all, fewer] = both(&scene, "", order, None);
            let PairTest { pairs, left_out } = fewer.stats.pair_test.unwrap();
            println!("{file} {order:?}: {left_out} of {pairs} pairs are left out");
            assert!(4 * left_out > pairs && fewer.stats.evaluated < all.stats.evaluated);
        }
    }
}
