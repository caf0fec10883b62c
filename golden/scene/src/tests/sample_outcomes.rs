//! What gathered samples change in a picture.

use potamoi_formats::config::{Config, VuSamples};
use potamoi_formats::units::OpCode;
use potamoi_march::SampleOutcomes;
use potamoi_reference::ReferenceUnits;

use crate::Scene;
use crate::render::FrameCounts;

fn counts(scene: &Scene, config: &Config) -> (FrameCounts, SampleOutcomes) {
    let mut units = ReferenceUnits::new(config);
    let counts = scene.render_fixed(config, &mut units).unwrap().counts;
    let outcomes = counts.sample_outcomes.unwrap();
    (counts, outcomes)
}

/// The vector unit's elements account for the samples of each kind: an opacity for each that is
/// gathered, a transmittance for each in front of its ray's end, three products for each with a
/// weight.
#[test]
fn every_sample_counts_once() {
    let config = Config::paper();
    let mut scene = crate::tests::opened("lantern");
    scene.set_size(Some(32), Some(32)).unwrap();
    let (counts, outcomes) = counts(&scene, &config);
    let of = |op| counts.elements[&op];
    assert_eq!(of(OpCode::OneMinusExp), outcomes.total());
    let chained = outcomes.total() - outcomes.behind;
    let opacities = of(OpCode::OneMinusExp);
    let expected = opacities + chained + 3 * outcomes.composited;
    assert_eq!(of(OpCode::Multiply), expected, "{outcomes:?}");
    let SampleOutcomes {
        composited,
        transparent,
        behind,
        ..
    } = outcomes;
    assert!(
        composited > 0 && transparent > 0 && behind > 0,
        "{outcomes:?}"
    );
}

/// Samples of opacity 0 need no exponential: no code of the picture changes, nor any other work. They are
/// transparent, or behind the end of their ray.
#[test]
fn samples_that_cannot_count_have_no_exponential() {
    for (name, preset) in [
        ("lantern", "paper"),
        ("cairn:dvgo", "fields"),
        ("moons:efficientnerf", "fields"),
    ] {
        let all = Config::preset(preset).unwrap();
        let mut fewer = all.clone();
        fewer.vu.samples = VuSamples::ThatMayCount;
        let mut scene = crate::tests::opened(name);
        scene.set_size(Some(24), Some(24)).unwrap();
        let [all, fewer] = [all, fewer].map(|config| {
            let mut units = ReferenceUnits::new(&config);
            scene.render_fixed(&config, &mut units).unwrap()
        });
        assert!(all.picture == fewer.picture, "{name}");
        let of = |own: &FrameCounts, op| own.elements.get(&op).copied().unwrap_or_default();
        let (before, after) = (&all.counts, &fewer.counts);
        for op in OpCode::ALL {
            let [before, after] = [before, after].map(|own| of(own, op));
            match op {
                OpCode::OneMinusExp => assert!(after < before, "{name}: {after} of {before}"),
                _ => assert_eq!(after, before, "{name}: {op:?}"),
            }
        }
        let outcomes = before.sample_outcomes.unwrap();
        let opacities = of(after, OpCode::OneMinusExp);
        let needed = outcomes.composited + outcomes.without_weight;
        assert_eq!(before.sample_outcomes, after.sample_outcomes);
        assert!(
            (needed..=needed + outcomes.behind).contains(&opacities),
            "{name}: {opacities}"
        );
    }
}

/// Splats have no samples.
#[test]
fn splats_have_no_samples() {
    let config = Config::paper();
    let mut scene = crate::tests::opened("garden");
    scene.set_size(Some(8), Some(8)).unwrap();
    let mut units = ReferenceUnits::new(&config);
    let counts = scene.render_fixed(&config, &mut units).unwrap().counts;
    assert_eq!(counts.sample_outcomes, None);
}
