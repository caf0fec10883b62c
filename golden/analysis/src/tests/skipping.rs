//! Leaving out what is not called for changes nothing.

use super::*;

/// Leaving out what is not called for, and forcing it, changes no bit of either picture, of the
/// trace, or of a count.
fn skipping_changes_nothing(name: &str, width: u32) {
    let scene = opened(name, width);
    let config = fitting(&scene);
    let mut forced = scene.clone();
    forced.set_choices(Choices::all());
    let found = analysed(&scene, &[*scene.camera()]);
    let skipped = found.findings.iter().filter(|f| !f.is_called_for);
    assert!(skipped.count() >= 5, "{name}: {found:?}");
    let [plain, all] = [&scene, &forced].map(|scene| everything(scene, &config));
    assert!(plain == all, "{name}: forcing all changes something");
}

#[test]
fn skipping_changes_no_bit_of_the_eight_scenes_as_voxels() {
    for name in &BUILTIN[2..] {
        skipping_changes_nothing(&format!("{name}:voxels"), 12);
    }
}

/// Pixels of a tile outside of the frame decide nothing, whether or not rays stop.
#[test]
fn skipping_changes_no_decision_in_frames_of_any_width() {
    let mut scene = splats(ring(2, |_, logits| logits.fill(0.0)));
    for width in [16, 17, 24, 50, 51] {
        scene.set_size(Some(width), Some(20)).unwrap();
        assert!(!calls(&scene, Effect::EarlyTermination));
        let config = fitting(&scene);
        let mut forced = scene.clone();
        forced.set_choices(Choices::all());
        let [plain, all] = [&scene, &forced].map(|s| s.render_float().unwrap());
        assert!(plain == all, "{width}");
        let fixed = scene.render_fixed(&config, &mut ReferenceUnits::new(&config));
        let flips = fixed.unwrap().flips(&plain).unwrap();
        assert!(flips.skip <= 2 && flips.stop == 0, "{width}: {flips:?}");
    }
}

#[test]
fn skipping_changes_no_bit_of_splats() {
    skipping_changes_nothing("garden", 20);
}

#[test]
#[ignore = "minutes: 8 scenes in 7 representations"]
fn skipping_changes_no_bit_of_any_representation() {
    for name in &BUILTIN[2..] {
        for representation in Representation::ALL {
            skipping_changes_nothing(&format!("{name}:{}", representation.name()), 72);
        }
    }
    skipping_changes_nothing("garden", 200);
    skipping_changes_nothing("lantern", 200);
}

#[test]
#[ignore = "half a minute: a published scene"]
fn skipping_changes_no_bit_of_playbot() {
    let Some(path) = playbot() else { return };
    skipping_changes_nothing(path.to_str().unwrap(), 100);
}

fn playbot() -> Option<std::path::PathBuf> {
    let shared = std::env::var_os("POTAMOI_SHARED").map_or_else(
        || std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared"),
        Into::into,
    );
    let folder = shared.join("data/splats");
    let listed = std::fs::read_dir(&folder).into_iter().flatten().flatten();
    let found = listed.map(|entry| entry.path()).find(|path| {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        name.contains("playbot") && name.ends_with(".ply")
    });
    if found.is_none() {
        println!("skipped: playbot: no shared data (set POTAMOI_SHARED)");
    }
    found
}

/// Degrees that are skipped would add nothing: the picture is that of all of them; and one that
/// is left out although it is called for is missed.
#[test]
fn skipped_degrees_change_no_bit_and_missed_ones_do() {
    for (at, value) in [(0, 1.0), (2, 0.5), (7, -0.5), (12, 0.7)] {
        let scene = splats(ring(30, |sh, _| {
            sh.iter_mut()
                .skip(at)
                .step_by(16)
                .for_each(|c| c[1] = value);
        }));
        let config = fitting(&scene);
        let with = |choices| {
            let mut own = scene.clone();
            own.set_choices(choices);
            everything(&own, &config)
        };
        let plain = with(Choices::default());
        assert!(plain == with(Choices::all()), "{at}");
        let first = Effect::SphericalHarmonics(1);
        let lacking = with(Choices::all().leave_out(first));
        assert_eq!(plain == lacking, at == 0, "{at}");
    }
}
