//! Which rays may end early.

use super::*;

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
        let rendered = all.render_fixed(&config, &mut ReferenceUnits::new(&config)).unwrap();
        let lost = scene.lost_a_sample(&config).unwrap();
        if !scene.facts().thickness.can_stop(lost) {
            let mut without = scene.clone();
            without.set_choices(Choices::default().leave_out(Effect::EarlyTermination));
            let own = without.render_fixed(&config, &mut ReferenceUnits::new(&config)).unwrap();
            prop_assert_eq!(own.picture, rendered.picture);
            // In floating point too, which stops elsewhere.
            let floats = [&all, &without].map(|scene| scene.render_float().unwrap().picture);
            prop_assert_eq!(&floats[0], &floats[1]);
        }
    }
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

/// No ray of a grid loses more than its bound, along a diagonal of the densest nearly all of it.
#[test]
fn no_ray_of_a_grid_passes_more_than_its_bound() {
    use potamoi_fields::{FloatOptions, render_masked};
    for density in [0.02f32, 0.1, 0.3] {
        let channels = Layout::Constant.channels();
        let scene = block(Layout::Constant, |f| {
            f.iter_mut().step_by(channels).for_each(|v| *v = density);
        });
        let Model::Field(field) = scene.model() else {
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
            let frame = render_masked(&**field, &camera, &options, None).unwrap();
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
