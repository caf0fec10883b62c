#![allow(clippy::unwrap_used, clippy::panic)]

use glam::{DAffine3, DVec3, dvec3};
use potamoi_formats::config::{Config, Modes, PRESETS};
use potamoi_formats::units::OpCode;
use proptest::prelude::*;

use super::*;
use crate::camera::Camera;
use crate::precision::Precision;
use crate::scene::{BUILTIN, Model, Rendered, Representation, Scene};
use crate::splats::Cloud;
use crate::units::Twins;
use crate::units::recorder::{Limits, Recorder};
use crate::voxels::{Grid, Layout};
use crate::warp::{Plan, PlanOptions, Profile, ReferenceFrom, Sequence, Warper};

fn preset(name: &str) -> Config {
    let (_, text) = PRESETS.iter().find(|(own, _)| *own == name).unwrap();
    Config::from_toml(text, name).unwrap()
}

/// A preset in which a model can be rendered.
fn fitting(scene: &Scene) -> Config {
    preset(match scene.model() {
        Model::Splats(_) | Model::Voxels(_) => "paper",
        _ => "fields",
    })
}

fn analysed(scene: &Scene, path: &[Camera]) -> Analysis {
    Analysis::of(scene, path, &fitting(scene), Surroundings::default()).unwrap()
}

fn opened(name: &str, width: u32) -> Scene {
    let mut scene = Scene::open(name).unwrap();
    scene.set_size(Some(width), None).unwrap();
    scene
}

/// A scene of a model.
fn with_model(model: Model) -> Scene {
    opened("garden", 24).with_model(model)
}

fn calls(scene: &Scene, effect: Effect) -> bool {
    analysed(scene, &[*scene.camera()]).calls_for(effect)
}

/// Everything that a frame gives: pictures in both arithmetics bit by bit, counts, and the trace.
fn everything(scene: &Scene, config: &Config) -> impl PartialEq + use<> {
    let float = scene.render_float().unwrap();
    let mut twins = Twins::new(config);
    let mut recorder = Recorder::new(&mut twins, Limits::NONE);
    let fixed = scene.render_fixed(config, &mut recorder).unwrap();
    let (gathered, computed) = (recorder.gathered, recorder.computed);
    assert!(gathered.len() + computed.len() > 0 || fixed.counts.feature_vectors == 0);
    let bits = |rendered: &Rendered| -> Vec<u32> {
        let rgb = rendered.picture.rgb.iter().flatten();
        rgb.map(|v| v.to_bits()).collect()
    };
    let pictures = (bits(&float), bits(&fixed));
    (pictures, fixed.covered, fixed.counts, gathered, computed)
}

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
        let fixed = scene.render_fixed(&config, &mut Twins::new(&config));
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
        || std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared"),
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

/// A ring of Gaussians with coefficients of degree 3, all 0 above degree 0.
fn ring(count: usize, change: impl Fn(&mut Vec<[f32; 3]>, &mut Vec<f32>)) -> Cloud {
    let means = (0..count).map(|i| {
        let angle = i as f32 * 0.7;
        [0.6 * angle.cos(), 0.6 * angle.sin(), 0.03 * i as f32]
    });
    let mut sh = vec![[0.0; 3]; 16 * count];
    sh.iter_mut()
        .step_by(16)
        .for_each(|c| *c = [0.4, 0.9, -0.3]);
    let mut logits = vec![-2.0; count];
    change(&mut sh, &mut logits);
    Cloud::new(
        3,
        means.collect(),
        vec![[-2.0; 3]; count],
        vec![[1.0, 0.0, 0.0, 0.0]; count],
        logits,
        sh,
    )
    .unwrap()
}

fn splats(cloud: Cloud) -> Scene {
    let mut scene = with_model(Model::Splats(cloud));
    let camera = Camera::look_at(dvec3(4.0, -3.0, 2.0), DVec3::ZERO, DVec3::Z, 0.8, 24, 24);
    scene.set_camera(camera);
    scene
}

