//! Units without what is not called for.

use super::*;

/// Operations that are declared are those that frames take.
fn operations_are_declared(name: &str) {
    let scene = opened(name, 16);
    let config = fitting(&scene);
    let mut twins = ReferenceUnits::new(&config);
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
        let rendered = scene
            .render_fixed(config, &mut ReferenceUnits::new(config))
            .unwrap();
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
    scene.set_profile(potamoi_splats::Profile::Gsplat);
    assert_eq!(
        scene.facts().thickness.stop,
        potamoi_splats::Profile::Gsplat.rules().stop_below
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
