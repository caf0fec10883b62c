//! Frames that are composited more coarsely than their rules say.

use crate::Scene;
use potamoi_base::effects::Effect;
use potamoi_base::precision::Precision;
use potamoi_formats::config::{Config, PRESETS};
use potamoi_formats::units::OpCode;
use potamoi_reference::ReferenceUnits;

fn small(name: &str) -> Scene {
    let mut scene = crate::tests::opened(name);
    scene.set_size(Some(40), Some(40)).unwrap();
    scene
}

fn stopping(at: f64) -> Precision {
    Precision {
        stop_below: Some(at),
        ..Precision::default()
    }
}

/// A ray that stops leaves out less light than is left; none is brighter than the brightest.
#[test]
fn rays_that_stop_sooner_leave_out_no_more_than_is_left() {
    stop_sooner("lantern", [1e-3, 0.01, 0.1]);
    stop_sooner("cairn:dvgo", [1e-3, 0.01, 0.1]);
    stop_sooner("cairn:tensorf", [1e-6, 0.01, 0.1]);
    stop_sooner("cairn:ngp", [0.01, 0.1, 0.3]);
    stop_sooner("cairn:efficientnerf", [1e-3, 0.01, 0.1]);
}

/// The first is the rules'.
fn stop_sooner(name: &str, stops: [f64; 3]) {
    let mut scene = small(name);
    scene.set_size(Some(24), Some(24)).unwrap();
    let full = scene.render_float().unwrap().picture;
    let brightest = full.rgb.iter().flatten().copied().fold(1.0, f32::max);
    let mut last = u64::MAX;
    let fields = PRESETS.iter().find(|(name, _)| *name == "fields").unwrap();
    let config = match name {
        "lantern" => Config::paper(),
        _ => Config::from_toml(fields.1, "fields").unwrap(),
    };
    let shown = |scene: &Scene| {
        let rendered = scene.render_fixed(&config, &mut ReferenceUnits::new(&config));
        let rendered = rendered.unwrap();
        let work: u64 = rendered.counts.elements.values().sum();
        (work, rendered.picture)
    };
    let plain = shown(&scene);
    for at in stops {
        let mut sooner = scene.clone();
        sooner.set_precision(stopping(at)).unwrap();
        let picture = sooner.render_float().unwrap().picture;
        let off = (picture.rgb.iter().flatten().zip(full.rgb.iter().flatten()))
            .map(|(a, b)| (a - b).abs())
            .fold(0.0, f32::max);
        assert!(
            f64::from(off) <= at * f64::from(brightest) * 2.0,
            "{name}, {at}: {off}"
        );
        assert_eq!(at > stops[0], off > 0.0, "{name}, {at}: {off}");
        let (work, picture) = shown(&sooner);
        assert_eq!(at > stops[0], picture != plain.1, "{name}, {at}");
        assert!(work < last, "{name}, {at}: {work} of {last}");
        last = work;
    }
}

/// Work is left out of splats by both cut-offs; a width changes the picture, not the work.
#[test]
fn cut_offs_of_splats_leave_work_out() {
    let scene = small("garden");
    let config = Config::paper();
    let shown = |precision: Precision| {
        let mut scene = scene.clone();
        scene.set_precision(precision).unwrap();
        let rendered = scene.render_fixed(&config, &mut ReferenceUnits::new(&config));
        let rendered = rendered.unwrap();
        (rendered.counts.elements, rendered.picture)
    };
    let (plain, picture) = shown(Precision::default());
    assert!(shown(stopping(0.05)).0[&OpCode::Exp] < plain[&OpCode::Exp]);
    let fainter = Precision {
        alpha_min: Some(0.03),
        ..Precision::default()
    };
    assert!(shown(fainter).0[&OpCode::Multiply] < plain[&OpCode::Multiply]);
    let narrow = Precision {
        transmittance_bits: Some(8),
        ..Precision::default()
    };
    assert!(shown(narrow).1 != picture);
    let as_the_rules = Precision {
        stop_below: Some(1e-4_f32.into()),
        alpha_min: Some((1.0_f32 / 255.0).into()),
        transmittance_bits: Some(20),
        conic_bits: Some(30),
        hashed_levels: None,
    };
    assert_eq!(shown(as_the_rules), (plain, picture));
}

/// All levels are the default, none is the effect left out, and the finest is seen and costs
/// gathering.
#[test]
fn hashed_levels_are_left_out_from_the_finest() {
    let fields = PRESETS.iter().find(|(name, _)| *name == "fields").unwrap();
    let config = Config::from_toml(fields.1, "fields").unwrap();
    for name in ["cairn:ngp", "cairn:compact"] {
        let mut scene = crate::tests::opened(name);
        scene.set_size(Some(8), Some(8)).unwrap();
        let shown = |scene: &Scene| {
            let found = scene
                .render_fixed(&config, &mut ReferenceUnits::new(&config))
                .unwrap();
            (found.counts.feature_vectors, found.picture)
        };
        let own = |levels: usize| {
            let mut fewer = scene.clone();
            let precision = Precision {
                hashed_levels: Some(levels as u32),
                ..Precision::default()
            };
            fewer.set_precision(precision).unwrap();
            shown(&fewer)
        };
        let all = scene.facts().hashed_tables();
        let [none, fewer, every] = [0, all - 1, all].map(own);
        assert_eq!(every, shown(&scene), "{name}");
        let mut left_out = scene.clone();
        left_out.set_choices(left_out.choices().leave_out(Effect::HashLevels));
        assert_eq!(none, shown(&left_out), "{name}");
        assert!(none.1 != fewer.1 && fewer.1 != every.1, "{name}");
        assert!(fewer.0 < every.0, "{name}");
    }
}

#[test]
fn what_is_out_of_range_or_of_another_model_is_refused_by_name() {
    let refused = |name: &str, precision: Precision| {
        let error = small(name).set_precision(precision).err().unwrap();
        error.to_string()
    };
    assert!(refused("garden", stopping(f64::NAN)).contains("stop_below"));
    let conic = Precision {
        conic_bits: Some(31),
        ..Precision::default()
    };
    let narrow = Precision {
        transmittance_bits: Some(12),
        ..Precision::default()
    };
    assert!(refused("cairn:dvgo", narrow).contains("stop_below alone, of fields"));
    assert!(refused("garden", conic).contains("conic_bits"));
    let conic = Precision {
        conic_bits: Some(12),
        ..Precision::default()
    };
    let levels = Precision {
        hashed_levels: Some(17),
        ..Precision::default()
    };
    let said = refused("cairn:ngp", levels);
    assert!(
        said.contains("render.hashed_levels") && said.contains("17"),
        "{said}"
    );
    assert!(refused("garden", levels).contains("at most 0"));
    assert!(refused("lantern", conic).contains("stop_below and transmittance_bits"));
}