/// One coefficient of a degree that is not 0 calls for that degree and those below it, and for no
/// other.
#[test]
fn one_coefficient_calls_for_its_degree() {
    let plain = splats(ring(30, |_, _| ()));
    let found = analysed(&plain, &[*plain.camera()]);
    let evidence = found.evidence(Effect::SphericalHarmonics(1));
    assert_eq!(evidence, "no coefficient above degree 0 in 30 Gaussians");
    for (at, degree) in [(0, 0), (1, 1), (3, 1), (4, 2), (8, 2), (9, 3), (15, 3)] {
        for value in [1e-40, -3.0] {
            let scene = splats(ring(30, |sh, _| sh[16 * 17 + at][2] = value));
            let found = analysed(&scene, &[*scene.camera()]);
            for own in 1..=3u8 {
                let called = found.calls_for(Effect::SphericalHarmonics(own));
                assert_eq!(called, usize::from(own) <= degree, "{at}: {own}");
            }
        }
    }
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

/// Less than 1/10,000 of the light behind is never left of few faint Gaussians; one more opaque
/// one calls for the test.
#[test]
fn opacity_calls_for_early_termination() {
    let faint = splats(ring(12, |_, _| ()));
    assert!(!calls(&faint, Effect::EarlyTermination));
    let opaque = splats(ring(12, |_, logits| logits[..2].fill(9.0)));
    assert!(calls(&opaque, Effect::EarlyTermination));
    for scene in [faint, opaque] {
        let config = fitting(&scene);
        let mut forced = scene.clone();
        forced.set_choices(Choices::all());
        assert!(everything(&scene, &config) == everything(&forced, &config));
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(40))]

    /// Where nothing calls for early termination, no ray stops in any arithmetic: of Gaussians
    /// behind one another, of which all of the light may be lost.
    #[test]
    fn no_ray_stops_where_none_can(
        logits in proptest::collection::vec(-6f32..3.0, 1..12)
    ) {
        let count = logits.len();
        let cloud = Cloud::new(
            0,
            (0..count).map(|i| [0.0, 0.0, 0.03 * i as f32]).collect(),
            vec![[-1.0; 3]; count],
            vec![[1.0, 0.0, 0.0, 0.0]; count],
            logits,
            (0..count).map(|i| [0.4, 0.2 * i as f32, -0.3]).collect(),
        );
        let scene = splats(cloud.unwrap());
        let mut all = scene.clone();
        all.set_choices(Choices::all());
        let config = fitting(&scene);
        let rendered = all.render_fixed(&config, &mut Twins::new(&config)).unwrap();
        let lost = scene.lost_a_sample(&config).unwrap();
        if !scene.facts().thickness.can_stop(lost) {
            let mut without = scene.clone();
            without.set_choices(Choices::default().leave_out(Effect::EarlyTermination));
            let own = without.render_fixed(&config, &mut Twins::new(&config)).unwrap();
            prop_assert_eq!(own.picture, rendered.picture);
            // In floating point too, which stops elsewhere.
            let floats = [&all, &without].map(|scene| scene.render_float().unwrap().picture);
            prop_assert_eq!(&floats[0], &floats[1]);
        }
    }
}

