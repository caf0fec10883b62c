//! Hardware that a scene calls for, and the system's model, follow the analysis.
use potamoi_analysis::Hardware;
use potamoi_base::camera::Camera;
use potamoi_base::effects::Choices;
use potamoi_cycles::effect_meter::{EffectCycles, EffectMeter};
use potamoi_cycles::mac_array::MacArray;
use potamoi_formats::config::Config;
use potamoi_reference::ReferenceUnits;
use potamoi_reference::observer::Observed;
use potamoi_rtl::RtlUnits;
use potamoi_scene::{BUILTIN, Scene};
use potamoi_system::system_model::work::FrameWork;

fn opened(name: &str, width: u32) -> Scene {
    let mut scene = Scene::open(name).unwrap();
    scene.set_size(Some(width), None).unwrap();
    scene
}

/// Picture, counts and cycles on Verilated units are those of the whole configuration, and each
/// unit is built with the first work for it.
#[test]
fn reduced_units_give_the_same_bits_in_the_same_cycles() {
    let few = "[gu]\nbanks = 8\nports = 1\n[vu]\nlanes = 4\n";
    let config = Config::from_toml(few, "few").unwrap();
    for name in ["garden", "lantern"] {
        let scene = opened(name, 12);
        let hardware = Hardware::of(&scene, &config).unwrap();
        assert_ne!(hardware.config, config);
        let shot = |own: &Config| {
            let mut units = RtlUnits::new(own);
            let rendered = scene.render_fixed(&config, &mut units).unwrap();
            assert_eq!(units.instantiated(), [true, true, false]);
            (rendered.picture, rendered.counts, units.cycles())
        };
        assert!(shot(&config) == shot(&hardware.config), "{name}");
    }
    // What no camera sees needs neither unit.
    let mut away = opened("lantern", 16);
    let up = glam::DVec3::Z;
    let eye = glam::DVec3::X * 9.0;
    away.set_camera(Camera::look_at(eye, eye * 2.0, up, 0.8, 16, 16));
    let mut units = RtlUnits::new(&config);
    away.render_fixed(&config, &mut units).unwrap();
    assert_eq!(units.instantiated(), [false; 3]);
}

/// Modelled cycles of the reduced configuration are those of the whole one, and forcing changes
/// nothing that the system's model counts.
#[test]
fn modelled_work_is_the_same_forced_and_reduced() {
    for name in ["garden", "lantern"] {
        modelled_the_same(name, 12);
    }
}

#[test]
#[ignore = "minutes: the eight analytic scenes"]
fn modelled_work_of_all_scenes_is_the_same_forced_and_reduced() {
    for name in &BUILTIN[2..] {
        for representation in ["voxels", "splats"] {
            modelled_the_same(&format!("{name}:{representation}"), 48);
        }
    }
}

fn modelled_the_same(name: &str, width: u32) {
    let config = Config::paper();
    let scene = opened(name, width);
    let hardware = Hardware::of(&scene, &config).unwrap();
    let metered = |own: &Config| -> EffectCycles {
        let mut twins = ReferenceUnits::new(own);
        let mut meter = EffectMeter::new(own);
        let mut units = Observed::new(&mut twins, own).by(&mut meter);
        scene.render_fixed(&config, &mut units).unwrap();
        meter.cycles()
    };
    let whole = metered(&config);
    assert_eq!(whole, metered(&hardware.config), "{name}");
    assert!(whole.gather > 100 && whole.exponentials > 100, "{name}");
    let mut forced = scene.clone();
    forced.set_choices(Choices::all());
    let work =
        |scene: &Scene| FrameWork::count(scene, &config, MacArray::PAPER, 1 << 19, None).unwrap();
    assert_eq!(work(&scene), work(&forced), "{name}");
}
