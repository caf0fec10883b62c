//! What in the data calls for each effect.

use super::*;

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

/// Stored front to back, as one camera sees them, Gaussians need no sorting; two that change
/// places call for it.
#[test]
fn an_exchange_calls_for_sorting() {
    let scene = splats(ring(30, |_, _| ()));
    let Model::Splats(cloud) = scene.model() else {
        panic!("splats")
    };
    let view = potamoi_splats::View::new(cloud, scene.camera(), scene.profile()).unwrap();
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
            .render_fixed(&config, &mut ReferenceUnits::new(&config))
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
        let mut twins = ReferenceUnits::new(&config);
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
    let reference = potamoi_warp::Renderer::shade(&scene, &camera, None).unwrap();
    let warped = potamoi_warp::reproject(&reference, &camera, &camera);
    let mut surfaces = 0;
    for (pixel, depth) in reference.depth.iter().enumerate() {
        if potamoi_warp::is_surface(*depth) {
            assert_eq!(warped.at(pixel).unwrap().0, pixel as u32);
            surfaces += 1;
        }
    }
    assert!(surfaces > 50, "{surfaces}");
}

/// Gaussians without opacity are projected, gathered and weighed all the same.
#[test]
fn gaussians_that_nobody_sees_take_exponentials() {
    let scene = splats(ring(20, |_, logits| logits.fill(f32::NEG_INFINITY)));
    let analysis = analysed(&scene, &[*scene.camera()]);
    assert!(analysis.calls_for(Effect::Exponential));
}