/// Stored front to back, as one camera sees them, Gaussians need no sorting; two that change
/// places call for it.
#[test]
fn an_exchange_calls_for_sorting() {
    let scene = splats(ring(30, |_, _| ()));
    let Model::Splats(cloud) = scene.model() else {
        panic!("splats")
    };
    let view = crate::splats::View::new(cloud, scene.camera(), scene.profile()).unwrap();
    let mut order: Vec<usize> = view.splats().iter().map(|s| s.index).collect();
    assert_eq!(order.len(), 30, "all are seen");
    let sorted = splats(cloud.select(&order).unwrap());
    order.swap(3, 4);
    let exchanged = splats(cloud.select(&order).unwrap());
    assert!(!calls(&sorted, Effect::Sorting));
    assert!(calls(&exchanged, Effect::Sorting));
    let config = fitting(&sorted);
    let (once, twice) = (
        everything(&sorted, &config),
        everything(&exchanged, &config),
    );
    assert!(once == twice, "the order of the file changes nothing");
    let mut forced = sorted.clone();
    forced.set_choices(Choices::all());
    assert!(once == everything(&forced, &config));
    // From behind, the order is another.
    let behind = Camera::look_at(dvec3(-4.0, 3.0, -2.0), DVec3::ZERO, DVec3::Z, 0.8, 24, 24);
    let both = analysed(&sorted, &[*sorted.camera(), behind]);
    assert!(both.calls_for(Effect::Sorting));
    assert!(both.evidence(Effect::Sorting).contains("in 1 of 2 frames"));
}

/// A grid that is filled everywhere, but where it is changed.
fn block(layout: Layout, change: impl Fn(&mut Vec<f32>)) -> Scene {
    let points = [9, 8, 10];
    let channels = layout.channels();
    let mut features: Vec<f32> = (0..points.iter().product::<usize>() * channels)
        .map(|i| match i % channels {
            0 => 0.05,
            c if (c - 1) % layout.coefficients() == 0 => 0.3 + 0.01 * (i % 37) as f32,
            _ => 0.0,
        })
        .collect();
    change(&mut features);
    let grid = Grid::new(points, DVec3::splat(-0.4), 0.1, layout, features).unwrap();
    let mut scene = with_model(Model::Voxels(Box::new(grid)));
    let camera = Camera::look_at(dvec3(2.0, -1.5, 1.0), DVec3::ZERO, DVec3::Z, 0.8, 24, 24);
    scene.set_camera(camera);
    scene
}

/// One void voxel calls for the void test, and nothing else does.
#[test]
fn one_void_voxel_calls_for_the_void_test() {
    let channels = Layout::Constant.channels();
    let full = block(Layout::Constant, |_| ());
    // The corner vertex is one of a single voxel's eight: the others stay above 0.
    let dented = block(Layout::Constant, |f| f[0] = 0.0);
    let hole = block(Layout::Constant, |f| {
        for (x, y, z) in [(0, 0, 0), (1, 0, 0), (0, 1, 0), (1, 1, 0)] {
            for dz in 0..2 {
                f[(x + 9 * (y + 8 * (z + dz))) * channels] = 0.0;
            }
        }
    });
    for (scene, void) in [(&full, 0), (&dented, 0), (&hole, 1)] {
        let found = analysed(scene, &[*scene.camera()]);
        assert_eq!(found.calls_for(Effect::VoidTest), void > 0);
        let evidence = found.evidence(Effect::VoidTest);
        assert_eq!(evidence, format!("{void} of 504 cells are void"));
        let config = fitting(scene);
        let mut forced = scene.clone();
        forced.set_choices(Choices::all());
        assert!(everything(scene, &config) == everything(&forced, &config));
    }
    // Samples in the void are gathered where the test is left out.
    let gathered = |scene: &Scene| {
        let config = fitting(scene);
        let rendered = scene
            .render_fixed(&config, &mut Twins::new(&config))
            .unwrap();
        (rendered.counts.feature_vectors, rendered.picture)
    };
    let mut without = hole.clone();
    without.set_choices(Choices::default().leave_out(Effect::VoidTest));
    let (tested, more) = (gathered(&hole), gathered(&without));
    assert!(tested.0 < more.0 && tested.1 == more.1);
}

/// Colours that are stored as linear in the direction, but are not, are not computed so.
#[test]
fn one_linear_coefficient_calls_for_directions() {
    let plain = block(Layout::Linear, |_| ());
    let one = block(Layout::Linear, |f| f[13 * 400 + 7] = 0.25);
    let first = Effect::SphericalHarmonics(1);
    assert!(!calls(&plain, first) && calls(&one, first));
    for scene in [&plain, &one] {
        let config = fitting(scene);
        let mut forced = scene.clone();
        forced.set_choices(Choices::all());
        let all = everything(&forced, &config);
        assert!(everything(scene, &config) == all);
        let mut without = scene.clone();
        without.set_choices(Choices::default().leave_out(first));
        let missed = everything(&without, &config) == all;
        assert_eq!(missed, std::ptr::eq(scene, &plain));
    }
}

/// A grid without density asks nothing of any unit; a single positive density does.
#[test]
fn nothing_to_see_calls_for_no_unit() {
    let channels = Layout::Constant.channels();
    let empty = block(Layout::Constant, |f| {
        f.iter_mut().step_by(channels).for_each(|v| *v = 0.0);
    });
    let speck = block(Layout::Constant, |f| {
        f.iter_mut().step_by(channels).for_each(|v| *v = 0.0);
        f[200 * channels] = 0.5;
    });
    for (scene, seen) in [(&empty, false), (&speck, true)] {
        for effect in [Effect::Trilinear, Effect::Exponential] {
            assert_eq!(calls(scene, effect), seen, "{effect}");
        }
        let config = fitting(scene);
        let hardware = Hardware::of(scene, &config).unwrap();
        assert_eq!([hardware.gathers, hardware.computes], [seen; 2]);
        let mut twins = Twins::new(&config);
        let rendered = scene.render_fixed(&config, &mut twins).unwrap();
        assert_eq!(rendered.counts.feature_vectors > 0, seen);
        assert_eq!(twins.counts().elements.is_empty(), !seen);
    }
    // Nor does what no camera of the path sees.
    let mut away = speck.clone();
    away.set_camera(Camera::look_at(
        DVec3::X * 3.0,
        DVec3::X * 9.0,
        DVec3::Z,
        0.8,
        24,
        24,
    ));
    assert!(!calls(&away, Effect::Exponential) && !calls(&away, Effect::Trilinear));
}

/// Opaque and diffuse: no harmonics and no perceptron.
#[test]
fn an_opaque_diffuse_scene_calls_for_no_harmonics_and_no_perceptron() {
    for name in ["cairn:voxels", "city:voxels", "cairn:splats"] {
        let scene = opened(name, 24);
        let found = analysed(&scene, &[*scene.camera()]);
        for degree in 1..=3 {
            assert!(
                !found.calls_for(Effect::SphericalHarmonics(degree)),
                "{name}"
            );
        }
        assert!(!found.calls_for(Effect::ViewMlp), "{name}");
        assert!(found.calls_for(Effect::EarlyTermination), "{name}");
    }
    let chrome = opened("chrome:voxels", 24);
    assert!(calls(&chrome, Effect::SphericalHarmonics(1)));
    let dvgo = opened("cairn:dvgo", 24);
    assert!(calls(&dvgo, Effect::ViewMlp));
}

/// A path that stands still is never warped, whatever the window; one bit of one pose calls for
/// it.
#[test]
fn a_hair_of_motion_calls_for_warping() {
    let scene = opened("cairn:voxels", 24);
    let camera = *scene.camera();
    let still = vec![camera; 30];
    let mut moved = still.clone();
    let x = &mut moved[29].world_to_camera.translation.x;
    *x = x.next_up();
    let (found, hair) = (analysed(&scene, &still), analysed(&scene, &moved));
    for effect in [Effect::Warping, Effect::Disocclusion] {
        assert!(!found.calls_for(effect) && hair.calls_for(effect));
    }
    let evidence = found.evidence(Effect::Warping);
    assert_eq!(evidence, "the camera does not move in 30 frames");
    assert!(!analysed(&scene, &still[..1]).calls_for(Effect::Warping));
    // A camera that turns about its own place.
    let mut turned = still.clone();
    let turn = DAffine3::from_rotation_y(1e-9);
    turned[7].world_to_camera = turn * turned[7].world_to_camera;
    let near = (turned[7].position() - camera.position()).length();
    assert!(near < 1e-9 && turned[7] != camera);
    assert!(analysed(&scene, &turned).calls_for(Effect::Warping));

    for reference in [ReferenceFrom::Predicted, ReferenceFrom::First] {
        let options = PlanOptions {
            window: 8,
            reference,
            lead: None,
        };
        let plan = Plan::new(&still, &options).unwrap();
        let shown = |warps_still| {
            let mut rule = Profile::Potamoi.rule();
            rule.warps_still = warps_still;
            let warper = Warper {
                renderer: &scene,
                geometry: None,
                rule,
            };
            let frames = Sequence::new(warper, &still, &plan, &[]);
            frames.collect::<Result<Vec<_>, _>>().unwrap()
        };
        let frames = shown(false);
        assert!(
            frames == shown(true),
            "warping a still camera changes something"
        );
        for frame in &frames {
            assert_eq!(frame.reference, None);
            assert!(frame.target.shaded == frames[0].target.shaded);
        }
    }
    // What is skipped: each point lands where it was.
    let reference = crate::warp::Renderer::shade(&scene, &camera, None).unwrap();
    let warped = crate::warp::reproject(&reference, &camera, &camera);
    let mut surfaces = 0;
    for (pixel, depth) in reference.depth.iter().enumerate() {
        if crate::warp::is_surface(*depth) {
            assert_eq!(warped.at(pixel).unwrap().0, pixel as u32);
            surfaces += 1;
        }
    }
    assert!(surfaces > 50, "{surfaces}");
}

/// Operations that are declared are those that frames take.
fn operations_are_declared(name: &str) {
    let scene = opened(name, 16);
    let config = fitting(&scene);
    let mut twins = Twins::new(&config);
    scene.render_fixed(&config, &mut twins).unwrap();
    let mut declared = scene.operations(&config).unwrap();
    declared.sort();
    declared.dedup();
    let taken: Vec<OpCode> = twins.counts().elements.keys().copied().collect();
    assert_eq!(declared, taken, "{name}");
}

/// The hardware of a scene renders it to the same bits; splats have no reducer.
fn hardware_renders(name: &str, modes: Modes) {
    let scene = opened(name, 16);
    let config = fitting(&scene);
    let hardware = Hardware::of(&scene, &config).unwrap();
    let own = &hardware.config;
    assert_eq!(own.gu.modes, modes, "{name}");
    assert!(!hardware.left_out.is_empty(), "{name}");
    let shot = |config: &Config| {
        let rendered = scene.render_fixed(config, &mut Twins::new(config)).unwrap();
        (rendered.picture, rendered.counts)
    };
    assert!(shot(&config) == shot(own), "{name}");
    // Nothing more can be left out of it.
    let again = Hardware::of(&scene, own).unwrap();
    assert_eq!(again.config, *own, "{name}");
}

#[test]
fn hardware_of_a_scene_renders_it() {
    for (name, modes) in [
        ("garden", Modes::Unstructured),
        ("lantern", Modes::Structured),
        ("cairn:efficientnerf", Modes::Unstructured),
    ] {
        operations_are_declared(name);
        hardware_renders(name, modes);
    }
}

#[test]
#[ignore = "a minute: every representation"]
fn hardware_of_any_representation_renders_it() {
    for representation in Representation::ALL {
        let modes = match representation {
            Representation::Splats | Representation::EfficientNerf => Modes::Unstructured,
            Representation::Compact => Modes::Both,
            _ => Modes::Structured,
        };
        let name = format!("cairn:{}", representation.name());
        operations_are_declared(&name);
        hardware_renders(&name, modes);
    }
}

/// What was found of a model is found anew where what it depends on changes.
#[test]
fn facts_follow_rules_and_steps() {
    let mut scene = splats(ring(3, |_, _| ()));
    let stop = scene.facts().thickness.stop;
    scene.set_profile(crate::splats::Profile::Gsplat);
    assert_eq!(
        scene.facts().thickness.stop,
        crate::splats::Profile::Gsplat.rules().stop_below
    );
    assert!(stop > 0.0);
    let mut grid = block(Layout::Constant, |_| ());
    let samples = grid.facts().thickness.samples;
    grid.set_step(0.125).unwrap();
    assert!(grid.facts().thickness.samples > 3.5 * samples);
}

#[test]
fn names_are_found_and_others_refused() {
    assert_eq!(Choices::named("all").unwrap(), Effect::ALL);
    let degrees = Choices::named("spherical_harmonics").unwrap();
    assert_eq!(degrees.len(), 3);
    assert_eq!(
        Choices::named("spherical_harmonics:2").unwrap(),
        [Effect::SphericalHarmonics(2)]
    );
    let error = Choices::named("fog").unwrap_err().to_string();
    assert!(
        error.contains("`fog`") && error.contains("void_test"),
        "{error}"
    );
}

/// A coarser exponential, power or transmittance may take more of a ray, so that one that ends
/// early is ruled out later.
#[test]
fn coarser_units_let_rays_end_early_sooner() {
    let lost = |scene: &Scene, text: &str| {
        let config = Config::from_toml(text, "test").unwrap();
        scene.lost_a_sample(&config).unwrap()
    };
    let mut voxels = Scene::open("mist:voxels").unwrap();
    let paper = lost(&voxels, "");
    for text in [
        "vu.exp.iterations = 8",
        "vu.exp.one_minus_frac_bits = 12",
        "gu.feature_bits = 8",
    ] {
        assert!(lost(&voxels, text) > 2.0 * paper, "{text}");
    }
    let narrow = Precision {
        transmittance_bits: Some(10),
        ..Precision::default()
    };
    voxels.set_precision(narrow).unwrap();
    assert!(lost(&voxels, "") > 2.0 * paper);
    let mut splats = Scene::open("mist:splats").unwrap();
    let paper = lost(&splats, "");
    splats.set_precision(narrow).unwrap();
    assert!(lost(&splats, "") > 2.0 * paper);
}

/// Gaussians without opacity are projected, gathered and weighed all the same.
#[test]
fn gaussians_that_nobody_sees_take_exponentials() {
    let scene = splats(ring(20, |_, logits| logits.fill(f32::NEG_INFINITY)));
    let analysis = analysed(&scene, &[*scene.camera()]);
    assert!(analysis.calls_for(Effect::Exponential));
}

/// No ray of a grid loses more than its bound, along a diagonal of the densest nearly all of it.
#[test]
fn no_ray_of_a_grid_passes_more_than_its_bound() {
    use crate::voxels::{FloatOptions, render_float};
    for density in [0.02f32, 0.1, 0.3] {
        let channels = Layout::Constant.channels();
        let scene = block(Layout::Constant, |f| {
            f.iter_mut().step_by(channels).for_each(|v| *v = density);
        });
        let Model::Voxels(grid) = scene.model() else {
            panic!("{:?}", scene.model().algorithm());
        };
        let bound = scene.facts().thickness;
        let middle = dvec3(0.0, -0.05, 0.05);
        let mut least = 1f64;
        for corner in 0..8 {
            let side = |axis: usize| if corner >> axis & 1 == 1 { 1.0 } else { -1.0 };
            let eye = middle + 3.0 * dvec3(8.0 * side(0), 7.0 * side(1), 9.0 * side(2)).normalize();
            let camera = Camera::look_at(eye, middle, DVec3::Z, 0.4, 25, 25);
            let options = FloatOptions {
                terminate: false,
                ..FloatOptions::default()
            };
            let frame = render_float(grid, &camera, &options).unwrap();
            least = frame.transmittance.into_iter().fold(least, f64::min);
        }
        assert!(least >= bound.least_left(), "{density}: {least} {bound:?}");
        // The diagonal itself is a tenth shorter than what the bound allows for.
        assert!(
            -least.ln() > 0.8 * bound.depth,
            "{density}: {least} {bound:?}"
        );
    }
}
